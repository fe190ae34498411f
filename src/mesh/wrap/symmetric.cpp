#include "symmetric.h"

#include <algorithm>
#include <cmath>

namespace sqmap::mesh {

namespace {

struct Eigen {
    std::array<double, 3> values{};
    std::array<Vec3d, 3> vectors{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
};

/// Jacobi's rotations.
Eigen eigen_of(const PlaneSum& sum)
{
    double m[3][3] = {{sum.a[0], sum.a[3], sum.a[4]}, {sum.a[3], sum.a[1], sum.a[5]}, {sum.a[4], sum.a[5], sum.a[2]}};
    Eigen eigen;
    bool is_diagonal = false;
    for (int sweep = 0; sweep < 12 && !is_diagonal; ++sweep) {
        is_diagonal = true;
        for (int p = 0; p < 2; ++p) {
            for (int q = p + 1; q < 3; ++q) {
                if (std::abs(m[p][q]) <= 1e-15 * (std::abs(m[p][p]) + std::abs(m[q][q]))) continue;
                is_diagonal = false;
                const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
                const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
                const double c = 1 / std::sqrt(t * t + 1), s = t * c;
                for (auto& row : m) {
                    const double left = row[p], right = row[q];
                    row[p] = c * left - s * right;
                    row[q] = s * left + c * right;
                }
                for (int k = 0; k < 3; ++k) {
                    const double upper = m[p][k], lower = m[q][k];
                    m[p][k] = c * upper - s * lower;
                    m[q][k] = s * upper + c * lower;
                }
                const Vec3d first = eigen.vectors[p], second = eigen.vectors[q];
                eigen.vectors[p] = c * first - s * second;
                eigen.vectors[q] = s * first + c * second;
            }
        }
    }
    for (int k = 0; k < 3; ++k) eigen.values[k] = m[k][k];
    return eigen;
}

}  // namespace

Vec3d least_point(const PlaneSum& sum, Vec3d start, double share)
{
    const Eigen eigen = eigen_of(sum);
    const Vec3d residual = sum.b - sum.times(start);
    const double least = share * std::max({eigen.values[0], eigen.values[1], eigen.values[2]});
    Vec3d point = start;
    for (int k = 0; k < 3; ++k)
        if (eigen.values[k] > least && eigen.values[k] > 0)
            point += dot(eigen.vectors[k], residual) / eigen.values[k] * eigen.vectors[k];
    return point;
}

Vec3d damped_least_point(const PlaneSum& sum, Vec3d start, double share)
{
    const double damping = share * (sum.a[0] + sum.a[1] + sum.a[2]);
    const Vec3d x{sum.a[0] + damping, sum.a[3], sum.a[4]}, y{sum.a[3], sum.a[1] + damping, sum.a[5]},
        z{sum.a[4], sum.a[5], sum.a[2] + damping};
    const double volume = dot(x, cross(y, z));
    if (!(volume > 0)) return start;
    const Vec3d residual = sum.b - sum.times(start);
    return start + Vec3d{dot(residual, cross(y, z)), dot(residual, cross(z, x)), dot(residual, cross(x, y))} / volume;
}

}  // namespace sqmap::mesh
