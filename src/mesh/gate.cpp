// The steps, in the order of the codes: what the numbers say (index, finite, empty, range), repairs of the polygon soup,
// then shells: edges with too many faces, orientation, flatness, holes.
#include "sqmap/mesh/gate.h"

#include "sqmap/mesh/self_intersection.h"

#include "shells.h"
#include "surface.h"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace sqmap::mesh {
namespace {

constexpr double k_sliver_height = 1e-9;     // of the box's diagonal: lower triangles have no area
constexpr double k_thin_height = 1e-6;       // of the diagonal: extra faces this low are what rounding left of such
constexpr double k_weld_distance = 1e-7;     // of the diagonal: positions closer may be one vertex
constexpr double k_flat_thickness = 1e-5;    // of the diagonal: thinner is a sheet; float and a fit have nothing to hold on to
constexpr double k_range_ratio = 1e15;       // double has 16 digits
constexpr double k_range_size = 1e100;       // cubes of larger or (inverted) smaller sizes leave double's range
constexpr double k_unit_hint = 50;           // a thing of 50 m is rare, one of 50 mm is not
constexpr std::size_t k_max_polygon = 1024;  // cutting ears takes the cube of it

struct Refusal {
    Diagnosis diagnosis;
};

[[noreturn]] void refuse(const char* code, std::string element, std::string message, std::string cure)
{
    throw Refusal{{code, std::move(element), std::move(message), std::move(cure)}};
}

std::string number(std::uint64_t n) { return std::to_string(n); }
std::string element(const char* kind, std::uint64_t zero_based) { return kind + (" " + number(zero_based + 1)); }

struct Box {
    Vec3d lo{}, hi{};
    [[nodiscard]] Vec3d size() const { return hi - lo; }
};

class Gate {
public:
    Gate(const PolygonView& in, const GateOptions& options) : in_(in), options_(options) {}

    GateResult judge()
    {
        try {
            check_numbers();
            make_triangles();
            clean();
            make_shells();
            finish();
            out_.verdict = out_.repairs.empty() ? Verdict::Accept : Verdict::Repaired;
        } catch (Refusal& refusal) {
            out_.verdict = Verdict::Refused;
            out_.diagnosis = std::move(refusal.diagnosis);
            out_.mesh = {};
            out_.solid = false;
        }
        return std::move(out_);
    }

private:
    // --- what the numbers say -------------------------------------------------------------------------------------

    void check_numbers()
    {
        const std::size_t polygon_count = in_.offsets.empty() ? 0 : in_.offsets.size() - 1;
        used_.assign(in_.positions.size(), false);
        for (std::size_t f = 0; f < polygon_count; ++f)
            for (std::uint32_t i = in_.offsets[f]; i < in_.offsets[f + 1]; ++i) {
                const std::int64_t v = in_.indices[i];
                if (v < 0 || static_cast<std::uint64_t>(v) >= in_.positions.size())
                    refuse("E_INDEX", element("face", f), "a corner names a vertex that is not there; the file has " + number(in_.positions.size()),
                           "export the mesh again");
                used_[static_cast<std::size_t>(v)] = true;
            }
        for (std::size_t v = 0; v < in_.positions.size(); ++v) {
            const Vec3d p = in_.positions[v];
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                refuse("E_NONFINITE", element("vertex", v), "a coordinate is not a finite number", "correct or remove the vertex");
        }
        if (polygon_count == 0) refuse("E_EMPTY", "mesh", number(in_.positions.size()) + " vertices and no face", "give a mesh with faces, not points");
        check_range();
    }

