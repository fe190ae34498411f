#include "sqmap/haptic/tool.h"

#include "haptic/stencil.h"
#include "sqmap/paper/force.h"
#include "touching.h"

#include <gtest/gtest.h>

namespace sqmap::haptic {
namespace {

TEST(Tool, APointIsSmoothedOverItsSphere)
{
    const Tool tool({.force = {.smoothing = {.kernel = Kernel::Shell, .radius = 0.001}}, .shape = ToolShape::Point});
    const ZoneOptions& o = tool.zones().front().options;
    EXPECT_EQ(o.averaging, Averaging::Stencil);
    EXPECT_EQ(o.smoothing.kernel, Kernel::Shell);
    EXPECT_EQ(o.smoothing.tolerance, Smoothing{}.tolerance);
    EXPECT_EQ(tool.points().size(), Smoothing{}.points + 1);
    EXPECT_NEAR(norm(tool.points().front()), 0.001, 1e-5);
    EXPECT_EQ(tool.points().back(), Vec3d{});
}

TEST(Tool, ABallHasItsRadiusAndTheTolerancesOfBalls)
{
    const Tool tool({.shape = ToolShape::Ball, .ball_radius = 0.004});
    const ZoneOptions& o = tool.zones().front().options;
    EXPECT_EQ(o.averaging, Averaging::Ball);
    EXPECT_EQ(o.smoothing.radius, 0.004);
    EXPECT_EQ(o.smoothing.tolerance, ball_of(0.004).tolerance);
    EXPECT_NEAR(norm(tool.points().front()), 0.004, 1e-6);
    const Tool finer({.shape = ToolShape::Ball, .tolerance = 1e-5});
    EXPECT_EQ(finer.zones().front().options.smoothing.tolerance, 1e-5);
}

TEST(Tool, ASurfaceKeepsItsPoints)
{
    const Tool tool({.force = {.averaging = Averaging::Ball}, .points = test::square(5)});
    EXPECT_EQ(tool.zones().front().options.averaging, Averaging::Patch);
    EXPECT_EQ(tool.points().size(), 25u);
}

TEST(Tool, APointOnASmoothedMapIsThePointAlone)
{
    const Tool tool({.force = paper::with_paper_force({}), .shape = ToolShape::Point});
    EXPECT_EQ(tool.zones().front().options.averaging, Averaging::Patch);
    ASSERT_EQ(tool.points().size(), 1u);
    EXPECT_EQ(tool.points().front(), Vec3d{});
}

/// The force of a zone made by hand, with points and averaging that fit, is that of the tool.
TEST(Tool, ABallPushesAsItsZoneMadeByHand)
{
    const Tool tool({.force = test::exact, .shape = ToolShape::Ball, .ball_radius = 0.004});
    const Smoothing smoothing = ball_of(0.004);
    const query::Probe probe(stencil_points(smoothing));
    Zone zone{.probe = &probe, .options = test::exact};
    zone.options.averaging = Averaging::Ball;
    zone.options.smoothing = smoothing;
    State made = tool.state(), by_hand(std::span(&zone, 1));
    const TouchedBody body{.model = &test::box().view};
    for (const double z : {0.05, 0.035, 0.0335, 0.033}) {
        const Pose pose{{}, {0, 0, z}};
        Wrench a, b;
        (void)step(made, {.touched = {&body, 1}, .poses = {&pose, 1}}, {&a, 1});
        (void)step(by_hand, {.touched = {&body, 1}, .poses = {&pose, 1}}, {&b, 1});
        EXPECT_EQ(a, b) << z;
        EXPECT_EQ(norm(a.force) > 0, z < 0.034) << z;
    }
}

}  // namespace
}  // namespace sqmap::haptic
