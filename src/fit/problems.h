// The two least-squares problems of a fit, with exact derivatives.
#pragma once

#include "chart.h"
#include "gradient.h"
#include "undeformed_points.h"

#include "sqmap/fit/fit.h"

#include <array>
#include <limits>
#include <span>
#include <vector>

namespace sqmap::fit {

struct Sample {
    Vec3d point;
    double weight;  ///< square root of its share of the area
};

inline Vec3d undeformed(const shape::Superquadricd& sq, Vec3d p) { return undeform(sq, to_local(sq, p)); }

/// log_f_u: log f at the undeformed point u.
inline double residual_at(Residual kind, const shape::Superquadricd& sq, Vec3d u, double log_f_u)
{
    if (kind == Residual::Equation3) return std::pow(sq.a.x * sq.a.y * sq.a.z, 0.25) * (std::exp(2 * log_f_u) - 1);
    if (!(log_f_u > -20)) return -std::sqrt(sq.a.x * sq.a.y);  // the centre itself has no ray: a constant, without slope
    return norm(u) * (1 - std::exp(-log_f_u));
}

inline double residual_of(Residual kind, const shape::Superquadricd& sq, Vec3d p)
{
    const Vec3d u = undeformed(sq, p);
    return residual_at(kind, sq, u, log_f(sq, u, section_logs(sq, u)));
}

/// Eq. 3.
template <int N>
class DataTerm {
public:
    DataTerm(const Chart& chart, std::span<const Sample> samples, Residual kind) : chart_(chart), samples_(samples), kind_(kind)
    {
        points_.reserve(samples.size());
        for (const Sample& s : samples) points_.push_back(s.point);
    }

    double cost(const double* t) const
    {
        const auto sq = decode<N>(chart_, t);
        evaluate(sq, t);
        double sum = 0;
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const Vec3d u = last_.at.points()[i];
            const double r = samples_[i].weight * residual_at(kind_, sq, u, log_f(sq, u, last_.sections[i]));
            sum += 0.5 * r * r;
        }
        return sum;
    }

    template <class Take>
    void linearise(const double* t, Take&& take) const
    {
        const auto sq = decode<N>(chart_, t);
        const DecodeSlopes<N> slopes(chart_, t, sq);
        evaluate(sq, t);
        for (std::size_t i = 0; i < samples_.size(); ++i) {
            const Sample& s = samples_[i];
            Gradient g;
            Vec3d by_u;
            const Vec3d q = to_local(sq, s.point), u = last_.at.points()[i];
            const double value = log_f(sq, u, last_.sections[i], g, by_u);
            double residual = 0, by_log_f = 0;
            Vec3d by_length;
            double by_log_a = 0;
            if (kind_ == Residual::Equation3) {
                const double size = std::pow(sq.a.x * sq.a.y * sq.a.z, 0.25), f_sq = std::exp(2 * value);
                residual = size * (f_sq - 1);
                by_log_f = 2 * size * f_sq;
                by_log_a = 0.25 * residual;
            } else if (value > -20) {
                const double length = norm(u), inverse = std::exp(-value);
                residual = length * (1 - inverse);
                by_log_f = length * inverse;
                by_length = (1 - inverse) / length * u;
            } else {
                residual = -std::sqrt(sq.a.x * sq.a.y);
            }
            g.a = by_log_f * g.a;
            for (int k = 0; k < 3; ++k) g.a[k] += by_log_a / sq.a[k];
            g.eps1 *= by_log_f;
            g.eps2 *= by_log_f;
            through_undeform(sq, q, u, by_log_f * by_u + by_length, g);
            double row[N];
            slopes.to_coordinates(g, s.point, row);
            for (double& v : row) v *= s.weight;
            take(s.weight * residual, row);
        }
    }

private:
    /// The solver calls this twice at each accepted point, for the cost and then for the derivatives.
    void evaluate(const shape::Superquadricd& sq, const double* t) const
    {
        if (std::equal(t, t + N, last_.t.begin()) && last_.sections.size() == points_.size()) return;
        last_.at.take(sq, points_);
        last_.sections.clear();
        for (const Vec3d& u : last_.at.points()) last_.sections.push_back(section_logs(sq, u));
        std::copy_n(t, N, last_.t.begin());
    }

    const Chart& chart_;
    std::span<const Sample> samples_;
    Residual kind_;
    std::vector<Vec3d> points_;  ///< of the samples
    struct Evaluation {
        std::array<double, N> t{};
        UndeformedPoints at;
        std::vector<BlendLogs> sections;
    };
    mutable Evaluation last_;
};

/// Least volume subject to f <= 1 at every point, by the augmented Lagrangian of inequality constraints (Nocedal and
/// Wright 2006, section 17.4), written as a sum of squares:
///   (log V - log V0 + 1)^2 + sum_i (sqrt(mu) max(0, g_i + lambda_i / mu))^2 + |proximal (t - t0)|^2,
/// g_i = log f_i, and three constraints log(a_k / (overhang * half extent)) against axes that run away from the part.
/// The proximal term (Rockafellar's method of multipliers) holds what no active constraint holds; t0 follows the rounds,
/// so it does not move the solution.
template <int N>
struct VolumeTerm {
    VolumeTerm(const Chart& chart_in, std::span<const Vec3d> points_in, double overhang_in)
        : chart(chart_in), points(points_in), overhang(overhang_in), lambda(points_in.size() + 3)
    {
    }

