// Signs of determinants of points, exact whatever the rounding.
// Pure functions: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

#include <cmath>

namespace sqmap {

struct Vec2d {
    double x, y;
};

/// As orient3d, without its filter.
int exact_orient3d(Vec3d a, Vec3d b, Vec3d c, Vec3d d) noexcept;

/// Sign of the volume of the tetrahedron: +1 where d lies below the plane through a, b, c (they turn clockwise seen from d
/// is -1), 0 where all four are in one plane. Exact where coordinates are zero or
/// between 1e-70 and 1e70 in size; beyond that products overflow or vanish, and the sign may be any.
inline int orient3d(Vec3d a, Vec3d b, Vec3d c, Vec3d d) noexcept
{
    constexpr double k_epsilon = 0x1p-53, k_bound = (7 + 56 * k_epsilon) * k_epsilon;
    const Vec3d u = a - d, v = b - d, w = c - d;
    const double vxwy = v.x * w.y, wxvy = w.x * v.y, wxuy = w.x * u.y, uxwy = u.x * w.y, uxvy = u.x * v.y, vxuy = v.x * u.y;
    const double det = u.z * (vxwy - wxvy) + v.z * (wxuy - uxwy) + w.z * (uxvy - vxuy);
    const double permanent = (std::abs(vxwy) + std::abs(wxvy)) * std::abs(u.z) +
                             (std::abs(wxuy) + std::abs(uxwy)) * std::abs(v.z) +
                             (std::abs(uxvy) + std::abs(vxuy)) * std::abs(w.z);
    if (std::abs(det) > k_bound * permanent) return det > 0 ? 1 : -1;
    return permanent == 0 ? 0 : exact_orient3d(a, b, c, d);
}

/// +1 where a, b, c turn counter-clockwise, -1 clockwise, 0 on one line. Exact as orient3d.
int orient2d(Vec2d a, Vec2d b, Vec2d c) noexcept;

}  // namespace sqmap
