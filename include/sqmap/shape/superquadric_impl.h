// Template bodies of shape/superquadric.h; also instantiated with automatic-differentiation scalars by fit/.
#pragma once

#include "sqmap/shape/superquadric.h"

namespace sqmap::shape {

template <class Real>
Vec3<Real> deform(const Superquadric<Real>& sq, Vec3<Real> q, Deformation which)
{
    using std::cos;
    using std::sin;
    if (which == Deformation::TaperThenBend && sq.is_tapered()) {
        q.x = q.x * (sq.taper_x * q.z / sq.a.z + Real(1));
        q.y = q.y * (sq.taper_y * q.z / sq.a.z + Real(1));
    }
    if (sq.is_bent()) {
        const Real ca = cos(sq.bend_angle), sa = sin(sq.bend_angle);
        const Real r = ca * q.x + sa * q.y;
        const Real gamma = q.z * sq.bend;
        const Real half = sin(gamma / Real(2));
        const Real shift = Real(2) * half * half * (Real(1) / sq.bend - r);  // R - r = (1/k - r) (1 - cos gamma)
        q = {q.x + ca * shift, q.y + sa * shift, (Real(1) / sq.bend - r) * sin(gamma)};
    }
    return q;
}

template <class Real>
Vec3<Real> undeform(const Superquadric<Real>& sq, Vec3<Real> q)
{
    using std::atan2;
    using std::cos;
    using std::sin;
    using std::sqrt;
    if (sq.is_bent()) {
        const Real ca = cos(sq.bend_angle), sa = sin(sq.bend_angle);
        const Real big_r = ca * q.x + sa * q.y;  // = cos(alpha - beta) hypot(x', y')
        const Real k = sq.bend;
        // Points beyond the centre of curvature fold over; there gamma grows past pi/2 and z = gamma / k is large, outside.
        const Real gamma = atan2(k * q.z, Real(1) - k * big_r);
        // R - r with r = 1/k - hypot(z', 1/k - R), free of the difference of two large numbers.
        const Real radius = sqrt(k * q.z * (k * q.z) + (Real(1) - k * big_r) * (Real(1) - k * big_r));
        const Real shift = big_r - (Real(2) * big_r - k * (big_r * big_r + q.z * q.z)) / (Real(1) + radius);
        q = {q.x - ca * shift, q.y - sa * shift, gamma / k};
    }
    if (sq.is_tapered()) {
        const Real fx = sq.taper_x * q.z / sq.a.z + Real(1);
        const Real fy = sq.taper_y * q.z / sq.a.z + Real(1);
        const Real tiny = Real(1e-6);
        q.x = q.x / (fx > tiny ? fx : tiny);
        q.y = q.y / (fy > tiny ? fy : tiny);
    }
    return q;
}

template <class Real>
Real implicit_undeformed(Vec3<Real> a, Real eps1, Real eps2, Vec3<Real> q)
{
    using std::abs;
    using std::pow;
    // (big^(2/e) + small^(2/e))^(e) = big^2 (1 + (small/big)^(2/e))^e: no power of a number above 1.
    const auto blend = [](Real u, Real v, Real eps) {
        const Real big = u > v ? u : v;
        const Real small = u > v ? v : u;
        if (!(small > Real(0))) return big;
        return big * pow(Real(1) + pow(small / big, Real(2) / eps), eps / Real(2));
    };
    const Real xy = blend(abs(q.x / a.x), abs(q.y / a.y), eps2);
    const Real f = blend(xy, abs(q.z / a.z), eps1);
    return f * f;
}

template <class Real>
Real implicit(const Superquadric<Real>& sq, Vec3<Real> p)
{
    return implicit_undeformed(sq.a, sq.eps1, sq.eps2, undeform(sq, to_local(sq, p)));
}

}  // namespace sqmap::shape
