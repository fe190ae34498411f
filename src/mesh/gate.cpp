// The steps, in the order of the codes: what the numbers say (index, finite, empty, range), repairs of the polygon soup,
// then shells: edges with too many faces, orientation, flatness, holes.
#include "sqmap/mesh/gate.h"

#include "sqmap/mesh/self_intersection.h"

#include "holes.h"
#include "shells.h"
#include "surface.h"

#include <Eigen/Eigenvalues>

#include <cmath>
#include <cstdio>

namespace sqmap::mesh {
namespace {

constexpr double k_sliver_height = 1e-9;     // of the box's diagonal: lower triangles have no area
constexpr double k_thin_height = 1e-6;       // of the diagonal: extra faces this low are what rounding left of such
constexpr double k_weld_distance = 1e-7;     // of the diagonal: positions closer may be one vertex
constexpr double k_flat_thickness = 1e-5;    // of the area's root: thinner is a sheet, a fit has nothing to hold on to
constexpr double k_plane_rounding = 1e-12;   // of the diagonal: what rounding makes of a plane
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
            check_components();
            make_shells();
            finish();
            out_.verdict = out_.repairs.empty() ? Verdict::Accept : Verdict::Repaired;
        } catch (Refusal& refusal) {
            out_.verdict = Verdict::Refused;
            out_.diagnosis = std::move(refusal.diagnosis);
            out_.mesh = {};
            out_.repairs.clear();
            out_.warnings.clear();
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
                    refuse("E_INDEX", element("face", f),
                           "a corner names a vertex that is not there; the file has " + number(in_.positions.size()),
                           "export the mesh again");
                used_[static_cast<std::size_t>(v)] = true;
            }
        for (std::size_t v = 0; v < in_.positions.size(); ++v) {
            const Vec3d p = in_.positions[v];
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                refuse("E_NONFINITE", element("vertex", v), "a coordinate is not a finite number",
                       "correct or remove the vertex");
        }
        if (polygon_count == 0)
            refuse("E_EMPTY", "mesh", number(in_.positions.size()) + " vertices and no face",
                   "give a mesh with faces, not points");
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
        if (!(extent < k_range_size) || extent < 1 / k_range_size)
            refuse("E_RANGE", "mesh", "the size is beyond what double precision can cube", cure);

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
                refuse("E_LIMIT", element("face", f),
                       "a polygon of " + number(degree) + " corners; the limit is " + number(k_max_polygon),
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
            for (const auto& t : triangulated(places))
                surface_.faces.push_back({{corners[t[0]], corners[t[1]], corners[t[2]]}, f});
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

    /// Judged once equal vertices are one: before that, every facet of an STL file is a piece of its own.
    void check_components()
    {
        UnionFind pieces(surface_.faces.size());
        for_each_edge(edge_uses(surface_.faces), [&](std::span<const EdgeUse> edge) {
            for (const EdgeUse& u : edge) pieces.unite(edge[0].half / 3, u.half / 3);
        });
        std::uint64_t count = 0;
        for (std::uint32_t f = 0; f < surface_.faces.size(); ++f) count += pieces.find(f) == f;
        if (count > options_.max_components)
            refuse("E_LIMIT", "mesh", number(count) + " components; the limit is " + number(options_.max_components),
                   "leave out loose pieces, weld faces that do not share vertices, or raise the limit with --max-components");
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
        if (!orientation.conflict) {
            if (orientation.turned_count > 0) note("reoriented", orientation.turned_count);
            bool changed = remove_tight_slivers();
            if (options_.repair == Repair::Holes && first_boundary_) {
                const std::uint32_t filled = fill_holes(
                    surface_, {.max_edges = options_.max_hole_edges, .max_diagonal = options_.max_hole_size * diagonal_});
                if (filled > 0) note("filled_holes", filled);
                changed = changed || filled > 0;
            }
            if (changed) {
                count_edges();
                orientation = orient(surface_);
            }
        }
        Pairing pairing = paired(surface_, orientation);
        if (first_nonmanifold_ && (pairing.unpaired || first_boundary_))
            refuse("E_NONMANIFOLD", edge_name(pairing.unpaired ? *pairing.unpaired : *first_nonmanifold_),
                   number(facts.nonmanifold_edge_count) +
                       " edges have more than two faces and no split of vertices leaves closed shells",
                   "remove fins and inner walls, so that every edge has two faces");
        if (orientation.conflict)
            refuse("E_ORIENT", element("face", surface_.faces[*orientation.conflict].polygon),
                   "the faces cannot be oriented alike: the surface has one side",
                   "cut the surface where it is twisted, or remove the twisted part");
        if (options_.thickness > 0) pairing = thickened(std::move(pairing));

        component_ = components(surface_.faces.size(), pairing.mate);
        check_flat();
        if (facts.boundary_edge_count > 0 && !options_.accept_surface)
            refuse("E_OPEN", edge_name(*first_boundary_),
                   number(facts.boundary_edge_count) + " edges have one face: the mesh encloses no volume",
                   "close the mesh, or use --repair holes for small holes, --surface for a surface without inside, --thickness "
                   "for a sheet");
        if (const std::uint32_t made = split_fans(surface_, pairing.mate); made > 0) note("split_vertices", made);
    }

    Pairing thickened(Pairing pairing)
    {
        component_ = components(surface_.faces.size(), pairing.mate);
        const Flatness flatness = flatness_of();
        if (!(flatness.area > 0)) return pairing;
        if (!first_boundary_) {
            if (!flatness.is_flat(true)) {
                warn("W_THICKNESS", 0, "the mesh is closed and not flat: --thickness was not used");
                return pairing;
            }
            // Two sides closer together than a fit can tell apart: one of them is the sheet.
            if (!keep_one_side(surface_, pairing.mate, component_))
                refuse("E_FLAT", "mesh", flatness.message + ", and it has no two sides of which one could be made a plate",
                       "model both sides further apart, or give one of them as an open mesh");
            pairing = paired(surface_, orient(surface_));
        }
        split_fans(surface_, pairing.mate);
        note("thickened", surface_.faces.size());
        thicken(surface_, options_.thickness / options_.unit.value_or(1.0));
        count_edges();
        return paired(surface_, orient(surface_));
    }

    /// Faces without area that have a neighbour at each side: the corner that lies on the opposite edge is joined to the
    /// corner beyond, so that nothing opens and nothing moves. Says whether any face changed.
    bool remove_tight_slivers()
    {
        constexpr int k_passes = 16;  // a fan of slivers takes one pass for each
        std::uint64_t removed = 0, left = 0;
        for (int pass = 0; pass < k_passes; ++pass) {
            std::vector<std::uint32_t> slivers;
            for (std::uint32_t f = 0; f < surface_.faces.size(); ++f)
                if (is_sliver(surface_.faces[f], k_sliver_height)) slivers.push_back(f);
            left = slivers.size();
            if (slivers.empty()) break;
            const std::vector<EdgeUse> uses = edge_uses(surface_.faces);
            const auto sides_of = [&](std::uint32_t a, std::uint32_t b) {
                const auto order = [](const EdgeUse& u, const EdgeUse& w) { return std::tie(u.lo, u.hi) < std::tie(w.lo, w.hi); };
                return std::equal_range(uses.begin(), uses.end(), EdgeUse{std::min(a, b), std::max(a, b), 0, false}, order);
            };
            std::vector<bool> touched(surface_.faces.size(), false);
            std::vector<std::pair<std::uint32_t, std::uint32_t>> added;
            std::uint64_t turned = 0;
            for (const std::uint32_t f : slivers) {
                std::uint32_t k = 0;
                double longest = -1;
                for (std::uint32_t i = 0; i < 3; ++i) {
                    const double length =
                        norm(surface_.points[surface_.faces[f].v[(i + 1) % 3]] - surface_.points[surface_.faces[f].v[i]]);
                    if (length > longest) {
                        longest = length;
                        k = i;
                    }
                }
                const Triangle v = surface_.faces[f].v;
                const std::uint32_t a = v[k], b = v[(k + 1) % 3], c = v[(k + 2) % 3];
                const auto [first, last] = sides_of(a, b);
                if (touched[f] || last - first != 2) continue;
                const std::uint32_t other = first->half / 3 == f ? (first + 1)->half : first->half;
                const std::uint32_t g = other / 3, d = surface_.faces[g].v[(other + 2) % 3];
                const auto [cd, cd_end] = sides_of(c, d);
                const std::pair new_edge(std::min(c, d), std::max(c, d));
                if (touched[g] || c == d || cd != cd_end || std::find(added.begin(), added.end(), new_edge) != added.end())
                    continue;
                surface_.faces[f].v = {a, d, c};
                surface_.faces[g].v = {d, b, c};
                touched[f] = touched[g] = true;
                added.push_back(new_edge);
                ++turned;
            }
            removed += turned;
            if (turned == 0) break;
        }
        if (removed > 0) note("degenerate_faces", removed);
        if (left > 0)
            warn("W_DEGENERATE", left, number(left) + " faces have no area and could not be removed without opening the mesh");
        return removed > 0;
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

    struct Flatness {
        double area = 0;              ///< of all faces, diagonals squared
        bool is_plane = false;        ///< all faces lie in one plane, as far as a fit can tell
        bool encloses_volume = true;  ///< if closed: some shell is thicker than a sheet
        std::string message;          ///< what is flat about it
        [[nodiscard]] bool is_flat(bool closed) const { return is_plane || (closed && !encloses_volume); }
    };

    /// A length in units of the diagonal as a user reads it, in units of the result.
    [[nodiscard]] std::string length(double in_diagonals) const
    {
        char text[32];
        std::snprintf(text, sizeof text, "%.2g", in_diagonals * diagonal_ * options_.unit.value_or(1.0));
        return text;
    }

    /// @pre component_ is that of surface_
    [[nodiscard]] Flatness flatness_of() const
    {
        Flatness out;
        const std::vector<Vec3d> points = local_points();
        Vec3d mean{};
        // By component: shells may be turned either way, and small solids far apart are not a sheet.
        std::vector<double> six_volumes_of(surface_.faces.size(), 0), area_of_component(surface_.faces.size(), 0);
        for (std::size_t i = 0; i < surface_.faces.size(); ++i) {
            const Face& f = surface_.faces[i];
            const Vec3d a = points[f.v[0]], b = points[f.v[1]], c = points[f.v[2]];
            const double w = 0.5 * norm(cross(b - a, c - a));
            out.area += w;
            mean += w / 3.0 * (a + b + c);
            six_volumes_of[component_[i]] += six_volumes(points, f.v);
            area_of_component[component_[i]] += w;
        }
        if (!(out.area > 0)) return out;
        // A plate of thickness t has a volume of t times half its area.
        out.encloses_volume = false;
        double thickness = 0;
        for (std::size_t i = 0; i < six_volumes_of.size(); ++i) {
            const double twice_volume = std::abs(six_volumes_of[i]) / 3, area = area_of_component[i];
            out.encloses_volume = out.encloses_volume || twice_volume > k_flat_thickness * std::pow(area, 1.5);
            if (area > 0) thickness = std::max(thickness, twice_volume / area);
        }
        out.message = "the shells are sheets folded onto themselves, " + length(thickness) + " thick on average";

        mean = mean / out.area;
        Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
        for (const Face& f : surface_.faces) {
            const Vec3d corner[3] = {points[f.v[0]] - mean, points[f.v[1]] - mean, points[f.v[2]] - mean};
            const double w = 0.5 * norm(cross(corner[1] - corner[0], corner[2] - corner[0])) / (3 * out.area);
            for (const Vec3d& p : corner) {
                const Eigen::Vector3d x(p.x, p.y, p.z);
                moments += w * x * x.transpose();
            }
        }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(moments);
        out.is_plane = std::sqrt(std::max(0.0, axes.eigenvalues()[0])) < k_flat_thickness * std::sqrt(out.area);
        if (!out.is_plane) return out;
        const Eigen::Vector3d n = axes.eigenvectors().col(0);
        double lo = 0, hi = 0;
        for (const Face& f : surface_.faces)
            for (const std::uint32_t v : f.v) {
                const Vec3d p = points[v] - mean;
                const double height = n.x() * p.x + n.y() * p.y + n.z() * p.z;
                lo = std::min(lo, height);
                hi = std::max(hi, height);
            }
        out.message = hi - lo < k_plane_rounding
                          ? "all faces lie in one plane"
                          : "the mesh is only " + length(hi - lo) + " thick and " + length(1) + " across: a sheet";
        return out;
    }

    void check_flat()
    {
        const Flatness flatness = flatness_of();
        if (!(flatness.area > 0))
            refuse("E_FLAT", "mesh", "no face with an area is left: all vertices lie on lines",
                   "give a mesh whose faces have areas");
        const bool closed = out_.facts.boundary_edge_count == 0;
        if (!flatness.is_flat(closed)) return;
        // A plate passes with twice the least thickness times the root of both sides' area; three times leaves no doubt.
        const double both_sides = closed ? flatness.area : 2 * flatness.area;
        refuse("E_FLAT", "mesh", flatness.message,
               "make it a plate with sqmap bake --thickness T, T at least " +
                   length(3 * k_flat_thickness * std::sqrt(both_sides)) + ", or model both sides further apart");
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
                warn("W_FLIPPED", shells.turned_count,
                     number(shells.turned_count) + " faces were inside out and have been turned");
            }
            if (shells.cavity_count > 0)
                warn("W_CAVITY", shells.cavity_count, number(shells.cavity_count) + " shells are cavities inside others");
        } else {
            warn("W_SURFACE", facts.boundary_edge_count,
                 "open surface with " + number(facts.boundary_edge_count) + " boundary edges: it has no inside");
        }
        std::vector<std::uint32_t> roots = component_;
        std::sort(roots.begin(), roots.end());
        facts.component_count = static_cast<std::uint64_t>(std::unique(roots.begin(), roots.end()) - roots.begin());

        write_mesh(points);
        if (out_.solid) {
            const auto v = static_cast<std::int64_t>(facts.vertex_count), f = static_cast<std::int64_t>(facts.triangle_count);
            facts.genus = static_cast<std::int64_t>(facts.component_count) - (v - f / 2) / 2;  // V - 3F/2 + F = 2 (C - genus)
        }
        if (options_.repair == Repair::None) refuse_repair();

        count_intersections();

        const Vec3d size = facts.box_max - facts.box_min;
        if (!options_.unit && std::max({size.x, size.y, size.z}) > k_unit_hint)
            warn("W_UNIT", 0, "more than 50 units wide: if that is not metres, say so with --unit (such as --unit mm)");
    }

