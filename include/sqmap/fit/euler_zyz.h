// The Euler angles of eq. 2.
#pragma once

#include "sqmap/math/vec.h"

namespace sqmap::fit {

/// Radians; the frame is Rz(phi) Ry(theta) Rz(chi), whose columns are the local axes.
struct EulerZyz {
    double phi = 0, theta = 0, chi = 0;
};

/// Rows are the local axes, as in shape::Superquadric::rotation.
[[nodiscard]] Mat3d rotation_from(EulerZyz angles);

/// theta in [0, pi]; where it is 0 or pi the other two are not separate and chi is 0.
[[nodiscard]] EulerZyz euler_zyz_of(const Mat3d& rotation);

}  // namespace sqmap::fit
