// The unconstrained coordinates in which a superquadric is optimised.
#pragma once

#include "gradient.h"

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
    double min_a = 1e-3, max_a = 2;
    double min_eps = 0.1, max_eps = 2;
};

inline constexpr double k_taper_limit = 0.95;

inline double logistic(double t) { return 1 / (1 + std::exp(-t)); }
inline double logit(double p)
{
    p = std::clamp(p, 0.01, 0.99);  // farther out the logistic is so flat that a step could not come back
    return std::log(p / (1 - p));
}

/// Greatest curvature for which the bend is injective on the shape, with room to spare: k r < 0.8 there, so that nothing
/// reaches the centre of curvature, and |gamma| <= 2 < pi. Smooth in all parameters.
inline double bend_limit(const shape::Superquadricd& sq)
{
    const double rx = (1 + std::abs(sq.taper_x)) * sq.a.x, ry = (1 + std::abs(sq.taper_y)) * sq.a.y;
    return 1 / (sq.a.z / 2 + std::sqrt(rx * rx + ry * ry) / 0.8);
}

/// N = k_plain, k_tapered or k_bent coordinates: log-logistic a (3), eps1, eps2, turn (3), shift (3), taper (2), bend,
/// bend angle.
template <int N>
shape::Superquadricd decode(const Chart& chart, const double* t)
{
    const double low = std::log(chart.min_a), range = std::log(chart.max_a) - low;
    const double eps_range = chart.max_eps - chart.min_eps;
    shape::Superquadricd sq;
    for (int k = 0; k < 3; ++k) sq.a[k] = std::exp(low + range * logistic(t[k]));
    sq.eps1 = chart.min_eps + eps_range * logistic(t[3]);
    sq.eps2 = chart.min_eps + eps_range * logistic(t[4]);

    // Rotation of the unit quaternion (1, v) / |(1, v)|, v = tan(angle/2) axis.
    const double x = t[5], y = t[6], z = t[7], s = 2 / (1 + x * x + y * y + z * z);
    const Mat3d turn{{{1 - s * (y * y + z * z), s * (x * y - z), s * (x * z + y)},
                      {s * (x * y + z), 1 - s * (x * x + z * z), s * (y * z - x)},
                      {s * (x * z - y), s * (y * z + x), 1 - s * (x * x + y * y)}}};
    sq.rotation = turn * chart.frame;
    for (int k = 0; k < 3; ++k) sq.translation[k] = chart.centre[k] + t[8 + k];
    if constexpr (N >= k_tapered) {
        sq.taper_x = k_taper_limit * (2 * logistic(t[11]) - 1);
        sq.taper_y = k_taper_limit * (2 * logistic(t[12]) - 1);
    }
    if constexpr (N >= k_bent) {
        sq.bend = bend_limit(sq) * logistic(t[13]);
        sq.bend_angle = t[14];
    }
    return sq;
}

/// Derivatives of decode: turns those by a shape's parameters into those by coordinates.
template <int N>
class DecodeSlopes {
public:
    /// sq = decode(chart, t)
    DecodeSlopes(const Chart& chart, const double* t, const shape::Superquadricd& sq) : sq_(sq), frame_(chart.frame)
    {
        const auto slope = [](double v) { return logistic(v) * (1 - logistic(v)); };
        const double range = std::log(chart.max_a) - std::log(chart.min_a);
        for (int k = 0; k < 3; ++k) slope_[k] = range * slope(t[k]) * sq.a[k];
        for (int k = 3; k < 5; ++k) slope_[k] = (chart.max_eps - chart.min_eps) * slope(t[k]);
        for (int k = 11; k < std::min(N, 13); ++k) slope_[k] = 2 * k_taper_limit * slope(t[k]);

        // turn = I + s (v v^T - |v|^2 I + [v]), s = 2 / (1 + |v|^2)
        const Vec3d v{t[5], t[6], t[7]};
        const double s = 2 / (1 + norm_sq(v));
        const Mat3d cross_v{{{0, -v.z, v.y}, {v.z, 0, -v.x}, {-v.y, v.x, 0}}};
        for (int k = 0; k < 3; ++k) {
            Vec3d e;
            e[k] = 1;
            const Mat3d cross_e{{{0, -e.z, e.y}, {e.z, 0, -e.x}, {-e.y, e.x, 0}}};
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    turn_[k].row[i][j] = s * (e[i] * v[j] + v[i] * e[j] - (i == j ? 2 * v[k] : 0.0) + cross_e.row[i][j]) -
                                         s * s * v[k] * (v[i] * v[j] - (i == j ? norm_sq(v) : 0.0) + cross_v.row[i][j]);
        }
        if constexpr (N >= k_bent) {
            const double wx = 1 + std::abs(sq.taper_x), wy = 1 + std::abs(sq.taper_y);
            const double rx = wx * sq.a.x, ry = wy * sq.a.y, reach = 0.8 * std::sqrt(rx * rx + ry * ry);
            const double by_limit = -sq.bend * bend_limit(sq);  // bend = share / limit
            bend_by_a_ = by_limit * Vec3d{rx * wx / reach, ry * wy / reach, 0.5};
            bend_by_taper_[0] = by_limit * std::copysign(rx * sq.a.x / reach, sq.taper_x);
            bend_by_taper_[1] = by_limit * std::copysign(ry * sq.a.y / reach, sq.taper_y);
            slope_[13] = bend_limit(sq) * slope(t[13]);
        }
    }

    /// row: N derivatives by coordinates; p: the point in model space that g.q belongs to.
    void to_coordinates(const Gradient& g, Vec3d p, double* row) const
    {
        Vec3d a = g.a;
        double taper[] = {g.taper_x, g.taper_y};
        if constexpr (N >= k_bent) {
            a += g.bend * bend_by_a_;
            for (int k = 0; k < 2; ++k) taper[k] += g.bend * bend_by_taper_[k];
            row[13] = slope_[13] * g.bend;
            row[14] = g.bend_angle;
        }
        if constexpr (N >= k_tapered)
            for (int k = 0; k < 2; ++k) row[11 + k] = slope_[11 + k] * taper[k];
        for (int k = 0; k < 3; ++k) row[k] = slope_[k] * a[k];
        row[3] = slope_[3] * g.eps1;
        row[4] = slope_[4] * g.eps2;
        const Vec3d arm = frame_ * (p - sq_.translation), shift = transpose_mul(sq_.rotation, g.q);
        for (int k = 0; k < 3; ++k) {
            row[5 + k] = dot(g.q, turn_[k] * arm);
            row[8 + k] = -shift[k];
        }
    }

private:
    const shape::Superquadricd& sq_;
    Mat3d frame_, turn_[3];
    double slope_[15] = {};
    Vec3d bend_by_a_;
    double bend_by_taper_[2] = {};
};

/// The coordinates of sq in a chart about its own pose; parameters at a bound are taken just within it.
template <int N>
void encode(const shape::Superquadricd& sq, Chart& chart, double* t)
{
    chart.frame = sq.rotation;
    chart.centre = sq.translation;
    const double low = std::log(chart.min_a), range = std::log(chart.max_a) - low;
    for (int k = 0; k < 3; ++k) t[k] = logit((std::log(sq.a[k]) - low) / range);
    t[3] = logit((sq.eps1 - chart.min_eps) / (chart.max_eps - chart.min_eps));
    t[4] = logit((sq.eps2 - chart.min_eps) / (chart.max_eps - chart.min_eps));
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
