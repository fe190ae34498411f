// The superquadric with tapering and bending: the paper's 15-parameter model (section 2, eq. 1 and 2), its Euler angles and the
// sphere around it. Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/pose.h"
#include "sqmap/math/vec.h"

#include <cmath>

namespace sqmap::shape {

/// A superellipsoid, tapered and bent, in a frame of its own (section 2; deformations after Solina and Bajcsy 1990).
///
/// Local point of a model point p: q = rotation * (p - translation); rotation's rows are the local axes in model
/// space, rotation = (Rz(phi) Ry(theta) Rz(chi)) transposed for the ZYZ Euler angles of eq. 2.
/// Order of deformations, from undeformed to local: taper, then bend.
///   taper: X = (taper_x z/a.z + 1) x,  Y = (taper_y z/a.z + 1) y,  Z = z          taper_* in [-0.95, 0.95]
///   bend:  in the plane through z at angle bend_angle to the local x axis, with curvature bend >= 0 (1/length):
///          r = cos(bend_angle - atan2(Y, X)) hypot(X, Y);  gamma = Z bend;  R = 1/bend - (1/bend - r) cos gamma;
///          x' = X + cos(bend_angle) (R - r),  y' = Y + sin(bend_angle) (R - r),  z' = (1/bend - r) sin gamma.
template <class Real>
struct Superquadric {
    Vec3<Real> a{Real(1), Real(1), Real(1)};  ///< semi-axes, > 0, model units
    Real eps1{1}, eps2{1};                    ///< exponents, in [0.1, 2]
    Mat3<Real> rotation{};
    Vec3<Real> translation{};
    Real taper_x{0}, taper_y{0};
    Real bend{0};        ///< curvature k of eq. 2; 0 is straight
    Real bend_angle{0};  ///< alpha of eq. 2, radians

    constexpr bool is_tapered() const { return !(taper_x == Real(0)) || !(taper_y == Real(0)); }  ///< eq. 2 tapers
    constexpr bool is_bent() const { return !(bend == Real(0)); }                                 ///< eq. 2 bends
    constexpr bool is_deformed() const { return is_tapered() || is_bent(); }                      ///< either
};

/// In float.
using Superquadricf = Superquadric<float>;
/// In double.
using Superquadricd = Superquadric<double>;

/// In another number type, each parameter rounded to it.
template <class To, class From>
constexpr Superquadric<To> cast(const Superquadric<From>& sq)
{
    Superquadric<To> to;
    to.a = cast<To>(sq.a);
    to.eps1 = static_cast<To>(sq.eps1);
    to.eps2 = static_cast<To>(sq.eps2);
    for (int i = 0; i < 3; ++i) to.rotation.row[i] = cast<To>(sq.rotation.row[i]);
    to.translation = cast<To>(sq.translation);
    to.taper_x = static_cast<To>(sq.taper_x);
    to.taper_y = static_cast<To>(sq.taper_y);
    to.bend = static_cast<To>(sq.bend);
    to.bend_angle = static_cast<To>(sq.bend_angle);
    return to;
}

/// Local point of a model point.
template <class Real>
Vec3<Real> to_local(const Superquadric<Real>& sq, Vec3<Real> p)
{
    return sq.rotation * (p - sq.translation);
}
/// Model point of a local point.
template <class Real>
Vec3<Real> to_model(const Superquadric<Real>& sq, Vec3<Real> q)
{
    return transpose_mul(sq.rotation, q) + sq.translation;
}

/// Which deformations to apply: both in their order, or the bend alone (to a point that is tapered already).
enum class Deformation { TaperThenBend, BendOnly };

/// Tapers and bends an undeformed local point; written so that curvature towards zero loses no digits.
template <class Real>
Vec3<Real> deform(const Superquadric<Real>& sq, Vec3<Real> q, Deformation which = Deformation::TaperThenBend)
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

/// Undoes bend and taper: the point of the plain superellipsoid that the local point q came from.
/// Points where the taper vanishes (behind its apex) have no source: they map to infinity and so lie outside.
/// If bend * a.z >= pi, the body overlaps itself: of several sources, gives the one nearest to the middle of the axis.
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

/// F of eq. 1 at an undeformed local point.
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

/// Inside-outside function F of eq. 1 at a model point: <= 1 inside or on, > 1 outside; homogeneous of degree 2 in
/// the undeformed local point. Powers are taken of ratios <= 1 only, so exponents from 0.1 to 2 never overflow.
template <class Real>
Real implicit(const Superquadric<Real>& sq, Vec3<Real> p)
{
    return implicit_undeformed(sq.a, sq.eps1, sq.eps2, undeform(sq, to_local(sq, p)));
}

/// The ZYZ Euler angles of eq. 2.
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

/// A sphere that holds the whole superquadric, in its frame. Undeformed: centred and exact, in closed form. Tapered or bent:
/// centred on the samples of the surface, the radius proven by a Lipschitz bound between them (a few per cent above the least).
/// Cost: about 8,000 surface points when deformed; meant for bake time.
template <class Real>
[[nodiscard]] Sphere3<Real> bounding_sphere(const Superquadric<Real>& sq) noexcept;

}  // namespace sqmap::shape
