// Levenberg-Marquardt for a few parameters: Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares Problems
// (2004), with the damping of Nielsen (1999).
#pragma once

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

/// The linear algebra of a step for N parameters. Only least_squares.cpp includes Eigen, because its headers and templates cost
/// each source that includes them many seconds; instantiated there for k_plain, k_tapered and k_bent parameters.
template <int N>
struct NormalEquations {
    double matrix[N][N];  ///< symmetric
    double gradient[N];

    /// Largest magnitude among the slopes.
    [[nodiscard]] double largest_slope() const;
    /// Solves (matrix + damping diagonal) step = gradient. Returns twice the decrease that the quadratic model predicts for the
    /// step.
    double solve(double damping, double* step) const;
};

/// Minimises the sum of squares of
///   double problem.cost(t): half that sum,
///   void problem.linearise(t, take): the same, calling take(residual, row) for every residual; rows that are zero may be
///   left out.
/// t: start and result, not finite where the problem is not.
template <int N, class Problem>
LeastSquaresReport minimise(const Problem& problem, double* t, const LeastSquaresOptions& options)
{
    NormalEquations<N> system;
    double scale[N];
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
            for (int k = 0; k <= i; ++k) system.matrix[i][k] = system.matrix[k][i] = *s++;
        if (first)
            for (int i = 0; i < N; ++i) scale[i] = 1 / (1 + std::sqrt(system.matrix[i][i]));
        for (int i = 0; i < N; ++i) {
            system.gradient[i] = scale[i] * slope[i];
            for (int k = 0; k < N; ++k) system.matrix[i][k] *= scale[i] * scale[k];
        }
    };
    linearise(true);
    const auto at_rest = [&] { return system.largest_slope() < 1e-10 || report.cost < 1e-16; };
    report.settled = at_rest();
    double damping = 1 / options.trust_region, growth = 2;
    for (report.iterations = 0; !report.settled && ++report.iterations < options.max_iterations;) {
        double step[N], next[N], length = 0, size = 0;
        const double predicted = system.solve(damping, step);
        for (int i = 0; i < N; ++i) {
            const double d = scale[i] * step[i];
            next[i] = t[i] + d;
            length += d * d;
            size += t[i] * t[i];
        }
        report.settled = std::sqrt(length) < 1e-8 * (std::sqrt(size) + 1e-8);
        if (report.settled) break;
        const double change = 2 * (report.cost - problem.cost(next));
        const double gain = change / predicted;
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
