// From one surface to the result of admission: pieces, shells, flatness, the canonical mesh and its facts.
#include "admit_steps.h"
#include "sqmap/mesh/self_intersection.h"
#include "surface.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr double k_unit_hint = 50;  // a thing of 50 m is rare, one of 50 mm is not

/// The end of a cure's text that names the next rung; empty if no higher rung may take the mesh.
Words next_rung(const AdmitOptions& options)
{
    if (options.repair >= Repair::Wrap || options.accept_surface || options.thickness > 0) return {};
    if (options.repair == Repair::Close)
        return Words(", or raise ", Setting::MaxFilled).with(", or use ", Setting::Repair, "wrap");
    return {", or use ", Setting::Repair, "close or wrap"};
}

/// The polygon of each of the canonical mesh's triangles. triangles: of the faces, with the canonical mesh's vertices.
std::vector<std::uint32_t> polygons_of(std::span<const Triangle> triangles, std::span<const Face> faces)
{
    std::vector<Face> canonical(faces.begin(), faces.end());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        Triangle& v = canonical[f].v;
        v = triangles[f];
        std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    }
    std::sort(canonical.begin(), canonical.end(),
              [](const Face& a, const Face& b) { return std::tie(a.v, a.polygon) < std::tie(b.v, b.polygon); });
    std::vector<std::uint32_t> out;
    for (const Face& f : canonical) out.push_back(f.polygon);
    return out;
}

class SurfaceJudge {
public:
    SurfaceJudge(Surface& surface, const Box& box, const AdmitOptions& options, AdmitResult& out)
        : options_(options), box_(box), diagonal_(norm(size(box))), surface_(surface), out_(out)
    {
    }

