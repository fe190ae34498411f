// L. Khachiyan, "Rounding of polytopes in the real number model of computation", 1996, with the steps away from points of
// P. Kumar and E. A. Yildirim, "Minimum-volume enclosing ellipsoids and core sets", 2005, and the points left out that R. Harman
// and L. Pronzato, "Improvements on removing nonoptimal support points in D-optimum design algorithms", 2007, prove to be inside.
#include "collider/searches.h"

#include <Eigen/Dense>

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace sqmap::collider {
namespace {

constexpr double k_accuracy = 1e-4;  ///< of the quadratic form: the volume is within 1.5 times this of the least
constexpr int k_max_steps = 20000;
constexpr int k_steps_between = 16;  ///< steps after which points are left out

/// Points by coordinates, and ones.
using Coordinates = Eigen::Matrix<double, Eigen::Dynamic, 4>;

/// Solves l d l^T v = q in place for n points, whose coordinates are in the order of the factors' pivots.
void solve(const Eigen::Matrix4d& l, Eigen::Index n, double* __restrict__ q0, double* __restrict__ q1, double* __restrict__ q2,
           double* __restrict__ q3)
{
    const double l10 = l(1, 0), l20 = l(2, 0), l30 = l(3, 0), l21 = l(2, 1), l31 = l(3, 1), l32 = l(3, 2);
    const double d0 = l(0, 0), d1 = l(1, 1), d2 = l(2, 2), d3 = l(3, 3);
    for (Eigen::Index i = 0; i < n; ++i) {
        double v0 = q0[i], v1 = q1[i] - v0 * l10, v2 = q2[i] - v0 * l20, v3 = q3[i] - v0 * l30;
        v2 -= v1 * l21;
        v3 -= v1 * l31;
        v3 -= v2 * l32;
        v0 /= d0, v1 /= d1, v2 /= d2, v3 /= d3;
        v2 -= l32 * v3;
        v1 -= l21 * v2 + l31 * v3;
        v0 -= l10 * v1 + l20 * v2 + l30 * v3;
        q0[i] = v0, q1[i] = v1, q2[i] = v2, q3[i] = v3;
    }
}

/// x^-1 q. LDLT::solve has the same operations and gives the same bits, but copies its right side into blocks that pay off for
/// large matrices only; here the compiler takes several points at once. x must be regular.
void solve(const Eigen::LDLT<Eigen::Matrix4d>& x, const Coordinates& q, Coordinates& out)
{
    out = q;
    Eigen::Index order[4] = {0, 1, 2, 3};
    for (int k = 0; k < 4; ++k) std::swap(order[k], order[x.transpositionsP().indices()(k)]);
    solve(x.matrixLDLT(), q.rows(), out.col(order[0]).data(), out.col(order[1]).data(), out.col(order[2]).data(),
          out.col(order[3]).data());
}

/// Leaves out the points of which m, their form in the ellipsoid of weights u, proves that the least ellipsoid does not touch
/// them.
void leave_out_inner(Coordinates& q, Eigen::VectorXd& u, const Eigen::VectorXd& m)
{
    const double above = m.maxCoeff() - 4;
    const double inner = 4 * (1 + above / 2 - std::sqrt(above * (3 + above)) / 2) - k_accuracy;
    Eigen::Index kept = 0;
    for (Eigen::Index i = 0; i < q.rows(); ++i) {
        if (!(m(i) >= inner)) continue;
        q.row(kept) = q.row(i);
        u(kept++) = u(i);
    }
    q.conservativeResize(kept, Eigen::NoChange);
    u.conservativeResize(kept);
    u /= u.sum();
}

}  // namespace

Candidate least_ellipsoid(std::span<const Vec3d> points)
{
    auto n = static_cast<Eigen::Index>(points.size());
    Coordinates q(n, 4);
    for (Eigen::Index i = 0; i < n; ++i) {
        const Vec3d& p = points[static_cast<std::size_t>(i)];
        q.row(i) << p.x, p.y, p.z, 1;
    }
    Coordinates solved;
    Eigen::VectorXd m(n), u = Eigen::VectorXd::Constant(n, 1.0 / static_cast<double>(n));
    for (int step = 0; step < k_max_steps; ++step) {
        const Eigen::Matrix4d x = q.transpose() * u.asDiagonal() * q;
        const Eigen::LDLT<Eigen::Matrix4d> factors = x.ldlt();
        const bool is_regular = factors.vectorD().cwiseAbs().minCoeff() > std::numeric_limits<double>::min();
        if (is_regular) {
            solve(factors, q, solved);
            const auto products = [&](int k) { return q.col(k).cwiseProduct(solved.col(k)); };
            m = (products(0) + products(2)) + (products(1) + products(3));
        } else {
            m = q.transpose().cwiseProduct(factors.solve(q.transpose())).colwise().sum().transpose();
        }
        Eigen::Index far = 0, near = -1;
        const double greatest = m.maxCoeff(&far);
        double least = 4;
        for (Eigen::Index i = 0; i < n; ++i)
            if (u(i) > 1e-12 && m(i) < least) least = m(near = i);
        const double above = greatest / 4 - 1, below = 1 - least / 4;
        if (above <= k_accuracy && (below <= k_accuracy || near < 0)) break;
        if (above >= below || near < 0) {
            const double by = (greatest - 4) / (4 * (greatest - 1));
            u *= 1 - by;
            u(far) += by;
        } else {
            double by = (4 - least) / (4 * (least - 1));
            if (!(least > 1) || by > u(near) / (1 - u(near))) by = u(near) / (1 - u(near));
            u *= 1 + by;
            u(near) = std::max(0.0, u(near) - by);
        }
        if (is_regular && step % k_steps_between == k_steps_between - 1) {
            leave_out_inner(q, u, m);
            n = q.rows();
        }
    }
    const Eigen::Matrix<double, Eigen::Dynamic, 3> p = q.leftCols<3>();
    const Eigen::Vector3d c = p.transpose() * u;
    const Eigen::Matrix3d spread = p.transpose() * u.asDiagonal() * p - c * c.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
    Eigen::Matrix3d axes = solver.eigenvectors();
    if (axes.determinant() < 0) axes.col(2) *= -1;
    Candidate out;
    out.centre = {c(0), c(1), c(2)};
    for (int r = 0; r < 3; ++r) out.axes.row[r] = {axes(r, 0), axes(r, 1), axes(r, 2)};
    for (int k = 0; k < 3; ++k) out.size[k] = std::sqrt(std::max(3 * solver.eigenvalues()(k), 1e-18));
    double f = 0;
    for (const Vec3d& v : points) {
        const Vec3d l = transpose_mul(out.axes, v - out.centre);
        f = std::max(f, norm(Vec3d{l.x / out.size.x, l.y / out.size.y, l.z / out.size.z}));
    }
    out.size = f * out.size;
    out.volume = 4 * std::numbers::pi / 3 * out.size.x * out.size.y * out.size.z;
    return out;
}

}  // namespace sqmap::collider
