// Equations 2 to 7, of the superquadric's parameters, its fit and the decomposition, and 20 and 35, of the map's error.
#include "decompose/curvature.h"
#include "decompose/saliency.h"
#include "fit/problems.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/bake.h"
#include "sqmap/paper/projection.h"
#include "sqmap/shape/superquadric.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

namespace sqmap {
namespace {

using shape::Superquadricd;
using std::numbers::pi;

/// Eq. 1 as printed.
double printed_f(const Superquadricd& sq, Vec3d q)
{
    const double xy = std::pow(std::abs(q.x / sq.a.x), 2 / sq.eps2) + std::pow(std::abs(q.y / sq.a.y), 2 / sq.eps2);
    return std::pow(std::pow(xy, sq.eps2 / sq.eps1) + std::pow(std::abs(q.z / sq.a.z), 2 / sq.eps1), sq.eps1);
}

Superquadricd fifteen_parameters()
{
    Superquadricd sq{.a = {0.6, 0.8, 1.2}, .eps1 = 0.5, .eps2 = 1.4, .translation = {0.3, -0.2, 0.5}};
    const double c = std::cos(0.7), s = std::sin(0.7);
    sq.rotation.row[0] = {c, s, 0};
    sq.rotation.row[1] = {-s, c, 0};
    sq.rotation.row[2] = {0, 0, 1};
    sq.taper_x = 0.3;
    sq.taper_y = -0.2;
    sq.bend = 0.4;
    sq.bend_angle = 0.9;
    return sq;
}

TEST(Paper, Eq2FifteenParametersAreEq1OfThePointMovedUnbentAndUntapered)
{
    const Superquadricd sq = fifteen_parameters();
    const double c = std::cos(0.7), s = std::sin(0.7), centre = 1 / sq.bend;
    const double ca = std::cos(sq.bend_angle), sa = std::sin(sq.bend_angle);
    for (const Vec3d q : {Vec3d{0.1, 0.2, 0.3}, Vec3d{-0.4, 0.3, -0.7}, Vec3d{0.2, -0.6, 0.9}}) {
        // Forward, by hand: taper along z, bend about an axis at distance 1 / k, turn about z, move.
        Vec3d p{(sq.taper_x * q.z / sq.a.z + 1) * q.x, (sq.taper_y * q.z / sq.a.z + 1) * q.y, q.z};
        const double r = ca * p.x + sa * p.y, gamma = p.z * sq.bend;
        const double shift = centre - (centre - r) * std::cos(gamma) - r;
        p = {p.x + ca * shift, p.y + sa * shift, (centre - r) * std::sin(gamma)};
        p = Vec3d{c * p.x - s * p.y, s * p.x + c * p.y, p.z} + sq.translation;
        EXPECT_NEAR(shape::implicit(sq, p), printed_f(sq, q), 1e-9);
    }
}

TEST(Paper, Eq3CostIsTheMeanSquareOfFMinusOneTimesTheRootOfTheAxes)
{
    // The data term's residual, squared and summed, is eq. 3 as printed.
    const Superquadricd sq = fifteen_parameters();
    double sum = 0, printed = 0;
    for (const Vec3d p : {Vec3d{0.9, 0.1, 0.4}, Vec3d{0.2, 0.5, 1.4}, Vec3d{-0.1, -0.9, -0.2}}) {
        const double residual = fit::residual_of(fit::Residual::Equation3, sq, p);
        sum += residual * residual;
        const double f = shape::implicit(sq, p) - 1;
        printed += std::sqrt(sq.a.x * sq.a.y * sq.a.z) * f * f;
    }
    EXPECT_NEAR(sum, printed, 1e-9 * printed);
    // Zero on the surface alone.
    const Vec3d top = shape::to_model(sq, shape::deform(sq, Vec3d{0, 0, sq.a.z}));
    EXPECT_NEAR(fit::residual_of(fit::Residual::Equation3, sq, top), 0, 1e-9);
}

TEST(Paper, Eq4ProtrusionOfARodFollowsTheSumOfDistancesInClosedForm)
{
    // Along a thin rod from -h to h the mean distance from z is (h^2 + z^2) / (2 h); its mean over the rod is 2 h / 3.
    const double h = 8;
    const mesh::Mesh m = mesh::superquadric_surface({.a = {0.15, 0.15, h}, .eps1 = 0.1, .eps2 = 1}, 14);
    decompose::GeodesicSolver geodesics(m);
    const auto p = decompose::protrusion_at_vertices(m, geodesics, {.protrusion = decompose::ProtrusionSum::Exact});
    for (std::size_t v = 0; v < p.size(); ++v) {
        const double z = m.vertices[v].z;
        EXPECT_NEAR(p[v], (h * h + z * z) / (2 * h) / (2 * h / 3), 0.06) << z;
    }
}

TEST(Paper, Eq5OfFeaturesWithinOneGeodesicWindowTheGreatestIsSalient)
{
    // The ends of an ellipsoid are half a perimeter apart, geodesically: below that window both are salient, above it one.
    const mesh::Mesh m = mesh::ellipsoid({1, 1, 3}, 3);
    decompose::GeodesicSolver geodesics(m);
    const auto p = decompose::protrusion_at_vertices(m, geodesics, {});
    double half = 0;  // of an ellipse with semi-axes 1 and 3, by its arc
    constexpr int k_steps = 2000;
    for (int i = 0; i < k_steps; ++i) {
        const double t = pi * (i + 0.5) / k_steps;
        half += pi / k_steps * std::hypot(std::sin(t), 3 * std::cos(t));
    }
    EXPECT_EQ(decompose::salient_vertices(m, geodesics, p, {0.8 * half, 0.02}).size(), 2u);
    EXPECT_EQ(decompose::salient_vertices(m, geodesics, p, {1.2 * half, 0.02}).size(), 1u);
}

TEST(Paper, Eq6And7CurvatureIsTheDeterminantOfTheShapeOperator)
{
    // On an ellipsoid of revolution, S has the curvatures of the meridian and of the parallel: eq. 7 by differences of the
    // normal along both, eq. 6 their product. At the equator they are a / c^2 and 1 / a.
    const double a = 1, c = 1.6;
    const mesh::Mesh m = mesh::ellipsoid({a, a, c}, 5);
    const mesh::DualGraph graph = mesh::dual_graph(m);
    const std::vector<double> k = decompose::gaussian_curvature(m, graph, 4, 0);
    const auto normal = [&](double z) {  // of the meridian's curve: (r, z)
        const double r = a * std::sqrt(1 - z * z / (c * c)), length = std::hypot(r / (a * a), z / (c * c));
        return std::pair{r / (a * a) / length, z / (c * c) / length};
    };
    double worst = 0;
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t) {
        const double z = mesh::triangle_centroid(m, t).z;
        if (std::abs(z) > 0.8 * c) continue;
        const double step = 1e-5, r = a * std::sqrt(1 - z * z / (c * c));
        const auto [nr_lo, nz_lo] = normal(z - step);
        const auto [nr_hi, nz_hi] = normal(z + step);
        const double slope = -a * z / (c * c) / std::sqrt(1 - z * z / (c * c));
        const double along_meridian = std::hypot(nr_hi - nr_lo, nz_hi - nz_lo) / (2 * step * std::hypot(1, slope));
        const double along_parallel = normal(z).first / r;
        worst = std::max(worst, std::abs(k[t] / (along_meridian * along_parallel) - 1));
    }
    EXPECT_LT(worst, 0.08);
}

TEST(Paper, Eq20SurfacePointsAreTheirFeetMovedInByTheMap)
{
    // A ball of radius 0.6 in an ellipsoid: y - D(y) n(y) of any sample y lies on the ball.
    const mesh::Mesh m = mesh::sphere(0.6, 5);
    Superquadricd sq;
    sq.a = {0.7, 0.8, 1.0};
    std::vector<std::uint32_t> all(m.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    const paper::Map map = paper::bake_map(paper::MapRays(m), all, sq, {.min_level = 5, .max_level = 5});
    int count = 0;
    for (double eta = -1.4; eta < 1.5; eta += 0.2)
        for (double omega = -3; omega < 3.1; omega += 0.3) {
            const Vec3d direction{std::cos(eta) * std::cos(omega), std::cos(eta) * std::sin(omega), std::sin(eta)};
            const auto answer = paper::project(map.view(), cast<float>(0.6 * direction), {.corrections = false});
            if (answer.verdict == paper::Verdict::Outside) continue;
            // depth_along is what eq. 20 misses the point by: the stored distance against the point's own.
            EXPECT_NEAR(static_cast<double>(answer.depth_along), 0, 2e-3);
            ++count;
        }
    EXPECT_GT(count, 200);
}

TEST(Paper, Eq35IsTheDistanceAlongTheProjectionOverTheLargestExtent)
{
    // A ball's model against the ball grown by a hundredth: along every ray through the centre both differ by a hundredth of
    // the radius, half a percent of R_max. (The printed sum grows with the number of points: its mean is measured.)
    const test::Parsed ball(mesh::sphere(1, 4));
    constexpr double k_growth = 0.01;
    const mesh::Mesh grown = test::mapped(ball.mesh(), 1 + k_growth, {});
    const mesh::Solid solid(grown, {});
    const bake::Evaluation same = bake::evaluate(ball.view(), ball.solid(), {.points = 2000});
    const bake::Evaluation off = bake::evaluate(ball.view(), solid, {.points = 2000});
    EXPECT_GT(off.eq35.count, 500u);
    EXPECT_LT(same.eq35.mean, 0.05);
    EXPECT_NEAR(off.eq35.mean, 100 * k_growth / 2, 0.05);
    EXPECT_NEAR(off.eq35.median, 100 * k_growth / 2, 0.05);
}

}  // namespace
}  // namespace sqmap