    void check_range()
    {
        box_ = {{1e308, 1e308, 1e308}, {-1e308, -1e308, -1e308}};
        std::array<std::vector<double>, 3> along;
        for (std::size_t v = 0; v < used_.size(); ++v)
            for (int k = 0; used_[v] && k < 3; ++k) {
                box_.lo[k] = std::min(box_.lo[k], in_.positions[v][k]);
                box_.hi[k] = std::max(box_.hi[k], in_.positions[v][k]);
                along[static_cast<std::size_t>(k)].push_back(in_.positions[v][k]);
            }
        const char* cure = "remove stray vertices, or move and scale the mesh towards unit size at the origin";
        if (along[0].empty()) refuse("E_RANGE", "mesh", "the faces have no corners", cure);
        // The largest side, not the diagonal: squares may overflow where the size does not.
        const Vec3d size = box_.size();
        const double extent = std::max({size.x, size.y, size.z});
        if (!(extent > 0)) refuse("E_RANGE", "mesh", "all vertices lie in one point", cure);
        if (!(extent < k_range_size) || extent < 1 / k_range_size) refuse("E_RANGE", "mesh", "the size is beyond what double precision can cube", cure);

        // Median extent: half of the vertices are within it of the median vertex. One stray vertex does not change it.
        const auto median = [](std::vector<double>& values) {
            const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
            std::nth_element(values.begin(), middle, values.end());
            return *middle;
        };
        Vec3d centre;
        for (int k = 0; k < 3; ++k) centre[k] = median(along[static_cast<std::size_t>(k)]);
        const auto distance = [](Vec3d a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); };
        std::vector<double> distances;
        for (std::size_t v = 0; v < used_.size(); ++v)
            if (used_[v]) distances.push_back(distance(in_.positions[v] - centre));
        double median_extent = median(distances);
        if (median_extent == 0) median_extent = extent;
        for (std::size_t v = 0; v < used_.size(); ++v)
            if (used_[v] && distance(in_.positions[v]) > k_range_ratio * median_extent)
                refuse("E_RANGE", element("vertex", v), "a coordinate is more than 1e15 times the size of the rest", cure);
    }

    // --- polygons to triangles --------------------------------------------------------------------------------------

    void make_triangles()
    {
        const auto polygon_count = static_cast<std::uint32_t>(in_.offsets.size() - 1);
        std::vector<std::uint32_t> new_number(in_.positions.size(), k_none);
        for (std::uint32_t v = 0; v < used_.size(); ++v)
            if (used_[v]) {
                new_number[v] = static_cast<std::uint32_t>(surface_.points.size());
                const Vec3d p = in_.positions[v];
                surface_.points.push_back({p.x + 0.0, p.y + 0.0, p.z + 0.0});  // -0 is 0, or equal positions would differ
                surface_.source.push_back(v);
            }
        if (surface_.points.size() < used_.size()) note("unused_vertices", used_.size() - surface_.points.size());

        const Vec3d size = box_.size();
        diagonal_ = norm(size);
        surface_.faces.reserve(polygon_count);
        std::uint64_t cut = 0, degenerate = 0;
        std::vector<std::uint32_t> corners;
        std::vector<Vec3d> places;
        for (std::uint32_t f = 0; f < polygon_count; ++f) {
            corners.clear();
            const std::size_t degree = in_.offsets[f + 1] - in_.offsets[f];
            if (degree > k_max_polygon)
                refuse("E_LIMIT", element("face", f), "a polygon of " + number(degree) + " corners; the limit is " + number(k_max_polygon),
                       "cut large polygons into triangles");
            for (std::uint32_t i = in_.offsets[f]; i < in_.offsets[f + 1]; ++i) {
                const std::uint32_t v = new_number[static_cast<std::size_t>(in_.indices[i])];
                if (corners.empty() || corners.back() != v) corners.push_back(v);
            }
            while (corners.size() > 1 && corners.front() == corners.back()) corners.pop_back();
            const bool repeats = corners.size() < degree;
            if (corners.size() < 3 || repeats) ++degenerate;
            if (corners.size() < 3) continue;
            if (corners.size() == 3) {
                surface_.faces.push_back({{corners[0], corners[1], corners[2]}, f});
                continue;
            }
            places.clear();
            for (const std::uint32_t v : corners) places.push_back(surface_.points[v]);
            for (const auto& t : triangulated(places)) surface_.faces.push_back({{corners[t[0]], corners[t[1]], corners[t[2]]}, f});
            ++cut;
        }
        if (cut > 0) note("triangulated", cut);
        degenerate_count_ += degenerate;
    }

    // --- repairs of the soup ------------------------------------------------------------------------------------------

