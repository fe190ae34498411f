// log f and the logarithm of the volume with their derivatives, in reverse: from the value back to what it depends on.
#pragma once

#include "sqmap/shape/superquadric.h"

#include <cmath>

namespace sqmap::fit {

/// Derivatives of a number by the parameters of a shape other than its pose, and by the local point.
struct Gradient {
    Vec3d a, q;
    double eps1 = 0, eps2 = 0, taper_x = 0, taper_y = 0, bend = 0, bend_angle = 0;
};

/// The logarithms in one of the two norms of f, blend(u, v) = big (1 + y)^(eps/2): y = r^(2/eps), r = small/big. The value and
/// its derivatives both need them.
struct BlendLogs {
    double log_r = 0, y = 0, log_sum = 0;  ///< log(1 + y); all 0 where small is 0
};
[[nodiscard]] inline BlendLogs blend_logs(double u, double v, double eps)
{
    const double big = u > v ? u : v, small = u > v ? v : u;
    if (!(small > 0)) return {};
    BlendLogs logs{.log_r = std::log(small / big)};
    logs.y = std::exp(2 / eps * logs.log_r);
    logs.log_sum = std::log(1 + logs.y);
    return logs;
}

/// log(blend(u, v)) = log big + eps/2 log(1 + y).
struct LogBlend {
    double value = 0, by_u = 0, by_v = 0, by_eps = 0;  ///< by_u, by_v: by log u and log v, adding up to 1
};

[[nodiscard]] inline LogBlend log_blend(double u, double v, double eps, const BlendLogs& logs)
{
    const double big = u > v ? u : v, small = u > v ? v : u;
    LogBlend out{std::log(big + 1e-300), 0, 0, 0};
    double share = 0;
    if (small > 0) {
        share = logs.y / (1 + logs.y);
        out.value += 0.5 * eps * logs.log_sum;
        out.by_eps = 0.5 * logs.log_sum - share * logs.log_r / eps;
    }
    out.by_u = u > v ? 1 - share : share;
    out.by_v = 1 - out.by_u;
    return out;
}

/// The logarithms in the norm of x and y, at an undeformed point.
[[nodiscard]] inline BlendLogs section_logs(const shape::Superquadricd& sq, Vec3d u)
{
    return blend_logs(std::abs(u.x / sq.a.x), std::abs(u.y / sq.a.y), sq.eps2);
}

/// log f, half the log of eq. 1, at an undeformed point.
[[nodiscard]] inline double log_f(const shape::Superquadricd& sq, Vec3d u, const BlendLogs& section)
{
    const double x = std::abs(u.x / sq.a.x), y = std::abs(u.y / sq.a.y), z = std::abs(u.z / sq.a.z);
    const double big = x > y ? x : y, small = x > y ? y : x;
    const double across = small > 0 ? big * std::exp(0.5 * sq.eps2 * section.log_sum) : big;
    return log_blend(across, z, sq.eps1, blend_logs(across, z, sq.eps1)).value;
}

/// log f at an undeformed point; adds its derivatives by axes and exponents, and gives those by the point.
[[nodiscard]] inline double log_f(const shape::Superquadricd& sq, Vec3d u, const BlendLogs& section_log, Gradient& gradient,
                                  Vec3d& by_u)
{
    const double x = std::abs(u.x / sq.a.x), y = std::abs(u.y / sq.a.y), z = std::abs(u.z / sq.a.z);
    const LogBlend section = log_blend(x, y, sq.eps2, section_log);
    const double across = std::exp(section.value);
    const LogBlend all = log_blend(across, z, sq.eps1, blend_logs(across, z, sq.eps1));
    gradient.eps1 += all.by_eps;
    gradient.eps2 += all.by_u * section.by_eps;
    const Vec3d by_log{all.by_u * section.by_u, all.by_u * section.by_v, all.by_v};
    for (int k = 0; k < 3; ++k) {
        gradient.a[k] -= by_log[k] / sq.a[k];
        by_u[k] = u[k] != 0 ? by_log[k] / u[k] : 0;
    }
    return all.value;
}

/// Adds the derivatives of a number that depends on u = undeform(q) by by_u.
inline void through_undeform(const shape::Superquadricd& sq, Vec3d q, Vec3d u, Vec3d by_u, Gradient& gradient)
{
    if (sq.is_tapered()) {
        const double slope = u.z / sq.a.z;
        const auto taper = [&](double factor, double value, double& by_value, double& by_factor) {
            const double f = factor * slope + 1;
            if (!(f > 1e-6)) {
                by_value /= 1e-6;
                return;
            }
            by_value /= f;
            const double by_f = -by_value * value;
            by_factor += by_f * slope;
            by_u.z += by_f * factor / sq.a.z;
            gradient.a.z -= by_f * factor * slope / sq.a.z;
        };
        taper(sq.taper_x, u.x, by_u.x, gradient.taper_x);
        taper(sq.taper_y, u.y, by_u.y, gradient.taper_y);
    }
    if (sq.is_bent()) {
        // In the bend's plane: r = c - rho and z = c gamma, polar about the centre of curvature, c = 1/bend away.
        const double ca = std::cos(sq.bend_angle), sa = std::sin(sq.bend_angle), c = 1 / sq.bend;
        const double along = ca * q.x + sa * q.y, across = ca * q.y - sa * q.x, b = c - along;
        const double rho_sq = b * b + q.z * q.z, rho = std::sqrt(rho_sq), r = c - rho, gamma = std::atan2(q.z, b);
        const double by_r = ca * by_u.x + sa * by_u.y, by_across = ca * by_u.y - sa * by_u.x;
        const double by_along = by_r * b / rho + by_u.z * c * q.z / rho_sq;
        gradient.bend -= c * c * (by_r * (1 - b / rho) + by_u.z * (gamma - c * q.z / rho_sq));
        gradient.bend_angle +=
            -by_u.x * (sa * r + ca * across) + by_u.y * (ca * r - sa * across) + by_along * across - by_across * along;
        by_u = {ca * by_along - sa * by_across, sa * by_along + ca * by_across, by_u.z * c * b / rho_sq - by_r * q.z / rho};
    }
    gradient.q += by_u;
}

/// log of the Gamma function and its derivative, x > 0; absolute error below 1e-13. Own code, as std::lgamma has no
/// derivative, writes a global and differs between C libraries.
[[nodiscard]] double log_gamma(double x);
[[nodiscard]] double digamma(double x);

[[nodiscard]] double log_volume(const shape::Superquadricd& sq);
/// Derivatives of log_volume.
[[nodiscard]] Gradient log_volume_gradient(const shape::Superquadricd& sq);

}  // namespace sqmap::fit
