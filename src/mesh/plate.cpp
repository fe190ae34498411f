#include "admit_steps.h"

#include "sqmap/math/assert.h"

#include <cmath>

namespace sqmap::mesh {
namespace {

/// Two faces at an edge run along it in opposite directions, and no edge has more than max_faces.
[[maybe_unused]] bool agree_in_orientation(std::span<const EdgeUse> uses, std::size_t max_faces)
{
    bool agree = true;
    for_each_edge(uses, [&](std::span<const EdgeUse> sides) {
        agree = agree && sides.size() <= max_faces && (sides.size() != 2 || sides[0].forward != sides[1].forward);
    });
    return agree;
}

}  // namespace

bool keep_one_side(Surface& surface, const std::vector<std::uint32_t>& mate, const std::vector<std::uint32_t>& component)
{
    SQMAP_ASSERT(mate.size() == 3 * surface.faces.size() && component.size() == surface.faces.size());
    constexpr double k_fold = 0.5;                          // cosine: a fold turns by more than 60 degrees
    constexpr double k_wall = 4;                            // faces lower than this many thicknesses join two sides
    constexpr double k_min_share = 0.4, k_max_share = 0.6;  // of a component's area
    const std::size_t count = surface.faces.size();
    std::vector<Vec3d> normal(count);
    std::vector<double> area(count), height(count), component_area(count, 0.0), component_volume(count, 0.0);
    for (std::size_t i = 0; i < count; ++i) {
        // From a corner of the component's own: volumes of thin things far from the origin would cancel.
        const Vec3d origin = surface.points[surface.faces[component[i]].v[0]];
        const Triangle& v = surface.faces[i].v;
        const Vec3d a = surface.points[v[0]] - origin, b = surface.points[v[1]] - origin, c = surface.points[v[2]] - origin;
        const Vec3d twice = cross(b - a, c - a);
        area[i] = 0.5 * norm(twice);
        normal[i] = normalized(twice);
        height[i] = 2 * area[i] / std::max({norm(b - a), norm(c - b), norm(a - c)});
        component_area[component[i]] += area[i];
        component_volume[component[i]] += dot(a, cross(b, c)) / 6;
    }
    const auto is_wall = [&](std::uint32_t f) {
        const double thickness = 2 * std::abs(component_volume[component[f]]) / component_area[component[f]];
        return height[f] < k_wall * thickness;
    };
    UnionFind sides(count);
    for (std::uint32_t half = 0; half < mate.size(); ++half) {
        const std::uint32_t f = half / 3, g = mate[half] / 3;
        if (!is_wall(f) && !is_wall(g) && dot(normal[f], normal[g]) > k_fold) sides.unite(f, g);
    }
    std::vector<double> side_area(count, 0.0);
    for (std::uint32_t f = 0; f < count; ++f) side_area[sides.find(f)] += area[f];
    std::vector<std::uint32_t> kept(count, k_none);  // per component
    for (std::uint32_t f = 0; f < count; ++f) {
        std::uint32_t& best = kept[component[f]];
        if (best == k_none || side_area[sides.find(f)] > side_area[best]) best = sides.find(f);
    }
    for (std::uint32_t f = 0; f < count; ++f) {
        const double share = side_area[kept[component[f]]] / component_area[component[f]];
        if (!(share >= k_min_share && share <= k_max_share)) return false;
    }
    std::vector<Face> faces;
    for (std::uint32_t f = 0; f < count; ++f)
        if (sides.find(f) == kept[component[f]]) faces.push_back(surface.faces[f]);
    surface.faces = std::move(faces);
    return true;
}

void thicken(Surface& surface, double thickness)
{
    const std::vector<EdgeUse> uses = edge_uses(surface.faces);
    SQMAP_ASSERT(agree_in_orientation(uses, 2));
    const std::size_t count = surface.points.size();
    std::vector<Vec3d> normals(count);
    for (const Face& f : surface.faces) {
        const Vec3d n =
            normalized(cross(surface.points[f.v[1]] - surface.points[f.v[0]], surface.points[f.v[2]] - surface.points[f.v[0]]));
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d p = surface.points[f.v[k]];
            const Vec3d u = normalized(surface.points[f.v[(k + 1) % 3]] - p),
                        w = normalized(surface.points[f.v[(k + 2) % 3]] - p);
            normals[f.v[k]] += std::atan2(norm(cross(u, w)), dot(u, w)) * n;  // by angle: independent of the triangulation
        }
    }
    std::vector<Face> faces;
    const auto below = [&](std::uint32_t v) { return v + static_cast<std::uint32_t>(count); };
    for_each_edge(uses, [&](std::span<const EdgeUse> sides) {
        if (sides.size() != 1) return;
        const Face& f = surface.faces[sides[0].half / 3];
        const std::uint32_t a = f.v[sides[0].half % 3], b = f.v[(sides[0].half + 1) % 3];
        faces.push_back({{b, a, below(a)}, f.polygon});
        faces.push_back({{b, below(a), below(b)}, f.polygon});
    });
    for (const Face& f : surface.faces) {
        faces.push_back(f);
        faces.push_back({{below(f.v[0]), below(f.v[2]), below(f.v[1])}, f.polygon});
    }
    surface.faces = std::move(faces);
    surface.points.resize(2 * count);
    surface.source.resize(2 * count);
    for (std::size_t v = 0; v < count; ++v) {
        const Vec3d half = 0.5 * thickness * normalized(normals[v]);
        const Vec3d p = surface.points[v];
        surface.points[v] = p + half;
        surface.points[count + v] = p - half;
        surface.source[count + v] = surface.source[v];
    }
}

}  // namespace sqmap::mesh
