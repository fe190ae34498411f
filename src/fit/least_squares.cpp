// The steps of Levenberg-Marquardt, on Eigen: Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares Problems (2004).
#include "least_squares.h"

#include "chart.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace sqmap::fit {

template <int N>
double NormalEquations<N>::largest_slope() const
{
    return Eigen::Map<const Eigen::Matrix<double, N, 1>>(gradient).cwiseAbs().maxCoeff();
}

template <int N>
double NormalEquations<N>::solve(double damping, double* step) const
{
    using Vector = Eigen::Matrix<double, N, 1>;
    using Matrix = Eigen::Matrix<double, N, N>;
    const Matrix normal(&matrix[0][0]);  // symmetric: rows for columns
    const Vector right(gradient);
    Matrix damped = normal;
    for (int i = 0; i < N; ++i) damped(i, i) += damping * std::clamp(normal(i, i), 1e-6, 1e32);
    const Vector solution = Eigen::LDLT<Matrix>(damped).solve(right);
    std::copy_n(solution.data(), N, step);
    return solution.dot(2 * right - normal * solution);
}

template struct NormalEquations<k_plain>;
template struct NormalEquations<k_tapered>;
template struct NormalEquations<k_bent>;

}  // namespace sqmap::fit