    void judge()
    {
        check_components();
        make_shells();
        finish();
    }

private:
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
            refuse(Refusal::Limit, "mesh", number(count) + " components; the limit is " + number(options_.max_components),
                   Words("leave out loose pieces, weld faces that do not share vertices")
                       .with(", or raise the limit with ", Setting::MaxComponents));
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
            if (orientation.turned_count > 0) note(RepairKind::Reoriented, orientation.turned_count);
            const TightSlivers slivers = remove_tight_slivers(surface_, diagonal_);
            if (slivers.removed > 0) note(RepairKind::DegenerateFaces, slivers.removed);
            if (slivers.left > 0) warn(WarningKind::Degenerate, slivers.left);
            if (slivers.removed > 0) {
                count_edges();
                orientation = orient(surface_);
            }
        }
        Pairing pairing = paired(surface_, orientation);
        if (first_nonmanifold_ && (pairing.unpaired || first_boundary_))
            refuse(Refusal::NonManifold, edge_name(pairing.unpaired ? *pairing.unpaired : *first_nonmanifold_),
                   number(facts.nonmanifold_edge_count) +
                       " edges have more than two faces and no split of vertices leaves closed shells",
                   Words("remove fins and inner walls, so that every edge has two faces") + next_rung(options_));
        if (orientation.conflict)
            refuse(Refusal::Orient, element("face", surface_.faces[*orientation.conflict].polygon),
                   "the faces cannot be oriented alike: the surface has one side",
                   Words("cut the surface where it is twisted, or remove the twisted part") + next_rung(options_));
        if (options_.thickness > 0) pairing = thickened(std::move(pairing));

        component_ = components(surface_.faces.size(), pairing.mate);
        check_flat();
        if (facts.boundary_edge_count > 0 && !options_.accept_surface)
            refuse(Refusal::Open, edge_name(*first_boundary_),
                   number(facts.boundary_edge_count) + " edges have one face: the mesh encloses no volume",
                   Words("close the mesh")
                           .with(", or use ", Setting::Surface, "", " for a surface without inside")
                           .with(", ", Setting::Thickness, "", " for a sheet") +
                       next_rung(options_));
        if (const std::uint32_t made = split_fans(surface_, pairing.mate); made > 0) note(RepairKind::SplitVertices, made);
    }

    Pairing thickened(Pairing pairing)
    {
        component_ = components(surface_.faces.size(), pairing.mate);
        const Flatness flatness = flatness_of(surface_, local_points(), component_, scale());
        if (!(flatness.area > 0)) return pairing;
        if (!first_boundary_) {
            if (!flatness.is_flat(true)) {
                warn(WarningKind::Thickness);
                return pairing;
            }
            // Two sides closer together than a fit can tell apart: one of them is the sheet.
            if (!keep_one_side(surface_, pairing.mate, component_))
                refuse(Refusal::Flat, "mesh", flatness.message + ", and it has no two sides of which one could be made a plate",
                       "model both sides further apart, or give one of them as an open mesh");
            pairing = paired(surface_, orient(surface_));
        }
        split_fans(surface_, pairing.mate);
        note(RepairKind::Thickened, surface_.faces.size());
        thicken(surface_, options_.thickness / options_.unit.value_or(1.0));
        count_edges();
        return paired(surface_, orient(surface_));
    }

    void check_flat()
    {
        const Flatness flatness = flatness_of(surface_, local_points(), component_, scale());
        if (!(flatness.area > 0))
            refuse(Refusal::Flat, "mesh", "no face with an area is left: all vertices lie on lines",
                   "give a mesh whose faces have areas");
        const bool closed = out_.facts.boundary_edge_count == 0;
        if (!flatness.is_flat(closed)) return;
        // A plate passes with twice the least thickness times the root of both sides' area; three times leaves no doubt.
        const double both_sides = closed ? flatness.area : 2 * flatness.area;
        refuse(Refusal::Flat, "mesh", flatness.message,
               Words("make it a plate with ", Setting::PlateThickness, "T",
                     ", T at least " + length_text(3 * k_flat_thickness * std::sqrt(both_sides) * scale()) + ", or ") +
                   "model both sides further apart");
    }

    /// Points about the origin in units of the diagonal, for everything that multiplies coordinates.
    [[nodiscard]] std::vector<Vec3d> local_points() const
    {
        const Vec3d centre = box_.lo + 0.5 * size(box_);
        std::vector<Vec3d> out;
        out.reserve(surface_.points.size());
        for (const Vec3d& p : surface_.points) out.push_back((p - centre) / diagonal_);
        return out;
    }

    /// Units of the result for a length of a diagonal.
    [[nodiscard]] double scale() const { return diagonal_ * options_.unit.value_or(1.0); }

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
                note(RepairKind::Flipped, shells.turned_count);
                warn(WarningKind::Flipped, shells.turned_count);
            }
            if (shells.cavity_count > 0) warn(WarningKind::Cavities, shells.cavity_count);
        } else {
            warn(WarningKind::Surface, facts.boundary_edge_count);
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

        const Vec3d sides = size(facts.box);
        if (!options_.unit && std::max({sides.x, sides.y, sides.z}) > k_unit_hint) warn(WarningKind::Unit);
    }

    void count_intersections()
    {
        MeshFacts& facts = out_.facts;
        SelfIntersections found = find_self_intersections(out_.mesh, options_.max_intersections);
        facts.self_intersecting_pairs = found.pair_count;
        if (found.pair_count > 0) out_.crossed = std::move(found.crossed);
        facts.intersections_complete = found.is_complete;
        if (found.pair_count > 0)
            out_.warnings.push_back(
                {.kind = WarningKind::SelfIntersections, .count = found.pair_count, .at_least = !found.is_complete});
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
        const auto position = [&](std::uint32_t v) { return as_tuple(surface_.points[v]); };
        using Key = std::pair<std::tuple<double, double, double>, std::tuple<double, double, double>>;
        std::vector<Key> key(surface_.points.size(), {{1e308, 0, 0}, {}});
        for (const Face& f : surface_.faces)
            for (int k = 0; k < 3; ++k)
                key[f.v[k]] = std::min(key[f.v[k]], Key{position(f.v[(k + 1) % 3]), position(f.v[(k + 2) % 3])});
        std::sort(order.begin(), order.end(), [&](auto a, auto b) {
            return position(a) != position(b) ? position(a) < position(b) : (key[a] != key[b] ? key[a] < key[b] : a < b);
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
        const double scale = this->scale();
        facts.area = area * scale * scale;
        facts.volume = out_.solid ? volume * scale * scale * scale : 0;
        facts.vertex_count = mesh.vertices.size();
        facts.triangle_count = mesh.triangles.size();
        facts.box = box_of(mesh.vertices);
        out_.mesh = canonicalized(mesh);
        for (const std::uint32_t v : order) out_.source_vertex.push_back(surface_.source[v]);  // canonical already
        out_.source_triangle = polygons_of(mesh.triangles, surface_.faces);
        const auto is_made_up = [](std::uint32_t polygon) { return polygon == k_none; };
        if (std::any_of(out_.source_triangle.begin(), out_.source_triangle.end(), is_made_up))
            for (const std::uint32_t polygon : out_.source_triangle) out_.made_up.push_back(is_made_up(polygon) ? 1 : 0);
    }

    /// With Repair::None what would have been repaired refuses, by the code that names it best.
    void refuse_repair()
    {
        std::string list;
        const auto has = [&](RepairKind kind) {
            return std::any_of(out_.repairs.begin(), out_.repairs.end(), [&](const RepairNote& r) { return r.kind == kind; });
        };
        for (const RepairNote& r : out_.repairs)
            if (r.kind != RepairKind::Thickened)
                list += (list.empty() ? "" : ", ") + std::string(name_of(r.kind)) + " (" + number(r.count) + ")";
        if (list.empty()) return;  // the user ordered a thickness: it is no repair
        const Refusal code = has(RepairKind::DuplicateFaces) || has(RepairKind::SplitVertices) ? Refusal::NonManifold
                             : has(RepairKind::Reoriented) || has(RepairKind::Flipped)         ? Refusal::Orient
                             : has(RepairKind::WeldedVertices)                                 ? Refusal::Open
                                                                                               : Refusal::Repair;
        refuse(code, "mesh", "it needs repairs that are forbidden: " + list, Words("allow them with ", Setting::Repair, "safe"));
    }

    void note(RepairKind kind, std::uint64_t count) { mesh::note(out_.repairs, kind, count); }
    void warn(WarningKind kind, std::uint64_t count = 0) { out_.warnings.push_back({kind, count}); }

    const AdmitOptions& options_;
    const Box box_;
    const double diagonal_;
    Surface& surface_;
    AdmitResult& out_;
    std::optional<EdgeUse> first_boundary_, first_nonmanifold_;
    std::vector<std::uint32_t> component_;
};

}  // namespace

void note(std::vector<RepairNote>& repairs, RepairKind kind, std::uint64_t count)
{
    for (RepairNote& r : repairs)
        if (r.kind == kind) {
            r.count += count;
            return;
        }
    repairs.push_back({kind, count});
}

void judge_surface(Surface& surface, const Box& box, const AdmitOptions& options, AdmitResult& out)
{
    SurfaceJudge(surface, box, options, out).judge();
}

}  // namespace sqmap::mesh