    void clean()
    {
        drop_faces();
        // A mesh that is closed as it is indexed keeps its indices: shells that touch may do so on purpose.
        if (!is_closed(surface_.faces) && !drop_thin_faces()) {
            std::uint64_t welded = weld(coincident(surface_.points));
            if (welded > 0) drop_faces();
            if (!is_closed(surface_.faces) && !drop_thin_faces()) welded += weld_nearby();
            if (welded > 0) note("welded_vertices", welded);
        }
        if (degenerate_count_ > 0) note("degenerate_faces", degenerate_count_);
        if (duplicate_count_ > 0) note("duplicate_faces", duplicate_count_);
    }

    /// Gives vertices of one place one number; returns how many vertices that saves.
    std::uint64_t weld(const std::vector<std::uint32_t>& first)
    {
        std::uint64_t saved = 0;
        for (std::uint32_t v = 0; v < first.size(); ++v) saved += first[v] != v;
        if (saved == 0) return 0;
        for (Face& f : surface_.faces)
            for (std::uint32_t& v : f.v) v = first[v];
        saved -= std::min(saved, already_welded_);
        already_welded_ += saved;
        return saved;
    }

    std::uint64_t weld_nearby()
    {
        const Surface before = surface_;
        const auto counts = std::tuple(degenerate_count_, duplicate_count_, already_welded_);
        const Vec3d centre = box_.lo + 0.5 * box_.size();
        std::vector<Vec3d> local;
        for (const Vec3d& p : surface_.points) local.push_back(p - centre);
        const std::uint64_t saved = weld(coincident_within(local, k_weld_distance * diagonal_));
        if (saved > 0) {
            drop_faces();
            if (is_closed(surface_.faces)) return saved;
        }
        surface_ = before;
        std::tie(degenerate_count_, duplicate_count_, already_welded_) = counts;
        return 0;
    }

    /// Extra faces that are thin only up to the rounding of a text file; undone unless the mesh closes without them.
    bool drop_thin_faces()
    {
        const std::vector<Face> before = surface_.faces;
        const std::uint64_t count = degenerate_count_;
        drop_loose_slivers(k_thin_height);
        if (is_closed(surface_.faces)) return true;
        surface_.faces = before;
        degenerate_count_ = count;
        return false;
    }

    void drop_faces()
    {
        const std::size_t before = surface_.faces.size();
        std::erase_if(surface_.faces, [](const Face& f) { return f.v[0] == f.v[1] || f.v[1] == f.v[2] || f.v[2] == f.v[0]; });
        degenerate_count_ += before - surface_.faces.size();
        drop_duplicates();
        drop_loose_slivers(k_sliver_height);
    }

    [[nodiscard]] bool is_sliver(const Face& f, double height) const
    {
        const Vec3d a = surface_.points[f.v[0]], b = surface_.points[f.v[1]], c = surface_.points[f.v[2]];
        // In units of the diagonal: squares of small lengths must not vanish.
        const Vec3d u = (b - a) / diagonal_, w = (c - a) / diagonal_;
        const double longest = std::sqrt(std::max({norm_sq(u), norm_sq(w), norm_sq(w - u)}));
        return norm(cross(u, w)) <= height * longest;
    }

    /// Faces without area that are not between exactly three neighbours: taking them away opens nothing.
    void drop_loose_slivers(double height)
    {
        std::vector<bool> sliver(surface_.faces.size());
        bool any = false;
        for (std::size_t f = 0; f < sliver.size(); ++f) any = (sliver[f] = is_sliver(surface_.faces[f], height)) || any;
        while (any) {
            std::vector<bool> loose(surface_.faces.size(), false);
            any = false;
            for_each_edge(edge_uses(surface_.faces), [&](std::span<const EdgeUse> edge) {
                if (edge.size() == 2) return;
                for (const EdgeUse& u : edge)
                    if (sliver[u.half / 3]) any = loose[u.half / 3] = true;
            });
            std::size_t kept = 0;
            for (std::size_t f = 0; f < surface_.faces.size(); ++f)
                if (!loose[f]) {
                    surface_.faces[kept] = surface_.faces[f];
                    sliver[kept++] = sliver[f];
                }
            degenerate_count_ += surface_.faces.size() - kept;
            surface_.faces.resize(kept);
            sliver.resize(kept);
        }
    }

