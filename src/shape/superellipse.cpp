// Moustakas, Tzovaras, Strintzis, "SQ-Map", eqs. 9, 10 and 13 to 16; spacing after Franklin and Barr 1981.
// Powers are taken of ratios in [0, 1] only, so no exponent from 0.1 to 2 overflows, in float either.
#include "sqmap/shape/superellipse.h"

#include "sqmap/math/assert.h"

#include <cmath>
#include <numbers>

namespace sqmap::shape {

namespace {

/// In [0.1, 2]; the ends may be rounded.
template <class Real>
constexpr bool is_exponent(Real eps)
{
    return eps > Real(0.0999) && eps < Real(2.001);
}

}  // namespace

template <class Real>
Arc<Real> arc_through(Real x, Real y, Real eps) noexcept
{
    SQMAP_ASSERT(is_exponent(eps));
    const Real ax = std::abs(x), ay = std::abs(y);
    const bool x_is_big = ax >= ay;
    const Real big = x_is_big ? ax : ay, small = x_is_big ? ay : ax;
    if (!(big > Real(0))) return {1, 0, 1, 0, 0};
    const Real ratio = small / big;
    const Real power = ratio > Real(0) ? std::pow(ratio, Real(2) / eps) : Real(0);
    const Real sum = Real(1) + power;
    const Real scale = std::pow(sum, -eps / Real(2));  // c of the larger coordinate
    // |c|^(2/eps) is 1/sum for the larger and power/sum for the smaller coordinate; divided by |c| it is the normal.
    const Real c_big = scale, c_small = ratio * scale;
    const Real n_big = Real(1) / (sum * scale);
    // ratio^(2/eps - 1): at eps = 2 the exponent is 0, and the octant plane itself belongs to neither face.
    const Real n_small = ratio > Real(0) ? power / ratio * n_big : Real(0);
    const Real sx = x < Real(0) ? Real(-1) : Real(1), sy = y < Real(0) ? Real(-1) : Real(1);
    return {sx * (x_is_big ? c_big : c_small), sy * (x_is_big ? c_small : c_big), sx * (x_is_big ? n_big : n_small),
            sy * (x_is_big ? n_small : n_big), big / scale};
}

template <class Real>
ArcDerivative<Real> derivative(const Arc<Real>& arc, Real eps) noexcept
{
    SQMAP_ASSERT(is_exponent(eps));
    // The tangent is perpendicular to (nc, ns), and c ds - s dc = c^2 + s^2 for the polar angle.
    const Real radius_sq = arc.c * arc.c + arc.s * arc.s;
    const Real dc = -radius_sq * arc.ns, ds = radius_sq * arc.nc;
    const auto slope = [eps](Real c, Real n) {  // d(|c|^(2/eps - 1))/d|c|
        const Real exponent = Real(2) / eps - Real(1), size = std::abs(c);
        if (size >= k_octant_margin<Real>) return exponent * std::abs(n) / size;
        return exponent * std::pow(k_octant_margin<Real>, exponent - Real(1));
    };
    return {dc, ds, slope(arc.c, arc.nc) * dc, slope(arc.s, arc.ns) * ds};
}

template <class Real>
Real signed_power(Real v, Real exponent) noexcept
{
    if (v == Real(0)) return Real(0);
    return std::copysign(std::pow(std::abs(v), exponent), v);
}

namespace {

// atan(|tan t|^exponent) in the quadrant of t. Folded to [0, pi/4], where the tangent is at most 1.
template <class Real>
Real respaced(Real t, Real exponent) noexcept
{
    constexpr Real k_half_pi = std::numbers::pi_v<Real> / 2;
    const Real size = std::abs(t);
    const bool obtuse = size > k_half_pi;
    const Real acute = obtuse ? Real(2) * k_half_pi - size : size;
    const bool steep = acute > k_half_pi / 2;
    const Real tangent = std::tan(steep ? k_half_pi - acute : acute);
    Real angle = tangent > Real(0) ? std::atan(std::pow(tangent, exponent)) : Real(0);
    if (steep) angle = k_half_pi - angle;
    if (obtuse) angle = Real(2) * k_half_pi - angle;
    return std::copysign(angle, t);
}

}  // namespace

template <class Real>
Real parameter_of_spaced(Real spaced, Real eps) noexcept
{
    return respaced(spaced, Real(1) / eps);
}
template <class Real>
Real spaced_of_parameter(Real parameter, Real eps) noexcept
{
    return respaced(parameter, eps);
}

template <class Real>
Real implicit(const Superellipse<Real>& se, Real x, Real y) noexcept
{
    const Real gauge = arc_through(x / se.a1, y / se.a2, se.eps).gauge;
    return gauge > Real(0) ? std::pow(gauge, Real(2) / se.eps) : Real(0);
}

template <class Real>
int predicted_direction(Real theta, Real eps) noexcept
{
    constexpr Real k_half_pi = std::numbers::pi_v<Real> / 2;
    const Real within = theta - k_half_pi * std::floor(theta / k_half_pi);
    if (within == Real(0) || within == k_half_pi / 2 || eps == Real(1)) return 0;
    const bool set_a = within < k_half_pi / 2;
    return set_a == (eps < Real(1)) ? -1 : 1;
}

#define SQMAP_INSTANTIATE(Real)                                               \
    template Arc<Real> arc_through(Real, Real, Real) noexcept;                \
    template ArcDerivative<Real> derivative(const Arc<Real>&, Real) noexcept; \
    template Real signed_power(Real, Real) noexcept;                          \
    template Real parameter_of_spaced(Real, Real) noexcept;                   \
    template Real spaced_of_parameter(Real, Real) noexcept;                   \
    template Real implicit(const Superellipse<Real>&, Real, Real) noexcept;   \
    template int predicted_direction(Real, Real) noexcept;
SQMAP_INSTANTIATE(float)
SQMAP_INSTANTIATE(double)
#undef SQMAP_INSTANTIATE

}  // namespace sqmap::shape
