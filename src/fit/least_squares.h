// Levenberg-Marquardt for a few parameters: Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares Problems
// (2004), with the damping of Nielsen (1999).
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <span>

namespace sqmap::fit {

struct LeastSquaresOptions {
    int max_iterations = 30;
    double cost_change = 1e-8;  ///< of the sum of squares: less than that is no progress
    double trust_region = 1e4;  ///< the first step's, in coordinates scaled by their columns
};

struct LeastSquaresReport {
    double cost = 0;  ///< half the sum of squares
    int iterations = 0;
    bool settled = false;
};

[[nodiscard]] inline bool all_finite(std::span<const double> values)
{
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Minimises the sum of squares of
///   double problem.cost(t): half that sum,
///   void problem.linearise(t, take): the same, calling take(residual, row) for every residual; rows that are zero may be
///   left out.
/// t: start and result, not finite where the problem is not.
template <int N, class Problem>
LeastSquaresReport minimise(const Problem& problem, double* t, const LeastSquaresOptions& options)
{
    using Vector = Eigen::Matrix<double, N, 1>;
    using Matrix = Eigen::Matrix<double, N, N>;
    Matrix normal, damped;
    Vector gradient, scale;
    LeastSquaresReport report;
    const auto linearise = [&](bool first) {
        double sum[N * (N + 1) / 2] = {}, slope[N] = {};
        report.cost = 0;
        problem.linearise(t, [&](double residual, const double* row) {
            report.cost += 0.5 * residual * residual;
            double* s = sum;
            for (int i = 0; i < N; ++i) {
                slope[i] -= residual * row[i];
                for (int k = 0; k <= i; ++k) *s++ += row[i] * row[k];
            }
        });
        const double* s = sum;
        for (int i = 0; i < N; ++i)
            for (int k = 0; k <= i; ++k) normal(i, k) = normal(k, i) = *s++;
        if (first)
            for (int i = 0; i < N; ++i) scale[i] = 1 / (1 + std::sqrt(normal(i, i)));
        for (int i = 0; i < N; ++i) {
            gradient[i] = scale[i] * slope[i];
            for (int k = 0; k < N; ++k) normal(i, k) *= scale[i] * scale[k];
        }
    };
    linearise(true);
    const auto at_rest = [&] { return gradient.cwiseAbs().maxCoeff() < 1e-10 || report.cost < 1e-16; };
    report.settled = at_rest();
    double damping = 1 / options.trust_region, growth = 2;
    for (report.iterations = 0; !report.settled && ++report.iterations < options.max_iterations;) {
        damped = normal;
        for (int i = 0; i < N; ++i) damped(i, i) += damping * std::clamp(normal(i, i), 1e-6, 1e32);
        const Vector step = Eigen::LDLT<Matrix>(damped).solve(gradient);
        double next[N], length = 0, size = 0;
        for (int i = 0; i < N; ++i) {
            const double d = scale[i] * step[i];
            next[i] = t[i] + d;
            length += d * d;
            size += t[i] * t[i];
        }
        report.settled = std::sqrt(length) < 1e-8 * (std::sqrt(size) + 1e-8);
        if (report.settled) break;
        const double change = 2 * (report.cost - problem.cost(next));
        const double gain = change / step.dot(2 * gradient - normal * step);
        report.settled = std::abs(change) < options.cost_change;
        if (gain > 0) {
            std::copy_n(next, N, t);
            if (report.settled) {
                report.cost -= 0.5 * change;
                break;
            }
            linearise(false);
            report.settled = at_rest();
            damping *= std::max(1.0 / 3, 1 - std::pow(2 * gain - 1, 3));
            growth = 2;
        } else {
            damping *= growth;
            growth *= 2;
        }
    }
    return report;
}

}  // namespace sqmap::fit
