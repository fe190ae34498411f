#include "decompose/saliency.h"

#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace sqmap::decompose {
namespace {

TEST(Protrusion, IsTheSameEverywhereOnASphere)
{
    const mesh::Mesh m = mesh::sphere(1, 3);
    GeodesicSolver geodesics(m);
    for (const double p : protrusion_at_vertices(m, geodesics, {.protrusion = ProtrusionSum::Exact})) EXPECT_NEAR(p, 1, 0.01);
}

// Eq. 4 by hand: mean geodesic distance, over its mean over the surface.
TEST(Protrusion, IsTheAreaWeightedSumOfDistances)
{
    const mesh::Mesh m = mesh::ellipsoid({1, 2, 3}, 2);
    GeodesicSolver geodesics(m);
    std::vector<double> sum(m.vertices.size(), 0.0), d;
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t) {
        geodesics.run_from_triangle(t, d);
        for (std::size_t v = 0; v < d.size(); ++v) sum[v] += d[v] * mesh::triangle_area(m, t);
    }
    const auto p = protrusion_at_vertices(m, geodesics, {.protrusion = ProtrusionSum::Exact});
    for (std::size_t v = 1; v < p.size(); ++v) EXPECT_NEAR(p[v] / p[0], sum[v] / sum[0], 1e-9);
}

TEST(Protrusion, SampledSourcesAgreeWithAllSources)
{
    const mesh::Mesh m = mesh::dumbbell({.segments = 24});
    GeodesicSolver geodesics(m);
    const auto exact = protrusion_at_vertices(m, geodesics, {.protrusion = ProtrusionSum::Exact});
    const auto sampled = protrusion_at_vertices(m, geodesics, {});
    for (std::size_t v = 0; v < exact.size(); ++v) EXPECT_NEAR(sampled[v], exact[v], 0.03);
}

TEST(SalientFeatures, AreTheTwoEndsOfAnEllipsoid)
{
    const mesh::Mesh m = mesh::ellipsoid({1, 1, 3}, 4);
    GeodesicSolver geodesics(m);
    const auto salient = salient_vertices(m, geodesics, protrusion_at_vertices(m, geodesics, {}), {0.5, 0.02});
    ASSERT_EQ(salient.size(), 2u);
    EXPECT_NEAR(std::abs(m.vertices[salient[0]].z), 3, 0.05);
    EXPECT_LT(m.vertices[salient[0]].z * m.vertices[salient[1]].z, 0);
}

TEST(SalientFeatures, AreNoneOnASphere)
{
    const mesh::Mesh m = mesh::sphere(1, 4);
    GeodesicSolver geodesics(m);
    EXPECT_TRUE(salient_vertices(m, geodesics, protrusion_at_vertices(m, geodesics, {}), {0.3, 0.02}).empty());
}

TEST(SalientFeatures, InOneWindowAreOnlyTheGreatest)
{
    const mesh::Mesh m = mesh::ellipsoid({1, 1, 3}, 3);
    GeodesicSolver geodesics(m);
    const auto salient = salient_vertices(m, geodesics, protrusion_at_vertices(m, geodesics, {}), {100, 0.02});
    EXPECT_EQ(salient.size(), 1u);
}

// On a sphere the band between two distances s and s + w from a pole has area 2 pi (cos s - cos(s + w)).
TEST(Locales, HaveTheAreaOfTheBandsOfASphere)
{
    const mesh::Mesh m = mesh::sphere(1, 5);
    GeodesicSolver geodesics(m);
    std::vector<double> d;
    const std::uint32_t pole = 0;
    geodesics.run({&pole, 1}, d);
    std::vector<std::uint32_t> all(m.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    std::vector<double> curvature(all.size(), -2.0);
    const double width = 0.1;
    const Locales l = locales_of(m, all, {d, curvature}, width);
    double total = 0;
    for (std::size_t k = 0; k < l.area.size(); ++k) {
        total += l.area[k];
        const double s = width * double(k), e = std::min(s + width, std::numbers::pi);
        EXPECT_NEAR(l.area[k], 2 * std::numbers::pi * (std::cos(s) - std::cos(e)), 0.03) << k;
        EXPECT_NEAR(l.hyperbolic_area[k], l.area[k], 1e-12);
        if (l.area[k] > 0) {
            EXPECT_NEAR(l.hyperbolic_curvature[k], -2, 1e-9);
        }
    }
    EXPECT_NEAR(total, mesh::surface_area(m), 1e-9);
}

}  // namespace
}  // namespace sqmap::decompose
