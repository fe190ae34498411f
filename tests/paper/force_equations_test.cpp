// Equations 21, 26 and 32 to 34 of the paper.
#include "sqmap/haptic/step.h"
#include "sqmap/haptic/texture.h"
#include "sqmap/math/friction.h"
#include "sqmap/paper/force.h"
#include "sqmap/query/point.h"
#include "support/paper_model.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap {
namespace {

// The servo's force on a ball of 0.8: everything has a closed form.
class PaperForceOnABall : public testing::Test {
protected:
    [[nodiscard]] Vec3d force_at(Vec3d p) const
    {
        const query::Probe probe(std::vector<Vec3d>(1));
        haptic::Zone zone{.probe = &probe, .options = paper::with_paper_force({.stiffness = 300})};
        haptic::State state(std::span(&zone, 1));
        haptic::TouchedBody ball{.model = &model.view()};
        ball.material.friction = Friction::None;
        const Pose pose{{}, p};
        haptic::Wrench wrench;
        (void)haptic::step(state, {.touched = std::span(&ball, 1), .poses = std::span(&pose, 1)}, std::span(&wrench, 1));
        return wrench.force;
    }
    // Section 6 as printed: the smoothed surface itself would lie within the ball.
    const test::PaperModel model{
        mesh::sphere(0.8, 5), {.exact = false}, {.grid = {33, 64}, .smoothing = paper::Smoothing::Distances}};
    const std::vector<Vec3d> points{{0.6, 0.3, 0.2}, {-0.1, 0.7, -0.3}, {0.2, -0.4, 0.6}, {-0.5, -0.5, -0.3}};
};

TEST_F(PaperForceOnABall, Eq21SizeFollowsTheMapsDepth)
{
    for (const Vec3d& p : points) EXPECT_NEAR(norm(force_at(p)), 300 * (0.8 - norm(p)), 300 * 0.002);
    EXPECT_EQ(force_at({0.7, 0.7, 0}), Vec3d{});
}

TEST_F(PaperForceOnABall, Eq32DirectionIsTheNormalOfEq26)
{
    for (const Vec3d& p : points) {
        const Vec3d f = force_at(p);
        EXPECT_GT(dot(normalized(f), normalized(p)), std::cos(0.02));
        const query::PointResult map = query::query_point(model.view(), p, {.smoothed_map = true});
        EXPECT_LT(norm(f - (300 * map.depth) * map.normal), 1e-4);
    }
}

TEST(Paper, Eq33FrictionAgainstTheMotionGrowsWithDepthAndIsNothingWhileStill)
{
    const Vec3d motion{0.001, -0.002, 0.0005};
    for (const double depth : {0.0, 0.001, 0.004}) {
        const Vec3d f = printed_friction({.f_c = 0.3, .k_f = 200}, depth, motion);
        EXPECT_NEAR(norm(f), 0.3 * (1 + 200 * depth), 1e-12);
        EXPECT_NEAR(dot(f, motion), -norm(f) * norm(motion), 1e-12);
    }
    EXPECT_EQ(printed_friction({.f_c = 0.3, .k_f = 200}, 0.001, {}), Vec3d{});
}

TEST(Paper, Eq34NoiseChangesTheSizeByItsHeightAndIsFixedInPlace)
{
    std::vector<float> values;
    const haptic::Texture texture = haptic::gaussian_texture({.amplitude = 0.0002}, values);
    const Vec3d n{0, 0, 1};
    for (int i = 0; i < 100; ++i) {
        const Vec3d p{1e-3 * i, 2e-3 * i, 0};
        const haptic::Relief r = haptic::relief_at(texture, p, n);
        const haptic::Carved c = haptic::carved(r, 0.005, n);
        // |S - (D + n_g)| with n_g = -height, a distance further in.
        EXPECT_NEAR(std::abs(0.105 - (0.100 - r.height)), c.depth, 1e-12);
        const haptic::Relief again = haptic::relief_at(texture, p, n);
        EXPECT_EQ(r.height, again.height);
    }
}

}  // namespace
}  // namespace sqmap
