#include "decompose/curvature.h"

#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

namespace sqmap::decompose {
namespace {

TEST(GaussianCurvature, IsOneOverRadiusSquaredOnASphere)
{
    const mesh::Mesh m = mesh::sphere(2, 4);
    for (const double k : gaussian_curvature(m, mesh::dual_graph(m), 2, 0)) EXPECT_NEAR(k, 0.25, 0.01);
}

TEST(GaussianCurvature, FollowsTheClosedFormOnATorus)
{
    const mesh::TorusOptions o{.major_radius = 1, .minor_radius = 0.3, .major_segments = 120, .minor_segments = 48};
    const mesh::Mesh m = mesh::torus(o);
    const auto k = gaussian_curvature(m, mesh::dual_graph(m), 2, 0);
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t) {
        const Vec3d c = mesh::triangle_centroid(m, t);
        const double out = std::hypot(c.x, c.y) - o.major_radius, cosine = out / std::hypot(out, c.z);
        const double exact = cosine / (o.minor_radius * (o.major_radius + o.minor_radius * cosine));
        EXPECT_NEAR(k[t], exact, 0.4) << t;  // of a range from -4.8 to 2.6: a window is a mean
        if (std::abs(exact) > 0.5) {
            EXPECT_EQ(k[t] < 0, exact < 0) << t;
        }
    }
}

TEST(GaussianCurvature, IsThatOfAWindowNearbyWhereTrianglesAreMany)
{
    const mesh::TorusOptions o{.major_radius = 1, .minor_radius = 0.3, .major_segments = 460, .minor_segments = 120};
    const mesh::Mesh m = mesh::torus(o);
    ASSERT_GT(m.triangles.size(), 100000u);
    const double area = 4 * std::numbers::pi * std::numbers::pi * o.major_radius * o.minor_radius;
    const auto k = gaussian_curvature(m, mesh::dual_graph(m), 2, 1.25e-4 * area);
    std::set<double> windows;
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t) {
        windows.insert(k[t]);
        const Vec3d c = mesh::triangle_centroid(m, t);
        const double out = std::hypot(c.x, c.y) - o.major_radius, cosine = out / std::hypot(out, c.z);
        const double exact = cosine / (o.minor_radius * (o.major_radius + o.minor_radius * cosine));
        // A window is a mean, and its middle a quarter of its radius away at most, where curvature changes by up to 13 a unit.
        ASSERT_NEAR(k[t], exact, 0.4 + 0.25 * 0.077 * 13) << t;
        if (std::abs(exact) > 0.7) {
            ASSERT_EQ(k[t] < 0, exact < 0) << t;
        }
    }
    // Middles are a quarter of a radius apart, along paths that are up to 1.35 times as long as the straight ones.
    EXPECT_LT(1.7 * static_cast<double>(windows.size()), static_cast<double>(m.triangles.size()));
}

TEST(GaussianCurvature, AddsUpToTheEulerCharacteristic)
{
    for (const auto& [m, characteristic] :
         {std::pair{mesh::sphere(1, 3), 2.0}, std::pair{mesh::torus(), 0.0}, std::pair{mesh::dumbbell(), 2.0}}) {
        // Without a window a triangle has its share of its corners' deficits: the sum is exact (Gauss and Bonnet).
        const auto k = gaussian_curvature(m, mesh::dual_graph(m), 0, 0);
        double total = 0;
        for (std::uint32_t t = 0; t < k.size(); ++t) total += k[t] * mesh::triangle_area(m, t);
        EXPECT_NEAR(total, 2 * std::numbers::pi * characteristic, 1e-8);
    }
}

}  // namespace
}  // namespace sqmap::decompose
