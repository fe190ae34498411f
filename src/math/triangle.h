// Triangles: the closest point, and what of the triangle it is on.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

#include <algorithm>
#include <limits>

namespace sqmap {

/// The closest point of a triangle, and the corners that span what it is on: bits 1, 2, 4 for a, b, c. One bit: a corner; two: an
/// edge; three: the face.
struct TriangleFoot {
    Vec3d point{};
    unsigned corners = 0;
};

/// The nearest of the triangle's sides, or `face` where none is nearer.
[[nodiscard]] constexpr TriangleFoot foot_on_sides(Vec3d p, Vec3d a, Vec3d b, Vec3d c, TriangleFoot face) noexcept
{
    TriangleFoot best = face;
    const auto offer = [&](Vec3d from, Vec3d to, unsigned first, unsigned last) {
        const Vec3d side = to - from;
        const double along = dot(p - from, side), all = dot(side, side);
        const TriangleFoot foot = along <= 0     ? TriangleFoot{from, first}
                                  : along >= all ? TriangleFoot{to, last}
                                                 : TriangleFoot{from + (along / all) * side, first | last};
        if (dot(foot.point - p, foot.point - p) < dot(best.point - p, best.point - p)) best = foot;
    };
    offer(a, b, 1, 2);
    offer(a, c, 1, 4);
    offer(b, c, 2, 4);
    return best;
}

/// Closest point of a triangle to p, by the region of its plane that p projects to (C. Ericson, Real-Time Collision
/// Detection, 2005, 5.1.5). Total: of a triangle with an angle below 1e-6, whose area is rounding, the nearest of its
/// sides is taken where that is nearer.
[[nodiscard]] constexpr TriangleFoot foot_on_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) noexcept
{
    constexpr double k_tiny = std::numeric_limits<double>::min();
    const Vec3d ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return {a, 1};
    const Vec3d bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return {b, 2};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + (d1 / std::max(d1 - d3, k_tiny)) * ab, 3};
    const Vec3d cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return {c, 4};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + (d2 / std::max(d2 - d6, k_tiny)) * ac, 5};
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {b + ((d4 - d3) / std::max((d4 - d3) + (d5 - d6), k_tiny)) * (c - b), 6};
    const double sum = va + vb + vc;
    if (!(sum > 0)) return foot_on_sides(p, a, b, c, {a, 1});
    const TriangleFoot face{a + (vb / sum) * ab + (vc / sum) * ac, 7};
    constexpr double k_thin = 1e-12;  // squared sine of the angle at a
    if (sum > k_thin * dot(ab, ab) * dot(ac, ac)) return face;
    const bool is_within = va >= 0 && vb >= 0 && vc >= 0;
    return foot_on_sides(p, a, b, c, is_within ? face : TriangleFoot{a, 1});
}

/// The same without what it is on.
[[nodiscard]] constexpr Vec3d closest_point_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) noexcept
{
    return foot_on_triangle(p, a, b, c).point;
}

/// The unit normal of a triangle, counter-clockwise outward; zero without an area.
[[nodiscard]] inline Vec3d normal_of_triangle(const Vec3d& a, const Vec3d& b, const Vec3d& c) noexcept
{
    const Vec3d across = cross(b - a, c - a);
    const double area = norm(across);
    return area > 0 ? across / area : Vec3d{};
}

}  // namespace sqmap
