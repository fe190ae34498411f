#include "haptic/stencil.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::haptic {
namespace {

TEST(Stencil, MeanSquareDepthIsTheIntegralOverTheSphere)
{
    const double r = 0.002;
    for (const double t : {-0.0025, -0.0015, -0.0003, 0.0, 0.0008, 0.0019, 0.0021, 0.006}) {
        double sum = 0;
        constexpr int n = 200000;
        for (int i = 0; i < n; ++i) {  // bands of equal area
            const double depth = t - r * (2 * (i + 0.5) / n - 1);
            if (depth > 0) sum += depth * depth / n;
        }
        EXPECT_NEAR(mean_square_depth(r, t), sum, 1e-6 * r * r);
    }
}

TEST(Stencil, DepthOfStencilUndoesItWithItsSlope)
{
    const double r = 0.002, h = 1e-9;
    for (const double t : {-0.0019, -0.001, 0.0, 0.0005, 0.0019999, 0.0020001, 0.004}) {
        const double m = mean_square_depth(r, t);
        const StencilDepth d = depth_of_stencil(r, m);
        EXPECT_NEAR(d.depth, t, 1e-9);
        EXPECT_NEAR(d.slope, 2 * h / (mean_square_depth(r, t + h) - mean_square_depth(r, t - h)), 1e-3 * d.slope);
    }
    EXPECT_EQ(depth_of_stencil(r, 0).depth, -r);
    EXPECT_EQ(depth_of_stencil(r, 0).slope, 0);
}

TEST(Stencil, PointsHaveTheMomentsOfASphere)
{
    for (const std::uint32_t n : {8u, 24u, 48u, 500u}) {
        const std::vector<Vec3d> points = stencil_points({.radius = 0.003, .points = n});
        ASSERT_EQ(points.size(), n + 1);
        EXPECT_EQ(points.back(), Vec3d{});
        Vec3d mean{};
        double second[3][3] = {};
        for (std::uint32_t i = 0; i < n; ++i) {
            mean += points[i] / static_cast<double>(n);
            EXPECT_NEAR(norm(points[i]), 0.003, 0.003 * (n > 20 ? 0.03 : 0.1));
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) second[a][b] += points[i][a] * points[i][b] / n;
        }
        EXPECT_LT(norm(mean), 1e-12);
        for (int a = 0; a < 3; ++a)
            for (int b = 0; b < 3; ++b) EXPECT_NEAR(second[a][b], a == b ? 0.003 * 0.003 / 3 : 0, 1e-14);
    }
}

}  // namespace
}  // namespace sqmap::haptic
