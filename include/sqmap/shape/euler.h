// The ZYZ Euler angles of eq. 2 and the rotation they stand for.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

namespace sqmap::shape {

/// Rotation by three angles, ZYZ.
template <class Real>
struct EulerAngles {
    Real phi{0}, theta{0}, chi{0};  ///< radians
};

/// (Rz(phi) Ry(theta) Rz(chi)) transposed: rows are the local axes in the model frame.
template <class Real>
[[nodiscard]] Mat3<Real> rotation_of(EulerAngles<Real> angles) noexcept;

/// theta in [0, pi]. Where theta is 0 or pi only phi + chi (phi - chi) is determined: chi is 0 there.
template <class Real>
[[nodiscard]] EulerAngles<Real> euler_angles_of(const Mat3<Real>& rotation) noexcept;

}  // namespace sqmap::shape
