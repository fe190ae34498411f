// Euler angles in the ZYZ order of Solina and Bajcsy 1990.
#include "sqmap/shape/superquadric.h"

#include <cmath>

namespace sqmap::shape {

template <class Real>
Mat3<Real> rotation_of(EulerAngles<Real> angles) noexcept
{
    const Real cp = std::cos(angles.phi), sp = std::sin(angles.phi);
    const Real ct = std::cos(angles.theta), st = std::sin(angles.theta);
    const Real cc = std::cos(angles.chi), sc = std::sin(angles.chi);
    return {{{cp * ct * cc - sp * sc, sp * ct * cc + cp * sc, -st * cc},
             {-cp * ct * sc - sp * cc, -sp * ct * sc + cp * cc, st * sc},
             {cp * st, sp * st, ct}}};
}

template <class Real>
EulerAngles<Real> euler_angles_of(const Mat3<Real>& rotation) noexcept
{
    const Vec3<Real> z = rotation.row[2];
    const Real st = norm(Vec3<Real>{z.x, z.y, 0});
    const Real theta = std::atan2(st, z.z);
    if (st < Real(1e-6)) return {std::atan2(-rotation.row[1].x, rotation.row[1].y), theta, Real(0)};
    return {std::atan2(z.y, z.x), theta, std::atan2(rotation.row[1].z, -rotation.row[0].z)};
}

#define SQMAP_INSTANTIATE(Real)                                  \
    template Mat3<Real> rotation_of(EulerAngles<Real>) noexcept; \
    template EulerAngles<Real> euler_angles_of(const Mat3<Real>&) noexcept;
SQMAP_INSTANTIATE(float)
SQMAP_INSTANTIATE(double)
#undef SQMAP_INSTANTIATE

}  // namespace sqmap::shape