    const Chart& chart;
    std::span<const Vec3d> points;
    double overhang;
    double log_volume_0 = 0;
    double mu = 5;
    double proximal = 0.3;
    std::array<double, N> t0{};
    std::vector<double> lambda;  ///< #points + 3

    /// Values of all constraints at t, or upper bounds of them where a constraint holds and no multiplier asks for more.
    /// Valid until the next call.
    const std::vector<double>& constraints(const double* t) const
    {
        evaluate(decode<N>(chart, t), t);
        return last_.g;
    }

    double cost(const double* t) const
    {
        const auto sq = decode<N>(chart, t);
        evaluate(sq, t);
        double sum = 0;
        const auto add = [&](double r) { sum += 0.5 * r * r; };
        add(last_.log_volume - log_volume_0 + 1);
        for (std::size_t i = 0; i < last_.g.size(); ++i) add(penalty(i));
        for (int k = 0; k < N; ++k) add(proximal * (t[k] - t0[k]));
        return sum;
    }

    template <class Take>
    void linearise(const double* t, Take&& take) const
    {
        const auto sq = decode<N>(chart, t);
        const DecodeSlopes<N> slopes(chart, t, sq);
        evaluate(sq, t);
        double row[N];
        slopes.to_coordinates(log_volume_gradient(sq), sq.translation, row);
        take(last_.log_volume - log_volume_0 + 1, row);
        const double root_mu = std::sqrt(mu);
        for (std::size_t i = 0; i < last_.g.size(); ++i) {
            const double residual = penalty(i);
            if (!(residual > 0)) continue;
            const std::size_t axis = i - points.size();  // wraps for points
            const Vec3d p = points[i < points.size() ? i : last_.extreme[axis]];
            const Vec3d q = to_local(sq, p), u = i < points.size() ? last_.at.points()[i] : undeform(sq, q);
            Gradient g;
            Vec3d by_u;
            if (i < points.size()) {
                (void)log_f(sq, u, last_.sections[i], g, by_u);
            } else {
                const int k = static_cast<int>(axis);
                if (!(std::abs(u[k]) > 1e-9)) continue;
                g.a[k] = 1 / sq.a[k];
                by_u[k] = -1 / u[k];
            }
            through_undeform(sq, q, u, by_u, g);
            slopes.to_coordinates(g, p, row);
            for (double& v : row) v *= root_mu;
            take(residual, row);
        }
        for (int k = 0; k < N; ++k) {
            std::fill_n(row, N, 0.0);
            row[k] = proximal;
            take(proximal * (t[k] - t0[k]), row);
        }
    }

private:
    double penalty(std::size_t i) const { return std::sqrt(mu) * std::max(0.0, last_.g[i] + lambda[i] / mu); }

    /// The solver calls this twice at each accepted point, for the cost and then for the derivatives.
    void evaluate(const shape::Superquadricd& sq, const double* t) const
    {
        if (std::equal(t, t + N, last_.t.begin()) && last_.g.size() == points.size() + 3) return;
        last_.g.resize(points.size() + 3);
        last_.sections.resize(points.size());
        last_.at.take(sq, points);
        take_values(sq);
        take_extents(sq);
        last_.log_volume = log_volume(sq);
        std::copy_n(t, N, last_.t.begin());
    }

    void take_values(const shape::Superquadricd& sq) const
    {
        constexpr double k_deep = 0.9, k_within = 1 - 1e-14;
        const std::span<const double> bounds = last_.at.bounds();
        std::size_t least_deep = points.size();
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (!(bounds[i] < k_within) || lambda[i] > 0) {
                const Vec3d u = last_.at.points()[i];
                last_.sections[i] = section_logs(sq, u);
                last_.g[i] = log_f(sq, u, last_.sections[i]);
            } else if (bounds[i] < k_deep) {  // only the greatest of such values matters
                last_.g[i] = -std::numeric_limits<double>::infinity();
                if (least_deep == points.size() || bounds[i] > bounds[least_deep]) least_deep = i;
            } else {
                last_.g[i] = std::log(bounds[i] + 1e-15);
            }
        }
        if (least_deep < points.size()) last_.g[least_deep] = std::log(bounds[least_deep] + 1e-15);
    }

    void take_extents(const shape::Superquadricd& sq) const
    {
        Vec3d extent{1e-9, 1e-9, 1e-9};
        last_.extreme = {0, 0, 0};
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3d u = last_.at.points()[i];
            for (int k = 0; k < 3; ++k) {
                if (std::abs(u[k]) > extent[k]) {
                    extent[k] = std::abs(u[k]);
                    last_.extreme[k] = i;
                }
            }
        }
        for (int k = 0; k < 3; ++k) last_.g[points.size() + k] = std::log(sq.a[k] / (overhang * extent[k]));
    }

    struct Evaluation {
        std::array<double, N> t{};
        UndeformedPoints at;
        std::vector<BlendLogs> sections;       ///< of the points that need log f
        std::vector<double> g;                 ///< values of all constraints
        std::array<std::size_t, 3> extreme{};  ///< for each axis the point of greatest extent along it
        double log_volume = 0;
    };
    mutable Evaluation last_;
};

}  // namespace sqmap::fit
