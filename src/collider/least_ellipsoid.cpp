// L. Khachiyan, "Rounding of polytopes in the real number model of computation", 1996, with the steps away from points of
// P. Kumar and E. A. Yildirim, "Minimum-volume enclosing ellipsoids and core sets", 2005.
#include "collider/searches.h"

#include <Eigen/Dense>

#include <cmath>
#include <numbers>

namespace sqmap::collider {
namespace {

constexpr double k_accuracy = 1e-4;  ///< of the quadratic form: the volume is within 1.5 times this of the least
constexpr int k_max_steps = 20000;

}  // namespace

Candidate least_ellipsoid(std::span<const Vec3d> points)
{
    const auto n = static_cast<Eigen::Index>(points.size());
    Eigen::Matrix<double, 4, Eigen::Dynamic> q(4, n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const Vec3d& p = points[static_cast<std::size_t>(i)];
        q.col(i) << p.x, p.y, p.z, 1;
    }
    Eigen::VectorXd u = Eigen::VectorXd::Constant(n, 1.0 / static_cast<double>(n));
    for (int step = 0; step < k_max_steps; ++step) {
        const Eigen::Matrix4d x = q * u.asDiagonal() * q.transpose();
        const Eigen::VectorXd m = q.cwiseProduct(x.ldlt().solve(q)).colwise().sum().transpose();
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
    }
    const Eigen::Matrix<double, 3, Eigen::Dynamic> p = q.topRows<3>();
    const Eigen::Vector3d c = p * u;
    const Eigen::Matrix3d spread = p * u.asDiagonal() * p.transpose() - c * c.transpose();
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
