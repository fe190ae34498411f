// The unconstrained coordinates in which a superquadric is optimised.
#pragma once

#include "sqmap/shape/superquadric.h"

#include <algorithm>
#include <cmath>

namespace sqmap::fit {

/// How many of the paper's 15 parameters are free.
inline constexpr int k_plain = 11, k_tapered = 13, k_bent = 15;

/// Bounds and the pose about which coordinates are taken. Semi-axes, exponents, taper and bend are logistic functions of
/// their coordinates, so that no step can leave its bounds. The three Euler angles of eq. 2 are replaced by the Rodrigues
/// vector of the turn from the chart's frame, which has no gimbal lock within reach.
struct Chart {
    Mat3d frame;
    Vec3d centre;
    double least_a = 1e-3, greatest_a = 2;
    double least_eps = 0.1, greatest_eps = 2;
};

inline constexpr double k_taper_limit = 0.95;

template <class Real>
Real logistic(const Real& t)
{
    using std::exp;
    return Real(1.0) / (Real(1.0) + exp(-t));
}
inline double logit(double p)
{
    p = std::clamp(p, 0.01, 0.99);  // farther out the logistic is so flat that a step could not come back
    return std::log(p / (1 - p));
}

/// Greatest curvature for which the bend is injective on the shape, with room to spare: k r < 0.8 there, so that nothing
/// reaches the centre of curvature, and |gamma| <= 2 < pi. Smooth in all parameters.
template <class Real>
Real bend_limit(const shape::Superquadric<Real>& sq)
{
    using std::abs;
    using std::sqrt;
    const Real rx = (Real(1.0) + abs(sq.taper_x)) * sq.a.x, ry = (Real(1.0) + abs(sq.taper_y)) * sq.a.y;
    return Real(1.0) / (sq.a.z / 2.0 + sqrt(rx * rx + ry * ry) / 0.8);
}

/// N = k_plain, k_tapered or k_bent coordinates: log-logistic a (3), eps1, eps2, turn (3), shift (3), taper (2), bend,
/// bend angle.
template <int N, class Real>
shape::Superquadric<Real> decode(const Chart& chart, const Real* t)
{
    using std::exp;
    const double low = std::log(chart.least_a), range = std::log(chart.greatest_a) - low;
    const double eps_range = chart.greatest_eps - chart.least_eps;
    shape::Superquadric<Real> sq;
    for (int k = 0; k < 3; ++k) sq.a[k] = exp(low + range * logistic(t[k]));
    sq.eps1 = chart.least_eps + eps_range * logistic(t[3]);
    sq.eps2 = chart.least_eps + eps_range * logistic(t[4]);

    // Rotation of the unit quaternion (1, v) / |(1, v)|, v = tan(angle/2) axis.
    const Real x = t[5], y = t[6], z = t[7];
    const Real s = Real(2.0) / (Real(1.0) + x * x + y * y + z * z);
    const Real one(1.0);
    const Mat3<Real> turn{{{one - s * (y * y + z * z), s * (x * y - z), s * (x * z + y)},
                           {s * (x * y + z), one - s * (x * x + z * z), s * (y * z - x)},
                           {s * (x * z - y), s * (y * z + x), one - s * (x * x + y * y)}}};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            sq.rotation.row[i][k] = turn.row[i].x * chart.frame.row[0][k] + turn.row[i].y * chart.frame.row[1][k] +
                                    turn.row[i].z * chart.frame.row[2][k];
    for (int k = 0; k < 3; ++k) sq.translation[k] = chart.centre[k] + t[8 + k];
    if constexpr (N >= k_tapered) {
        sq.taper_x = k_taper_limit * (2.0 * logistic(t[11]) - 1.0);
        sq.taper_y = k_taper_limit * (2.0 * logistic(t[12]) - 1.0);
    }
    if constexpr (N >= k_bent) {
        sq.bend = bend_limit(sq) * logistic(t[13]);
        sq.bend_angle = t[14];
    }
    return sq;
}

/// The coordinates of sq in a chart about its own pose; parameters at a bound are taken just within it.
template <int N>
void encode(const shape::Superquadricd& sq, Chart& chart, double* t)
{
    chart.frame = sq.rotation;
    chart.centre = sq.translation;
    const double low = std::log(chart.least_a), range = std::log(chart.greatest_a) - low;
    for (int k = 0; k < 3; ++k) t[k] = logit((std::log(sq.a[k]) - low) / range);
    t[3] = logit((sq.eps1 - chart.least_eps) / (chart.greatest_eps - chart.least_eps));
    t[4] = logit((sq.eps2 - chart.least_eps) / (chart.greatest_eps - chart.least_eps));
    for (int k = 5; k < 11; ++k) t[k] = 0;
    if constexpr (N >= k_tapered) {
        t[11] = logit((sq.taper_x / k_taper_limit + 1) / 2);
        t[12] = logit((sq.taper_y / k_taper_limit + 1) / 2);
    }
    if constexpr (N >= k_bent) {
        t[13] = logit(sq.bend / bend_limit(sq));
        t[14] = sq.bend_angle;
    }
}

}  // namespace sqmap::fit
