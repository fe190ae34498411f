#include "sqmap/haptic/stencil.h"

#include <cmath>

namespace sqmap::haptic {

namespace {

/// Of a uniform ball of radius 1: mean square and mean depth below a plane, the centre u deep, -1 <= u <= 1.
struct BallMoments {
    double second, first;
};
BallMoments ball_moments(double u)
{
    const double u2 = u * u;
    return {1.5 * (u2 * u / 6 - u2 * u2 * u / 60 + u2 / 3 + u / 4 + 1. / 15), 0.75 * (u2 / 2 - u2 * u2 / 12 + 2 * u / 3 + 0.25)};
}

}  // namespace

double mean_square_depth(const Smoothing& smoothing, double t) noexcept
{
    const double r = smoothing.radius;
    if (!(t > -r)) return 0;
    if (smoothing.kernel == Kernel::Shell) return t < r ? (t + r) * (t + r) * (t + r) / (6 * r) : t * t + r * r / 3;
    return t < r ? r * r * ball_moments(t / r).second : t * t + r * r / 5;
}

StencilDepth depth_of_stencil(const Smoothing& smoothing, double mean_square) noexcept
{
    const double r = smoothing.radius;
    if (!(mean_square > 0)) return {-r, 0};
    const double spread = smoothing.kernel == Kernel::Shell ? r * r / 3 : r * r / 5;
    if (mean_square >= r * r + spread) {
        const double t = std::sqrt(mean_square - spread);
        return {t, 0.5 / t};
    }
    if (smoothing.kernel == Kernel::Shell) {
        const double s = std::cbrt(6 * r * mean_square);  // t + r
        return {s - r, s / (3 * mean_square)};
    }
    // Increasing: Newton within a bracket.
    const double wanted = mean_square / (r * r);
    double lo = -1, hi = 1, u = 0;
    for (int i = 0; i < 40; ++i) {
        const BallMoments m = ball_moments(u);
        (m.second < wanted ? lo : hi) = u;
        double next = m.first > 0 ? u + (wanted - m.second) / (2 * m.first) : lo;
        if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
        if (std::abs(next - u) < 1e-12) break;
        u = next;
    }
    const double first = ball_moments(u).first;
    return {r * u, first > 0 ? 0.5 / (r * first) : 0};
}

}  // namespace sqmap::haptic
