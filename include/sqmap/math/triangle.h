// Triangles: the closest point, and what of the triangle it is on.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

#include <algorithm>
#include <limits>

namespace sqmap {

/// The closest point of a triangle, and the corners that span what it is on: bits 1, 2, 4 for a, b, c. One bit: a corner; two: an
/// edge; three: the face.
template <class Real>
struct TriangleFoot {
    Vec3<Real> point{};
    unsigned corners = 0;
};

/// Closest point of a triangle to p, by the region of its plane that p projects to (C. Ericson, Real-Time Collision
/// Detection, 2005, 5.1.5). Total: a triangle without area gives a point of its edges.
template <class Real>
[[nodiscard]] constexpr TriangleFoot<Real> foot_on_triangle(Vec3<Real> p, Vec3<Real> a, Vec3<Real> b, Vec3<Real> c) noexcept
{
    constexpr Real k_tiny = std::numeric_limits<Real>::min();
    const Vec3<Real> ab = b - a, ac = c - a, ap = p - a;
    const Real d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return {a, 1};
    const Vec3<Real> bp = p - b;
    const Real d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return {b, 2};
    const Real vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + (d1 / std::max(d1 - d3, k_tiny)) * ab, 3};
    const Vec3<Real> cp = p - c;
    const Real d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return {c, 4};
    const Real vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + (d2 / std::max(d2 - d6, k_tiny)) * ac, 5};
    const Real va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return {b + ((d4 - d3) / std::max((d4 - d3) + (d5 - d6), k_tiny)) * (c - b), 6};
    const Real sum = va + vb + vc;
    if (!(sum > 0)) return {a, 1};
    return {a + (vb / sum) * ab + (vc / sum) * ac, 7};
}

/// The same without what it is on.
template <class Real>
[[nodiscard]] constexpr Vec3<Real> closest_point_on_triangle(Vec3<Real> p, Vec3<Real> a, Vec3<Real> b, Vec3<Real> c) noexcept
{
    return foot_on_triangle(p, a, b, c).point;
}

}  // namespace sqmap
