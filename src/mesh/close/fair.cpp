// Fairing by Laplace and bi-Laplace equations over the patch, the surface around it held: Liepa 2003; cotangent weights of
// U. Pinkall and K. Polthier, "Computing discrete minimal surfaces and their conjugates", 1993.
#include "patch.h"

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>

#include <cmath>

namespace sqmap::mesh {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

/// Cotangent Laplacian of patch and rim with weights kept positive, and a third of the area about each point.
struct Laplacian {
    Sparse matrix;
    Eigen::VectorXd area;
};

Laplacian laplacian(const Patch& patch)
{
    constexpr double k_min = 0.02, k_max = 20;  // cotangents of slivers mean nothing
    const auto n = static_cast<Eigen::Index>(patch.points.size());
    std::vector<Eigen::Triplet<double>> entries;
    Laplacian out{Sparse(n, n), Eigen::VectorXd::Zero(n)};
    const auto add = [&](const Triangle& t) {
        const Vec3d p[3] = {patch.points[t[0]], patch.points[t[1]], patch.points[t[2]]};
        const double twice_area = norm(cross(p[1] - p[0], p[2] - p[0]));
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
            const double cotangent = dot(p[i] - p[k], p[j] - p[k]) / std::max(twice_area, 1e-300);
            const double weight = 0.5 * std::clamp(cotangent, k_min, k_max);
            const auto a = static_cast<int>(t[i]), b = static_cast<int>(t[j]);
            entries.emplace_back(a, b, weight);
            entries.emplace_back(b, a, weight);
            entries.emplace_back(a, a, -weight);
            entries.emplace_back(b, b, -weight);
            out.area[static_cast<Eigen::Index>(t[k])] += twice_area / 6;
        }
    };
    for (const Triangle& t : patch.triangles) add(t);
    for (const Triangle& t : patch.rim) add(t);
    out.matrix.setFromTriplets(entries.begin(), entries.end());
    return out;
}

}  // namespace

bool fair(Patch& patch, Fairing fairing)
{
    const auto total = static_cast<Eigen::Index>(patch.points.size()), held = static_cast<Eigen::Index>(patch.first_inner);
    const Eigen::Index inner = total - held;
    if (inner == 0) return true;
    const Laplacian l = laplacian(patch);
    Sparse system = -l.matrix;
    if (fairing == Fairing::Smooth) {
        // Only rows whose points have all of their neighbours here: those of the loop and within.
        const double least = 1e-3 * l.area.mean();  // corners of slivers would outweigh all others
        Eigen::VectorXd inverse_area = l.area.cwiseMax(least).cwiseInverse();
        for (Eigen::Index i = patch.loop_size; i < held; ++i) inverse_area[i] = 0;
        system = l.matrix.transpose() * inverse_area.asDiagonal() * l.matrix;
    }
    // Relative to a point of the loop: coordinates may be far from zero.
    const Vec3d base = patch.points[0];
    Eigen::MatrixX3d x(total, 3);
    for (Eigen::Index i = 0; i < total; ++i)
        for (int k = 0; k < 3; ++k) x(i, k) = patch.points[static_cast<std::size_t>(i)][k] - base[k];
    const Sparse right = system.block(held, 0, inner, held), left = system.block(held, held, inner, inner);
    const Eigen::SimplicialLDLT<Sparse> solver(left);
    if (solver.info() != Eigen::Success) return false;
    const Eigen::MatrixX3d solved = solver.solve(-(right * x.topRows(held)));
    if (solver.info() != Eigen::Success || !solved.allFinite()) return false;
    for (Eigen::Index i = 0; i < inner; ++i)
        patch.points[static_cast<std::size_t>(held + i)] = base + Vec3d{solved(i, 0), solved(i, 1), solved(i, 2)};
    return true;
}

double smooth_share(const Patch& patch)
{
    const auto normal = [&](const Triangle& t) {
        const Vec3d a = patch.points[t[0]];
        return normalized(cross(patch.points[t[1]] - a, patch.points[t[2]] - a));
    };
    // The face on either side of each step of the loop.
    std::vector<Vec3d> within(patch.loop_size), beyond(patch.loop_size);
    for (const Triangle& t : patch.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            if (t[k] < patch.loop_size && t[(k + 1) % 3] == (t[k] + 1) % patch.loop_size) within[t[k]] = normal(t);
    for (const Triangle& t : patch.rim)
        for (std::size_t k = 0; k < 3; ++k)
            if (t[(k + 1) % 3] < patch.loop_size && t[k] == (t[(k + 1) % 3] + 1) % patch.loop_size)
                beyond[t[(k + 1) % 3]] = normal(t);
    double total = 0, smooth = 0;
    for (std::uint32_t i = 0; i < patch.loop_size; ++i) {
        const double length = norm(patch.points[(i + 1) % patch.loop_size] - patch.points[i]);
        total += length;
        if (dot(within[i], beyond[i]) > 0.5) smooth += length;
    }
    return total > 0 ? smooth / total : 0;
}

}  // namespace sqmap::mesh
