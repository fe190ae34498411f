// Rotations as axis times angle, and back.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

#include <cmath>

namespace sqmap {

/// Rotation by |r| radians about r (Rodrigues).
[[nodiscard]] Mat3d rotation_by(Vec3d r) noexcept;
/// The inverse: axis times angle, 0 to pi. Half a turn has two answers; one is taken.
[[nodiscard]] Vec3d rotation_vector(const Mat3d& m) noexcept;
/// The nearest rotation to one that has drifted by rounding.
[[nodiscard]] inline Mat3d orthonormal(const Mat3d& m) noexcept
{
    const Vec3d x = normalized(m.row[0]), z = normalized(cross(x, m.row[1]));
    return {{x, cross(z, x), z}};
}

/// True where the rows are orthonormal within the tolerance and right-handed; false for NaN. A matrix that is merely finite may
/// scale or mirror. The default lets numbers of four digits pass.
[[nodiscard]] inline bool is_rotation(const Mat3d& m, double tolerance = 1e-3) noexcept
{
    const auto& r = m.row;
    if (!std::islessequal(std::fabs(norm_sq(r[0]) - 1), tolerance)) return false;  // rows of zeros pass the products below
    for (int i = 0; i < 3; ++i) {
        const Vec3d off = cross(r[i], r[(i + 1) % 3]) - r[(i + 2) % 3];
        if (!std::islessequal(norm_sq(off), tolerance * tolerance)) return false;
    }
    return true;
}

/// Rotation of a unit quaternion with real part w.
[[nodiscard]] constexpr Mat3d rotation_of(double w, double x, double y, double z) noexcept
{
    return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

}  // namespace sqmap
