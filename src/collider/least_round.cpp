// Capsules and cylinders of least volume. For each direction the smallest circle about the points' shadow gives the thinnest one;
// the best of many directions are improved by a pattern search: of a cylinder over the direction, of a capsule also over the
// axis's position and the radius, since a thicker capsule may be shorter.
#include "collider/searches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::collider {
namespace {

constexpr int k_directions = 96;
constexpr std::size_t k_facet_axes = 40, k_axis_starts = 8;

std::vector<Vec3d> directions_of(const mesh::Mesh& hull)
{
    std::vector<Vec3d> out = half_sphere(k_directions);
    const std::vector<Vec3d> normals = facet_normals(hull, k_facet_axes);
    out.insert(out.end(), normals.begin(), normals.end());
    const Candidate ellipsoid = least_ellipsoid(hull.vertices), box = least_box(hull);
    for (int k = 0; k < 3; ++k)
        for (const Mat3d& axes : {ellipsoid.axes, box.axes}) out.push_back({axes.row[0][k], axes.row[1][k], axes.row[2][k]});
    return out;
}

struct Shadow {
    Vec3d centre;  ///< along the axes, its third coordinate the middle
    double radius, half_length;
};

Shadow shadow_of(std::span<const Vec3d> points, const Mat3d& axes)
{
    std::vector<Vec3d> flat;
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (const Vec3d& p : points) {
        const Vec3d q = transpose_mul(axes, p);
        lo = std::min(lo, q.z);
        hi = std::max(hi, q.z);
        flat.push_back({q.x, q.y, 0});
    }
    const Sphere circle = least_ball(flat);
    return {{circle.centre.x, circle.centre.y, 0.5 * (lo + hi)}, circle.radius, 0.5 * (hi - lo)};
}

Candidate cylinder_about(std::span<const Vec3d> points, const Mat3d& axes)
{
    const Shadow s = shadow_of(points, axes);
    return {
        axes, axes * s.centre, {s.radius, s.radius, s.half_length}, 2 * std::numbers::pi * s.radius * s.radius * s.half_length};
}

/// The shortest capsule about an axis through `on` (coordinates along the axes, two of them count) that is at least so thick.
Candidate capsule_about(std::span<const Vec3d> points, const Mat3d& axes, Vec3d on, double least_radius)
{
    double radius = least_radius;
    for (const Vec3d& p : points) {
        const Vec3d q = transpose_mul(axes, p);
        radius = std::max(radius, std::hypot(q.x - on.x, q.y - on.y));
    }
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (const Vec3d& p : points) {
        const Vec3d q = transpose_mul(axes, p);
        const double around = std::hypot(q.x - on.x, q.y - on.y),
                     cap = std::sqrt(std::max(0.0, radius * radius - around * around));
        lo = std::min(lo, q.z + cap);
        hi = std::max(hi, q.z - cap);
    }
    const double half = std::max(0.0, 0.5 * (hi - lo));
    return {axes,
            axes * Vec3d{on.x, on.y, 0.5 * (lo + hi)},
            {radius, radius, half},
            std::numbers::pi * radius * radius * (2 * half + 4 * radius / 3)};
}

void keep_best(std::vector<Candidate>& candidates, std::size_t count)
{
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& l, const Candidate& r) { return l.volume < r.volume; });
    candidates.resize(std::min(candidates.size(), count));
}

}  // namespace

Candidate least_cylinder(const mesh::Mesh& hull)
{
    std::vector<Candidate> starts;
    for (const Vec3d& d : directions_of(hull)) starts.push_back(cylinder_about(hull.vertices, axes_along(d)));
    keep_best(starts, k_axis_starts);
    Candidate best = starts.front();
    for (const Candidate& start : starts) {
        const auto at = [&](const std::array<double, 2>& x) {
            return cylinder_about(hull.vertices, turned(start.axes, start.axes * Vec3d{x[0], x[1], 0}));
        };
        const Candidate c = at(pattern_search<2>({}, {0.05, 0.05}, 1e-5, [&](const auto& x) { return at(x).volume; }));
        if (c.volume < best.volume) best = c;
    }
    return best;
}

Candidate least_capsule(const mesh::Mesh& hull)
{
    std::vector<Candidate> starts;
    for (const Vec3d& d : directions_of(hull)) {
        const Mat3d axes = axes_along(d);
        const Shadow s = shadow_of(hull.vertices, axes);
        starts.push_back(capsule_about(hull.vertices, axes, s.centre, s.radius));
    }
    keep_best(starts, k_axis_starts);
    Candidate best = starts.front();
    for (const Candidate& start : starts) {
        const Vec3d on = transpose_mul(start.axes, start.centre);
        const double r = start.size.x;
        const auto at = [&](const std::array<double, 5>& x) {
            const Mat3d axes = turned(start.axes, start.axes * Vec3d{x[0], x[1], 0});
            // The axis turns about the capsule's centre.
            const Vec3d through = transpose_mul(axes, start.axes * (on + Vec3d{x[2] * r, x[3] * r, 0}));
            return capsule_about(hull.vertices, axes, through, r * (1 + x[4]));
        };
        const Candidate c =
            at(pattern_search<5>({}, {0.05, 0.05, 0.05, 0.05, 0.05}, 1e-4, [&](const auto& x) { return at(x).volume; }));
        if (c.volume < best.volume) best = c;
    }
    return best;
}

}  // namespace sqmap::collider