    /// Of faces with the same corners one stays. Two that are back to back cancel where the rest closes without them:
    /// a wall inside a solid, which no winding number sees.
    void drop_duplicates()
    {
        const auto& faces = surface_.faces;
        std::vector<std::uint32_t> order(faces.size());
        std::iota(order.begin(), order.end(), 0u);
        std::vector<Triangle> key(faces.size());
        for (std::size_t f = 0; f < faces.size(); ++f) {
            key[f] = faces[f].v;
            std::sort(key[f].begin(), key[f].end());
        }
        std::sort(order.begin(), order.end(), [&](auto a, auto b) { return key[a] != key[b] ? key[a] < key[b] : a < b; });
        const auto is_even = [&](std::uint32_t f) {
            const Triangle& v = faces[f].v;
            return (v[0] < v[1]) + (v[1] < v[2]) + (v[2] < v[0]) == 2;
        };
        std::vector<bool> keep(faces.size(), false), keep_uncancelled(faces.size(), false);
        bool any_opposite = false, any_left = false;
        for (std::size_t i = 0; i < order.size();) {
            std::size_t j = i;
            bool both = false;
            for (; j < order.size() && key[order[j]] == key[order[i]]; ++j) both = both || is_even(order[j]) != is_even(order[i]);
            keep[order[i]] = true;
            keep_uncancelled[order[i]] = !both;
            any_opposite = any_opposite || both;
            any_left = any_left || !both;
            i = j;
        }
        const auto kept = [&](const std::vector<bool>& keeps) {
            std::vector<Face> out;
            for (std::size_t f = 0; f < faces.size(); ++f)
                if (keeps[f]) out.push_back(faces[f]);
            return out;
        };
        std::vector<Face> left;
        if (any_opposite && any_left) left = kept(keep_uncancelled);
        if (left.empty() || !is_closed(left)) left = kept(keep);
        duplicate_count_ += faces.size() - left.size();
        surface_.faces = std::move(left);
    }

    // --- shells -------------------------------------------------------------------------------------------------------

    std::string edge_name(const EdgeUse& e) const
    {
        return "edge " + number(surface_.source[e.lo] + 1) + "-" + number(surface_.source[e.hi] + 1);
    }

    void count_edges()
    {
        MeshFacts& facts = out_.facts;
        facts.boundary_edge_count = facts.nonmanifold_edge_count = 0;
        first_boundary_.reset();
        first_nonmanifold_.reset();
        for_each_edge(edge_uses(surface_.faces), [&](std::span<const EdgeUse> edge) {
            if (edge.size() == 1) {
                ++facts.boundary_edge_count;
                if (!first_boundary_) first_boundary_ = edge[0];
            } else if (edge.size() > 2) {
                ++facts.nonmanifold_edge_count;
                if (!first_nonmanifold_) first_nonmanifold_ = edge[0];
            }
        });
    }

    void make_shells()
    {
        MeshFacts& facts = out_.facts;
        count_edges();
        Orientation orientation = orient(surface_);
        Pairing pairing = paired(surface_, orientation);
        if (first_nonmanifold_ && (pairing.unpaired || first_boundary_))
            refuse("E_NONMANIFOLD", edge_name(pairing.unpaired ? *pairing.unpaired : *first_nonmanifold_),
                   number(facts.nonmanifold_edge_count) + " edges have more than two faces and no split of vertices leaves closed shells",
                   "remove fins and inner walls, so that every edge has two faces");
        if (orientation.conflict)
            refuse("E_ORIENT", element("face", surface_.faces[*orientation.conflict].polygon), "the faces cannot be oriented alike: the surface has one side",
                   "cut the surface where it is twisted, or remove the twisted part");
        if (orientation.turned_count > 0) note("reoriented", orientation.turned_count);

        check_flat();
        if (facts.boundary_edge_count > 0 && !options_.accept_surface)
            refuse("E_OPEN", edge_name(*first_boundary_), number(facts.boundary_edge_count) + " edges have one face: the mesh encloses no volume",
                   "close the mesh, or use --repair holes for small holes, --surface for a surface without inside, --thickness for a sheet");
        if (const std::uint32_t made = split_fans(surface_, pairing.mate); made > 0) note("split_vertices", made);
        component_ = components(surface_.faces.size(), pairing.mate);
    }

