#include "fit/problems.h"

#include "unit/fit/shapes.h"

#include <gtest/gtest.h>

namespace sqmap::fit {
namespace {

using namespace test;

struct Rows {
    std::vector<double> residuals;
    std::vector<double> slopes;  ///< #residuals by N
};

template <int N, class Problem>
Rows rows_at(const Problem& problem, const std::array<double, N>& t)
{
    Rows rows;
    problem.linearise(t.data(), [&](double residual, const double* row) {
        rows.residuals.push_back(residual);
        rows.slopes.insert(rows.slopes.end(), row, row + N);
    });
    return rows;
}

/// Compares a problem's derivatives with central differences of its residuals, and its cost with their squares.
template <int N, class Problem>
void expect_exact_slopes(const Problem& problem, const std::array<double, N>& t)
{
    const Rows rows = rows_at<N>(problem, t);
    double cost = 0;
    for (const double r : rows.residuals) cost += 0.5 * r * r;
    EXPECT_NEAR(problem.cost(t.data()), cost, 1e-12 * (1 + cost));
    for (int k = 0; k < N; ++k) {
        const double h = 1e-6;
        auto u = t;
        u[k] = t[k] + h;
        const Rows plus = rows_at<N>(problem, u);
        u[k] = t[k] - h;
        const Rows minus = rows_at<N>(problem, u);
        ASSERT_EQ(plus.residuals.size(), rows.residuals.size());
        ASSERT_EQ(minus.residuals.size(), rows.residuals.size());
        for (std::size_t i = 0; i < rows.residuals.size(); ++i) {
            const double slope = (plus.residuals[i] - minus.residuals[i]) / (2 * h);
            EXPECT_NEAR(rows.slopes[i * N + k], slope, 1e-5 * (1 + std::abs(slope))) << "row " << i << " parameter " << k;
        }
    }
}

template <int N>
std::array<double, N> random_coordinates(std::mt19937& random)
{
    std::array<double, N> t;
    for (double& v : t) v = uniform(random, -0.5, 0.5);
    t[3] = uniform(random, -4, 4);  // exponents over almost all of 0.1 to 2
    t[4] = uniform(random, -4, 4);
    return t;
}

template <int N>
void check_both_problems()
{
    std::mt19937 random(N);
    Chart chart;
    chart.frame = random_rotation(random);
    chart.min_a = 0.5;  // points stay before the apex of the taper, where F is of order one
    std::vector<Sample> samples;
    std::vector<Vec3d> points;
    for (int i = 0; i < 20; ++i) {
        const Vec3d p{uniform(random, -0.8, 0.8), uniform(random, -0.8, 0.8), uniform(random, -0.8, 0.8)};
        samples.push_back({p, uniform(random, 0.5, 1)});
        points.push_back(p);
    }
    for (int k = 0; k < 10; ++k) {
        const auto t = random_coordinates<N>(random);
        expect_exact_slopes<N>(DataTerm<N>{chart, samples, Residual::Radial}, t);
        expect_exact_slopes<N>(DataTerm<N>{chart, std::span(samples).first(4), Residual::Equation3}, t);
        VolumeTerm<N> problem(chart, points, 0.3);
        problem.log_volume_0 = 0.4;
        for (double& l : problem.lambda) l = 20;  // all constraints active
        expect_exact_slopes<N>(problem, t);
    }
}

TEST(Problems, SlopesOfThePlainModelMatchFiniteDifferences) { check_both_problems<k_plain>(); }
TEST(Problems, SlopesOfTheTaperedModelMatchFiniteDifferences) { check_both_problems<k_tapered>(); }
TEST(Problems, SlopesOfTheBentModelMatchFiniteDifferences) { check_both_problems<k_bent>(); }

TEST(Problems, DigammaIsTheSlopeOfLogGammaAndLogGammaIsThatOfFactorials)
{
    EXPECT_NEAR(log_gamma(0.5), std::log(std::sqrt(std::numbers::pi)), 1e-13);
    EXPECT_NEAR(log_gamma(6), std::log(120), 1e-13);
    for (double x = 0.05; x < 12; x += 0.31)
        EXPECT_NEAR(digamma(x), (log_gamma(x + 1e-5) - log_gamma(x - 1e-5)) / 2e-5, 1e-5 * (1 + 1 / (x * x)));
}

TEST(Chart, DecodesWhatItEncodedAndKeepsEveryBound)
{
    std::mt19937 random(3);
    for (int k = 0; k < 200; ++k) {
        std::array<double, k_bent> t;
        for (double& v : t) v = uniform(random, -30, 30);
        Chart chart;
        const auto sq = decode<k_bent>(chart, t.data());
        EXPECT_GE(sq.eps1, 0.1);
        EXPECT_LE(sq.eps2, 2.0);
        EXPECT_LE(std::abs(sq.taper_x), k_taper_limit);
        EXPECT_LE(sq.bend * sq.a.z, 2.0);
        EXPECT_LE(sq.bend * std::hypot((1 + std::abs(sq.taper_x)) * sq.a.x, (1 + std::abs(sq.taper_y)) * sq.a.y), 0.8);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(norm_sq(sq.rotation.row[i]), 1, 1e-12);
        for (double& v : t) v = uniform(random, -3, 3);
        const auto within = decode<k_bent>(chart, t.data());
        std::array<double, k_bent> back;
        Chart about;
        encode<k_bent>(within, about, back.data());
        const auto again = decode<k_bent>(about, back.data());
        EXPECT_NEAR(again.a.x, within.a.x, 1e-9);
        EXPECT_NEAR(again.taper_y, within.taper_y, 1e-9);
        EXPECT_NEAR(again.bend, within.bend, 1e-9);
        EXPECT_NEAR(again.eps2, within.eps2, 1e-9);
    }
}

TEST(BendLimit, TheBentShapeDoesNotFoldOver)
{
    // Injective: undeform brings every deformed point back, at the greatest bend the chart allows.
    std::mt19937 random(4);
    for (int k = 0; k < 50; ++k) {
        std::array<double, k_bent> t;
        for (double& v : t) v = uniform(random, -3, 3);
        t[13] = 20;
        const auto sq = decode<k_bent>(Chart{}, t.data());
        for (int i = 0; i < 50; ++i) {
            const Vec3d d = {uniform(random, -1, 1) * sq.a.x, uniform(random, -1, 1) * sq.a.y, uniform(random, -1, 1) * sq.a.z};
            const Vec3d q = d / std::max(1.0, std::sqrt(shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, d)));
            EXPECT_NEAR(norm(undeformed(sq, deform(sq, q)) - q), 0, 1e-9);
        }
    }
}

}  // namespace
}  // namespace sqmap::fit