    void count_intersections()
    {
        MeshFacts& facts = out_.facts;
        SelfIntersections found = find_self_intersections(out_.mesh, options_.max_intersections);
        facts.self_intersecting_pairs = found.pair_count;
        if (found.pair_count > 0) out_.crossed = std::move(found.crossed);
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
            for (int k = 0; k < 3; ++k)
                key[f.v[k]] = std::min(key[f.v[k]], Key{place(f.v[(k + 1) % 3]), place(f.v[(k + 2) % 3])});
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

    /// With Repair::None what would have been repaired is the verdict, by the code that names it best.
    void refuse_repair()
    {
        std::string list;
        const auto has = [&](const char* kind) {
            return std::any_of(out_.repairs.begin(), out_.repairs.end(), [&](const RepairNote& r) { return r.kind == kind; });
        };
        for (const RepairNote& r : out_.repairs)
            if (r.kind != "thickened") list += (list.empty() ? "" : ", ") + r.kind + " (" + number(r.count) + ")";
        if (list.empty()) return;  // a thickness is asked for, not a repair
        const char* code = has("duplicate_faces") || has("split_vertices") ? "E_NONMANIFOLD"
                           : has("reoriented") || has("flipped")           ? "E_ORIENT"
                           : has("welded_vertices")                        ? "E_OPEN"
                                                                           : "E_REPAIR";
        refuse(code, "mesh", "it needs repairs that are forbidden: " + list, "allow them with --repair safe");
    }

    void note(const char* kind, std::uint64_t count)
    {
        for (RepairNote& r : out_.repairs)
            if (r.kind == kind) {
                r.count += count;
                return;
            }
        out_.repairs.push_back({kind, count});
    }
    void warn(const char* code, std::uint64_t count, std::string message)
    {
        out_.warnings.push_back({code, count, std::move(message)});
    }

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
