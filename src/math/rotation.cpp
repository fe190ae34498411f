// Rodrigues' formula and its inverse.
#include "sqmap/math/rotation.h"

#include "math/trigonometry.h"

#include <cmath>

namespace sqmap {

Mat3d rotation_by(Vec3d r) noexcept
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

Vec3d rotation_vector(const Mat3d& m) noexcept
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

}  // namespace sqmap
