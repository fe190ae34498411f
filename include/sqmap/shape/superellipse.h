// The superellipse of eqs. 13 to 16: the one-dimensional piece every superquadric formula is a product of.
// Pure functions and plain data: any number of threads.
#pragma once

namespace sqmap::shape {

/// Distance from an octant plane, in units of the unit superellipse, closer than which derivatives of the normal are
/// those at this distance: for exponents above 1 the curvature grows without bound towards the plane.
template <class Real>
inline constexpr Real k_octant_margin = Real(1e-3);

/// Point at which the ray from the origin through (x, y) meets the unit superellipse |c|^(2/eps) + |s|^(2/eps) = 1.
///   (c, s) = (cos^eps t, sin^eps t) for the t of eq. 14, signs kept: the radial (equal-spaced) reading of eq. 9.
///   (nc, ns) = (sgn c |c|^(2/eps - 1), sgn s |s|^(2/eps - 1)), the outward normal direction (eq. 24 without s):
///   c nc + s ns = 1. Neither ever overflows, and never are both small.
///   gauge: (x, y) = gauge (c, s).
template <class Real>
struct Arc {
    Real c, s, nc, ns, gauge;
};

/// Derivatives of an arc by the spaced angle atan2(y, x). Those of c and s are bounded for every eps; those of nc and
/// ns are taken no closer than k_octant_margin to an octant plane.
template <class Real>
struct ArcDerivative {
    Real c, s, nc, ns;
};

/// @pre eps in [0.1, 2]. (0, 0) gives the arc of (1, 0) with gauge 0.
template <class Real>
[[nodiscard]] Arc<Real> arc_through(Real x, Real y, Real eps) noexcept;
/// Derivative of the arc where it stands. @pre as arc_through
template <class Real>
[[nodiscard]] ArcDerivative<Real> derivative(const Arc<Real>& arc, Real eps) noexcept;

/// sgn(v) |v|^exponent, 0 at 0 for exponents above 0.
template <class Real>
[[nodiscard]] Real signed_power(Real v, Real exponent) noexcept;

/// Eq. 9 with the quadrant fix of eq. 10: the parameter t of eq. 14 whose point lies at the spaced angle, both in
/// [-pi, pi]; quadrants are kept, multiples of pi/2 are fixed points.
template <class Real>
[[nodiscard]] Real parameter_of_spaced(Real spaced, Real eps) noexcept;
/// Inverse of parameter_of_spaced.
template <class Real>
[[nodiscard]] Real spaced_of_parameter(Real parameter, Real eps) noexcept;

/// Eq. 13: (x/a1)^(2/eps) + (y/a2)^(2/eps).
template <class Real>
struct Superellipse {
    Real a1{1}, a2{1}, eps{1};
};
/// Eq. 13 at (x, y): 1 on the curve, less inside.
template <class Real>
[[nodiscard]] Real implicit(const Superellipse<Real>& se, Real x, Real y) noexcept;

/// Eq. 15 and 16: the sign of theta_foot - theta_M that the paper predicts for an interior point at parameter theta_M;
/// 0 on the borders of the classes and at eps = 1. Right for equal axes only (errata 5): with axes 1 : 0.5 it is wrong
/// in many cases, so the search of query/ looks both ways and uses this for comparison with the paper alone.
template <class Real>
[[nodiscard]] int predicted_direction(Real theta, Real eps) noexcept;

}  // namespace sqmap::shape
