#include "gradient.h"

#include "sqmap/fit/fit.h"

#include <cmath>
#include <numbers>

namespace sqmap::fit {

// Both: recurrence up to x >= 8, then the Stirling series (Abramowitz and Stegun 6.1.41 and 6.3.18).
double log_gamma(double x)
{
    double product = 1;
    for (; x < 8; x += 1) product *= x;
    const double y = 1 / (x * x);
    const double series =
        (1.0 / 12 - y * (1.0 / 360 - y * (1.0 / 1260 - y * (1.0 / 1680 - y * (1.0 / 1188 - y * 691.0 / 360360))))) / x;
    return (x - 0.5) * std::log(x) - x + 0.5 * std::log(2 * std::numbers::pi) + series - std::log(product);
}

double digamma(double x)
{
    double sum = 0;
    for (; x < 8; x += 1) sum += 1 / x;
    const double y = 1 / (x * x);
    const double series =
        y * (1.0 / 12 - y * (1.0 / 120 - y * (1.0 / 252 - y * (1.0 / 240 - y * (1.0 / 132 - y * 691.0 / 32760)))));
    return std::log(x) - 0.5 / x - series - sum;
}

namespace {

double log_beta(double x, double y) { return log_gamma(x) + log_gamma(y) - log_gamma(x + y); }

/// Slope of log_beta(x, y) where x and y have slopes dx and dy.
double log_beta_slope(double x, double dx, double y, double dy)
{
    return dx * digamma(x) + dy * digamma(y) - (dx + dy) * digamma(x + y);
}

}  // namespace

// Cross-section 4 a1 a2 int (1 - t^(2/eps2))^(eps2/2), swept along z with scale (1 - t^(2/eps1))^(eps1/2). Taper
// multiplies a section's area by (1 + Kx t)(1 + Ky t), whose linear part cancels by symmetry. The bend's Jacobian is
// 1 - k r, and r has zero mean.
double log_volume(const shape::Superquadricd& sq)
{
    const double half1 = sq.eps1 / 2, half2 = sq.eps2 / 2;
    const double sweep = log_beta(half1, sq.eps1 + 1);
    double result = std::log(2 * sq.a.x * sq.a.y * sq.a.z * sq.eps1 * sq.eps2) + log_beta(half2, half2 + 1) + sweep;
    if (sq.is_tapered()) {
        const double mean_t_sq = std::exp(log_beta(3 * half1, sq.eps1 + 1) - sweep);
        result += std::log(1 + sq.taper_x * sq.taper_y * mean_t_sq);
    }
    return result;
}

Gradient log_volume_gradient(const shape::Superquadricd& sq)
{
    Gradient g;
    for (int k = 0; k < 3; ++k) g.a[k] = 1 / sq.a[k];
    const double half1 = sq.eps1 / 2, half2 = sq.eps2 / 2;
    const double sweep = log_beta_slope(half1, 0.5, sq.eps1 + 1, 1);
    g.eps1 = 1 / sq.eps1 + sweep;
    g.eps2 = 1 / sq.eps2 + log_beta_slope(half2, 0.5, half2 + 1, 0.5);
    if (sq.is_tapered()) {
        const double mean_t_sq = std::exp(log_beta(3 * half1, sq.eps1 + 1) - log_beta(half1, sq.eps1 + 1));
        const double factor = 1 / (1 + sq.taper_x * sq.taper_y * mean_t_sq);
        g.eps1 += factor * sq.taper_x * sq.taper_y * mean_t_sq * (log_beta_slope(3 * half1, 1.5, sq.eps1 + 1, 1) - sweep);
        g.taper_x = factor * sq.taper_y * mean_t_sq;
        g.taper_y = factor * sq.taper_x * mean_t_sq;
    }
    return g;
}

double volume(const shape::Superquadricd& superquadric) { return std::exp(log_volume(superquadric)); }

}  // namespace sqmap::fit
