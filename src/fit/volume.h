// Volume of a superquadric as a differentiable expression.
// Jaklic, Leonardis and Solina, Segmentation and Recovery of Superquadrics (2000), chapter 2.
#pragma once

#include "sqmap/shape/superquadric.h"

#include <ceres/jet.h>

namespace sqmap::fit {

/// log of the Gamma function and its derivative, x > 0; absolute error below 1e-13. Own code, as std::lgamma has no
/// derivative, writes a global and differs between C libraries.
[[nodiscard]] double log_gamma(double x);
[[nodiscard]] double digamma(double x);

template <int N>
ceres::Jet<double, N> log_gamma(const ceres::Jet<double, N>& x)
{
    return {log_gamma(x.a), digamma(x.a) * x.v};
}

template <class Real>
Real log_beta(const Real& x, const Real& y)
{
    return log_gamma(x) + log_gamma(y) - log_gamma(Real(x + y));
}

/// Cross-section 4 a1 a2 int (1 - t^(2/eps2))^(eps2/2), swept along z with scale (1 - t^(2/eps1))^(eps1/2). Taper
/// multiplies a section's area by (1 + Kx t)(1 + Ky t), whose linear part cancels by symmetry. The bend's Jacobian is
/// 1 - k r, and r has zero mean.
template <class Real>
Real log_volume(const shape::Superquadric<Real>& sq)
{
    using std::exp;
    using std::log;
    const Real half1 = sq.eps1 / 2.0, half2 = sq.eps2 / 2.0, one(1.0);
    const Real section = log_beta(half2, Real(half2 + one));
    const Real sweep = log_beta(half1, Real(sq.eps1 + one));
    Real result = log(2.0 * sq.a.x * sq.a.y * sq.a.z * sq.eps1 * sq.eps2) + section + sweep;
    if (sq.is_tapered()) {
        const Real mean_t_sq = exp(log_beta(Real(3.0 * half1), Real(sq.eps1 + one)) - sweep);
        result += log(one + sq.taper_x * sq.taper_y * mean_t_sq);
    }
    return result;
}

}  // namespace sqmap::fit
