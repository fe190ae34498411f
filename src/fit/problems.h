// The two least-squares problems of a fit, for ceres::TinySolver, with exact derivatives by ceres::Jet.
#pragma once

#include "chart.h"
#include "volume.h"

#include "sqmap/fit/fit.h"

#include <ceres/jet.h>
#include <ceres/tiny_solver.h>

#include <array>
#include <span>
#include <vector>

namespace sqmap::fit {

struct Sample {
    Vec3d point;
    double weight;  ///< square root of its share of the area
};

/// Coordinates as jets that differentiate by themselves.
template <int N>
std::array<ceres::Jet<double, N>, N> seed(const double* t)
{
    std::array<ceres::Jet<double, N>, N> jets;
    for (int k = 0; k < N; ++k) jets[k] = ceres::Jet<double, N>(t[k], k);
    return jets;
}

template <class Real>
Vec3<Real> undeformed(const shape::Superquadric<Real>& sq, Vec3d p)
{
    return undeform(sq, to_local(sq, Vec3<Real>{Real(p.x), Real(p.y), Real(p.z)}));
}

template <class Real>
Real residual_of(Residual kind, const shape::Superquadric<Real>& sq, Vec3d p)
{
    using std::sqrt;
    const Vec3<Real> u = undeformed(sq, p);
    const Real f = shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, u);
    if (kind == Residual::Equation3) return sqrt(sqrt(sq.a.x * sq.a.y * sq.a.z)) * (f - 1.0);
    if (!(f > Real(1e-18))) return -sqrt(sq.a.x * sq.a.y);  // the centre itself has no ray: a constant, no derivative to speak of
    return sqrt(dot(u, u)) * (Real(1.0) - 1.0 / sqrt(f));
}

/// Eq. 3.
template <int N>
struct DataTerm {
    using Scalar = double;
    enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = N };

    const Chart& chart;
    std::span<const Sample> samples;
    Residual kind;

    int NumResiduals() const { return static_cast<int>(samples.size()); }
    bool operator()(const double* t, double* residuals, double* jacobian) const
    {
        const auto count = static_cast<Eigen::Index>(samples.size());
        if (jacobian == nullptr) {
            const auto sq = decode<N>(chart, t);
            for (Eigen::Index i = 0; i < count; ++i) residuals[i] = samples[i].weight * residual_of(kind, sq, samples[i].point);
            return true;
        }
        const auto sq = decode<N>(chart, seed<N>(t).data());
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, N>> j(jacobian, count, N);
        for (Eigen::Index i = 0; i < count; ++i) {
            const auto r = samples[i].weight * residual_of(kind, sq, samples[i].point);
            residuals[i] = r.a;
            j.row(i) = r.v.transpose();
        }
        return true;
    }
};

/// Least volume subject to f <= 1 at every point, by the augmented Lagrangian of inequality constraints (Nocedal and
/// Wright 2006, section 17.4), written as a sum of squares:
///   (log V - log V0 + 1)^2 + sum_i (sqrt(mu) max(0, g_i + lambda_i / mu))^2 + |proximal (t - t0)|^2,
/// g_i = log f_i, and three constraints log(a_k / (overhang * half extent)) against axes that run away from the part.
/// The proximal term (Rockafellar's method of multipliers) holds what no active constraint holds; t0 follows the rounds,
/// so it does not move the solution.
template <int N>
struct VolumeTerm {
    using Scalar = double;
    enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = N };

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

    int NumResiduals() const { return static_cast<int>(points.size()) + 4 + N; }

    /// Values of all constraints; extreme: for each axis the point of greatest extent along it.
    template <class Real>
    static Real log_f(const shape::Superquadric<Real>& sq, const Vec3<Real>& u)
    {
        using std::log;
        return 0.5 * log(shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, u) + 1e-30);
    }
    void constraints(const shape::Superquadricd& sq, double* g, std::array<std::size_t, 3>& extreme) const
    {
        Vec3d extent{1e-9, 1e-9, 1e-9};
        extreme = {0, 0, 0};
        const double round = 0.5 * std::log(2.0) * (sq.eps1 + sq.eps2);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Vec3d u = undeformed(sq, points[i]);
            // max |u_k / a_k| <= f <= 2^((eps1 + eps2) / 2) max |u_k / a_k|: no powers for points far inside.
            const double cube = std::max({std::abs(u.x / sq.a.x), std::abs(u.y / sq.a.y), std::abs(u.z / sq.a.z)});
            const double most = std::log(cube + 1e-15) + round;
            g[i] = most < 0 && !(lambda[i] > 0) ? most : log_f(sq, u);
            for (int k = 0; k < 3; ++k) {
                if (std::abs(u[k]) > extent[k]) {
                    extent[k] = std::abs(u[k]);
                    extreme[k] = i;
                }
            }
        }
        for (int k = 0; k < 3; ++k) g[points.size() + k] = std::log(sq.a[k] / (overhang * extent[k]));
    }

    bool operator()(const double* t, double* residuals, double* jacobian) const
    {
        using std::abs;
        using std::log;
        const std::size_t count = points.size();
        double* g = residuals + 1;
        if (!std::equal(t, t + N, last_.t.begin()) || last_.g.size() != count + 3) {
            const auto sq = decode<N>(chart, t);
            last_.g.resize(count + 3);
            constraints(sq, last_.g.data(), last_.extreme);
            last_.log_volume = log_volume(sq);
            std::copy_n(t, N, last_.t.begin());
        }
        const double root_mu = std::sqrt(mu);
        for (std::size_t i = 0; i < count + 3; ++i) g[i] = root_mu * std::max(0.0, last_.g[i] + lambda[i] / mu);
        residuals[0] = last_.log_volume - log_volume_0 + 1;
        for (int k = 0; k < N; ++k) g[count + 3 + k] = proximal * (t[k] - t0[k]);
        if (jacobian == nullptr) return true;

        const auto jets = decode<N>(chart, seed<N>(t).data());
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, N>> j(jacobian, static_cast<Eigen::Index>(count + 4 + N), N);
        j.setZero();
        j.row(0) = log_volume(jets).v.transpose();
        for (std::size_t i = 0; i < count; ++i)
            if (g[i] > 0)
                j.row(static_cast<Eigen::Index>(i + 1)) = root_mu * log_f(jets, undeformed(jets, points[i])).v.transpose();
        for (int k = 0; k < N; ++k) j(static_cast<Eigen::Index>(count + 4) + k, k) = proximal;
        for (int k = 0; k < 3; ++k) {
            if (!(g[count + k] > 0)) continue;
            const auto extent = abs(undeformed(jets, points[last_.extreme[k]])[k]);
            if (!(extent.a > 1e-9)) continue;
            j.row(static_cast<Eigen::Index>(count + 1) + k) = root_mu * log(jets.a[k] / extent).v.transpose();
        }
        return true;
    }

private:
    /// The solver asks twice at each accepted point, for the values and then for the derivatives.
    struct Evaluation {
        std::array<double, N> t{};
        std::vector<double> g;
        std::array<std::size_t, 3> extreme{};
        double log_volume = 0;
    };
    mutable Evaluation last_;
};

}  // namespace sqmap::fit
