#include "sqmap/haptic/step.h"

#include "haptic/stencil.h"
#include "touching.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::haptic::test {
namespace {

TEST(Step, FrictionTurnsABallAboutItsCentre)
{
    ZoneOptions o = with(Averaging::Ball);
    o.layer = query::Layer::Exact;
    o.smoothing = {.radius = 0.005, .points = 500, .tolerance = 0};
    Tool ball(stencil_points(o.smoothing), o);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Coulomb;
    const double depth = 0.001;
    Wrench w;
    for (int i = 0; i < 100; ++i) w = ball.touch(solid, Vec3d{5e-5 * i, 0, 0.035 - depth});
    EXPECT_NEAR(-w.force.x, solid.material.mu_dynamic * w.force.z, 0.01 * w.force.z) << "it slips";
    // r x F, with r from the centre to the place on the ground.
    EXPECT_NEAR(w.torque.y, -(0.005 - depth) * w.force.x, 2e-2 * 0.005 * std::abs(w.force.x));
    EXPECT_LT(std::hypot(w.torque.x, w.torque.z), 2e-2 * std::abs(w.torque.y));
}

TEST(Step, CoulombFrictionSticksThenSlipsWithinItsCone)
{
    Tool tool = Tool::point(exact);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Coulomb;
    Vec3d at{-0.01, 0, 0.029};
    (void)tool.touch(solid, at);
    bool stuck = false, slipped = false;
    double last = 0;
    for (int i = 0; i < 100; ++i) {
        at.x += 2e-5;
        const Vec3d f = tool.touch(solid, at).force;
        const double moved = 2e-5 * (i + 1), pull = -f.x;
        EXPECT_LE(pull, 0.4 * f.z + 2e-3);  // a sphere of samples is not quite level
        EXPECT_LT(std::abs(pull - last), 0.02) << "what lets go does not drop";
        last = pull;
        if ((tool.result.status & k_step_slipping) != 0) {
            EXPECT_GE(pull, 0.3 * f.z - 0.01);
            slipped = true;
        } else if (!slipped) {
            EXPECT_NEAR(pull, k * moved, 0.01);  // the sticking spring
            stuck = true;
        }
    }
    EXPECT_TRUE(stuck);
    EXPECT_TRUE(slipped);
    // Still: it holds, for ever.
    const Vec3d held = tool.touch(solid, at).force;
    EXPECT_NEAR(held.x, -0.3 * held.z, 0.01) << "the dynamic coefficient in the end";
    for (int i = 0; i < 1000; ++i) EXPECT_NEAR(tool.touch(solid, at).force.x, held.x, 1e-6);
    // Back by the stretch of the spring: nothing pulls.
    at.x -= 0.3 * held.z / k;
    EXPECT_NEAR(tool.touch(solid, at).force.x, 0, 0.02);
}

TEST(Step, FrictionNeverAddsEnergyAroundAClosedPath)
{
    Tool tool = Tool::point(exact);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Coulomb;
    double work = 0;
    Vec3d before{};
    Vec3d at{};
    for (int i = 0; i <= 2000; ++i) {
        const double a = 6.283185307179586 * i / 2000;
        const Vec3d next{0.004 * std::cos(a), 0.004 * std::sin(a), 0.029 + 0.0005 * std::sin(3 * a)};
        const Vec3d f = tool.touch(solid, next).force;
        if (i > 0) work += dot(0.5 * (f + before), next - at);
        before = f, at = next;
    }
    EXPECT_LT(work, -1e-3);
}

TEST(Step, PrintedFrictionIsEq33AndNothingWhileStill)
{
    Tool tool = Tool::point(exact);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Paper;
    (void)tool.touch(solid, Vec3d{0, 0, 0.029});
    Vec3d f = tool.touch(solid, Vec3d{0.0001, 0, 0.029}).force;
    EXPECT_NEAR(f.x, -0.2 * (1 + 100 * tool.report().depth), 0.01);
    f = tool.touch(solid, Vec3d{0.0001, 0, 0.029}).force;
    EXPECT_NEAR(f.x, 0, 0.01);
}

TEST(Step, DampingResistsPressingInAndNeverPulls)
{
    ZoneOptions o = exact;
    o.damping = 5;
    Tool tool = Tool::point(o);
    (void)tool.touch(frictionless(box()), Vec3d{0, 0, 0.0291});
    EXPECT_NEAR(tool.touch(frictionless(box()), Vec3d{0, 0, 0.029}).force.z, k * 0.001 + 5 * 0.1, 0.03);
    for (double z = 0.02905; z < 0.0300; z += 0.0002) EXPECT_GE(tool.touch(frictionless(box()), Vec3d{0, 0, z}).force.z, -1e-12);
}

TEST(Step, BrakingBeginsBeforeContactAndOnlyAgainstTheApproach)
{
    ZoneOptions o = exact;
    o.brake = 2;
    Tool tool = Tool::point(o);
    const Twist down{{0, 0, -0.4}, {}}, up{{0, 0, 0.4}, {}}, still{};
    const auto force = [&](const Twist& t, double z) {
        tool.state().reset();
        tool.input.twists = std::span(&t, 1);
        return tool.touch(frictionless(box()), Vec3d{0, 0, z}).force.z;
    };
    EXPECT_NEAR(force(down, 0.0305), 2 * 0.4 * 0.75, 0.05);  // 1.5 of the next 2 mm are in the solid
    EXPECT_EQ(force(down, 0.033), 0);
    EXPECT_EQ(force(up, 0.0305), 0);
    EXPECT_EQ(force(still, 0.0305), 0);
}

TEST(Step, ADamperTakesTheDevicesVelocityAndNotItsEncodersSteps)
{
    // Going in at a steady speed: a difference of two poses would make 0.05 N or nothing of it, by turns.
    constexpr double step = 25e-6;
    for (const double speed : {0.004, 0.01, 0.02, 0.05}) {
        ZoneOptions o = with(Averaging::Stencil);
        o.damping = 2;
        o.resolution = step;
        Tool tool(stencil_points({}), o);
        for (int i = 0; i < 60; ++i) {
            const double z = step * std::round((0.029 - speed * 0.001 * i) / step);
            const double force = tool.touch(frictionless(box()), Vec3d{0, 0, z}).force.z;
            const double damped = force - o.stiffness * tool.report().depth;
            if (i < 20) continue;
            EXPECT_NEAR(damped, 2 * speed, 0.4 * 2 * step / 0.001) << speed << ' ' << i;
        }
    }
}

}  // namespace
}  // namespace sqmap::haptic::test
