// Rotations as axis times angle, and back.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/trigonometry.h"
#include "sqmap/math/vec.h"

#include <cmath>

namespace sqmap {

/// Rotation by |r| radians about r (Rodrigues).
[[nodiscard]] inline Mat3d rotation_by(Vec3d r) noexcept
{
    const double angle_sq = norm_sq(r), angle = std::sqrt(angle_sq);
    const auto [sine, cosine] = sine_cosine(angle);
    const double s = angle > 1e-8 ? sine / angle : 1, c = angle > 1e-8 ? (1 - cosine) / angle_sq : 0.5;
    Mat3d m;
    for (int k = 0; k < 3; ++k) {
        Vec3d e{};
        e[k] = 1;
        const Vec3d column = e + s * cross(r, e) + c * cross(r, cross(r, e));
        for (int i = 0; i < 3; ++i) m.row[i][k] = column[i];
    }
    return m;
}

/// The inverse: axis times angle, 0 to pi. Half a turn has two answers; one is taken.
[[nodiscard]] inline Vec3d rotation_vector(const Mat3d& m) noexcept
{
    const Vec3d twice{m.row[2].y - m.row[1].z, m.row[0].z - m.row[2].x, m.row[1].x - m.row[0].y};  // 2 sin(angle) axis
    const double sine = 0.5 * norm(twice), cosine = 0.5 * (m.row[0].x + m.row[1].y + m.row[2].z - 1);
    const double angle = angle_of(sine, cosine);
    if (sine > 1e-6) return (0.5 * angle / sine) * twice;
    if (cosine > 0) return 0.5 * twice;
    // Near half a turn: (m + 1) / 2 is the axis times itself.
    Vec3d axis{};
    for (int k = 0; k < 3; ++k) {
        Vec3d column{m.row[0][k], m.row[1][k], m.row[2][k]};
        column[k] += 1;
        if (norm_sq(column) > norm_sq(axis)) axis = column;
    }
    return angle * normalized(axis);
}

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
