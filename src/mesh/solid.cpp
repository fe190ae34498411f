#include "sqmap/mesh/solid.h"

#include <algorithm>
#include <cmath>

namespace sqmap::mesh {

Solid::Solid(const Mesh& mesh, std::span<const std::uint8_t> crossed)
    : mesh_(mesh), bvh_(mesh), boundary_(mesh.triangles.size(), Boundary::Whole)
{
    self_intersecting_ = std::any_of(crossed.begin(), crossed.end(), [](std::uint8_t c) { return c != 0; });
    if (!self_intersecting_) return;
    step_ = 1e-7 * largest_vertex_distance(mesh);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (crossed[t] != 0)
            boundary_[t] = Boundary::Partly;
        else if (!is_boundary(triangle_centroid(mesh, t), t))
            boundary_[t] = Boundary::Buried;
    }
}

bool Solid::is_boundary(Vec3d p, std::uint32_t triangle) const
{
    const Triangle& t = mesh_.triangles[triangle];
    const Vec3d a = mesh_.vertices[t[0]];
    const Vec3d n = normalized(cross(mesh_.vertices[t[1]] - a, mesh_.vertices[t[2]] - a));
    return inside(p - step_ * n) && !inside(p + step_ * n);
}

ClosestPoint Solid::closest_boundary(Vec3d p, double within) const
{
    if (!self_intersecting_) return bvh_.closest_point(p, within);
    ClosestPoint best;
    best.distance = within;
    bvh_.visit_nearest(p, within * within, [&](std::uint32_t t, double radius_sq) {
        if (boundary_[t] == Boundary::Buried) return radius_sq;
        const Triangle& tri = mesh_.triangles[t];
        const Vec3d q = closest_point_on_triangle(p, mesh_.vertices[tri[0]], mesh_.vertices[tri[1]], mesh_.vertices[tri[2]]);
        const double distance_sq = norm_sq(q - p);
        if (distance_sq >= radius_sq) return radius_sq;
        if (boundary_[t] == Boundary::Partly && !is_boundary(q, t)) return radius_sq;
        best = {q, t, std::sqrt(distance_sq)};
        return distance_sq;
    });
    return best;
}

}  // namespace sqmap::mesh