    /// Points about the origin in units of the diagonal, for everything that multiplies coordinates.
    [[nodiscard]] std::vector<Vec3d> local_points() const
    {
        const Vec3d centre = box_.lo + 0.5 * box_.size();
        std::vector<Vec3d> out;
        out.reserve(surface_.points.size());
        for (const Vec3d& p : surface_.points) out.push_back((p - centre) / diagonal_);
        return out;
    }

    void check_flat()
    {
        const std::vector<Vec3d> points = local_points();
        Vec3d mean{};
        double area = 0, volume = 0;
        for (const Face& f : surface_.faces) {
            const Vec3d a = points[f.v[0]], b = points[f.v[1]], c = points[f.v[2]];
            const double w = 0.5 * norm(cross(b - a, c - a));
            area += w;
            mean += w / 3.0 * (a + b + c);
            volume += six_volumes(points, f.v) / 6;
        }
        const char* cure = "give it a volume with --thickness, or model both sides";
        if (!(area > 0)) refuse("E_FLAT", "mesh", "no face with an area is left", cure);
        mean = mean / area;
        Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
        for (const Face& f : surface_.faces) {
            const Vec3d corner[3] = {points[f.v[0]] - mean, points[f.v[1]] - mean, points[f.v[2]] - mean};
            const double w = 0.5 * norm(cross(corner[1] - corner[0], corner[2] - corner[0])) / (3 * area);
            for (const Vec3d& p : corner) {
                const Eigen::Vector3d x(p.x, p.y, p.z);
                moments += w * x * x.transpose();
            }
        }
        const double spread = std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvalues()[0]));
        if (spread < k_flat_thickness) refuse("E_FLAT", "mesh", "all faces lie in one plane", cure);
        if (out_.facts.boundary_edge_count == 0 && 2 * std::abs(volume) < k_flat_thickness * area)
            refuse("E_FLAT", "mesh", "the mesh encloses no volume: it is a sheet folded onto itself", cure);
    }

    // --- the result ---------------------------------------------------------------------------------------------------

    void finish()
    {
        MeshFacts& facts = out_.facts;
        out_.solid = facts.boundary_edge_count == 0;
        facts.is_closed = out_.solid;
        const std::vector<Vec3d> points = local_points();
        if (out_.solid) {
            const Shells shells = turn_outward(surface_, points, component_);
            if (shells.turned_count > 0) {
                note("flipped", shells.turned_count);
                warn("W_FLIPPED", shells.turned_count, number(shells.turned_count) + " faces were inside out and have been turned");
            }
            if (shells.cavity_count > 0) warn("W_CAVITY", shells.cavity_count, number(shells.cavity_count) + " shells are cavities inside others");
        } else {
            warn("W_SURFACE", facts.boundary_edge_count, "open surface with " + number(facts.boundary_edge_count) + " boundary edges: it has no inside");
        }
        std::vector<std::uint32_t> roots = component_;
        std::sort(roots.begin(), roots.end());
        facts.component_count = static_cast<std::uint64_t>(std::unique(roots.begin(), roots.end()) - roots.begin());

        write_mesh(points);
        if (out_.solid) {
            const auto v = static_cast<std::int64_t>(facts.vertex_count), f = static_cast<std::int64_t>(facts.triangle_count);
            facts.genus = static_cast<std::int64_t>(facts.component_count) - (v - f / 2) / 2;  // V - 3F/2 + F = 2 (C - genus)
        }
        if (!out_.repairs.empty() && options_.repair == Repair::None) refuse_repair();

        count_intersections();

        const Vec3d size = facts.box_max - facts.box_min;
        if (!options_.unit && std::max({size.x, size.y, size.z}) > k_unit_hint)
            warn("W_UNIT", 0, "more than 50 units wide: if that is not metres, say so with --unit (such as --unit mm)");
    }

    void count_intersections()
    {
        MeshFacts& facts = out_.facts;
        const SelfIntersections found = find_self_intersections(out_.mesh, options_.max_intersections);
        facts.self_intersecting_pairs = found.pair_count;
        facts.intersections_complete = found.is_complete;
        if (found.pair_count > 0)
            warn("W_SELFX", found.pair_count,
                 (found.is_complete ? "" : "at least ") + number(found.pair_count) +
                     " pairs of faces intersect; the solid is where the winding number is positive");
    }

    /// Vertices that share a position are told apart by their faces, so that file order has no say in the canonical one.
    void write_mesh(const std::vector<Vec3d>& points)
    {
        Mesh mesh;
        std::vector<std::uint32_t> number_of(surface_.points.size(), k_none), order;
        for (const Face& f : surface_.faces)
            for (const std::uint32_t v : f.v)
                if (number_of[v] == k_none) {
                    number_of[v] = 0;
                    order.push_back(v);
                }
        const auto as_tuple = [&](Vec3d p) { return std::tuple(p.x, p.y, p.z); };
        const auto place = [&](std::uint32_t v) { return as_tuple(surface_.points[v]); };
        using Key = std::pair<std::tuple<double, double, double>, std::tuple<double, double, double>>;
        std::vector<Key> key(surface_.points.size(), {{1e308, 0, 0}, {}});
        for (const Face& f : surface_.faces)
            for (int k = 0; k < 3; ++k) key[f.v[k]] = std::min(key[f.v[k]], Key{place(f.v[(k + 1) % 3]), place(f.v[(k + 2) % 3])});
        std::sort(order.begin(), order.end(), [&](auto a, auto b) {
            return place(a) != place(b) ? place(a) < place(b) : (key[a] != key[b] ? key[a] < key[b] : a < b);
        });
        const double unit = options_.unit.value_or(1.0);
        for (std::uint32_t i = 0; i < order.size(); ++i) {
            number_of[order[i]] = i;
            mesh.vertices.push_back(unit * surface_.points[order[i]]);
        }
        MeshFacts& facts = out_.facts;
        double area = 0, volume = 0;
        for (const Face& f : surface_.faces) {
            mesh.triangles.push_back({number_of[f.v[0]], number_of[f.v[1]], number_of[f.v[2]]});
            area += 0.5 * norm(cross(points[f.v[1]] - points[f.v[0]], points[f.v[2]] - points[f.v[0]]));
            volume += six_volumes(points, f.v) / 6;
        }
        const double scale = diagonal_ * unit;
        facts.area = area * scale * scale;
        facts.volume = out_.solid ? volume * scale * scale * scale : 0;
        facts.vertex_count = mesh.vertices.size();
        facts.triangle_count = mesh.triangles.size();
        facts.box_min = facts.box_max = mesh.vertices.front();
        for (const Vec3d& p : mesh.vertices)
            for (int k = 0; k < 3; ++k) {
                facts.box_min[k] = std::min(facts.box_min[k], p[k]);
                facts.box_max[k] = std::max(facts.box_max[k], p[k]);
            }
        out_.mesh = canonicalized(mesh);
    }

    [[noreturn]] void refuse_repair()
    {
        std::string list;
        for (const RepairNote& r : out_.repairs) list += (list.empty() ? "" : ", ") + r.kind + " (" + number(r.count) + ")";
        out_.repairs.clear();
        refuse("E_REPAIR", "mesh", "it needs repairs that are forbidden: " + list, "allow them with --repair safe");
    }

    void note(const char* kind, std::uint64_t count) { out_.repairs.push_back({kind, count}); }
    void warn(const char* code, std::uint64_t count, std::string message) { out_.warnings.push_back({code, count, std::move(message)}); }

    const PolygonView& in_;
    const GateOptions& options_;
    GateResult out_;
    std::vector<bool> used_;
    Box box_;
    double diagonal_ = 0;
    Surface surface_;
    std::uint64_t degenerate_count_ = 0, duplicate_count_ = 0, already_welded_ = 0;
    std::optional<EdgeUse> first_boundary_, first_nonmanifold_;
    std::vector<std::uint32_t> component_;
};

}  // namespace

GateResult admit(const PolygonView& polygons, const GateOptions& options) { return Gate(polygons, options).judge(); }

}  // namespace sqmap::mesh
