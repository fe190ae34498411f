#include "sqmap/fit/euler_zyz.h"

#include <cmath>

namespace sqmap::fit {

Mat3d rotation_from(EulerZyz angles)
{
    const auto about_z = [](double t) {
        const double c = std::cos(t), s = std::sin(t);
        return Mat3d{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
    };
    const double c = std::cos(angles.theta), s = std::sin(angles.theta);
    const Mat3d about_y{{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}};
    return transpose(about_z(angles.phi) * about_y * about_z(angles.chi));
}

EulerZyz euler_zyz_of(const Mat3d& rotation)
{
    const auto m = [&](int i, int j) { return rotation.row[j][i]; };
    const double sin_theta = std::hypot(m(0, 2), m(1, 2));
    const double theta = std::atan2(sin_theta, m(2, 2));
    if (sin_theta < 1e-9) return {std::atan2(-m(0, 1), m(1, 1)), theta, 0};
    return {std::atan2(m(1, 2), m(0, 2)), theta, std::atan2(m(2, 1), -m(2, 0))};
}

}  // namespace sqmap::fit
