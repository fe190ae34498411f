#include "sqmap/haptic/step.h"

#include "haptic/stencil.h"
#include "sqmap/mesh/solid.h"
#include "touching.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::haptic::test {
namespace {

TEST(Step, ATouchThatCrossesTheMedialAxisIsBlended)
{
    // From one side of a plate to the other: the way out turns round.
    for (const double blend : {0.0, 0.01}) {
        ZoneOptions o = with(Averaging::Patch);
        o.blend_time = blend;
        Tool tool({{0, 0, 0}}, o);
        Vec3d before = tool.touch(frictionless(plate()), Vec3d{0, 0, 0.0009}).force;
        double largest = 0;
        bool blended = false;
        for (double z = 0.00085; z > -0.0008; z -= 5e-5) {
            const Vec3d f = tool.touch(frictionless(plate()), Vec3d{0, 0, z}).force;
            largest = std::max(largest, norm(f - before));
            blended = blended || (tool.result.status & k_step_blended) != 0;
            before = f;
        }
        const double jump = 2 * k * 0.001;
        if (blend > 0)
            EXPECT_LT(largest, 0.2 * jump);
        else
            EXPECT_GT(largest, 0.9 * jump);
        EXPECT_EQ(blended, blend > 0);
        // The jump is gone in the end.
        for (int i = 0; i < 200; ++i) before = tool.touch(frictionless(plate()), Vec3d{0, 0, -0.0008}).force;
        EXPECT_NEAR(before.z, -k * 0.0002, 1e-3);
        // Free at once.
        EXPECT_EQ(tool.touch(frictionless(plate()), Vec3d{0, 0, -0.002}), Wrench{});
    }
}

TEST(Step, AJumpOfTheFootPointLeavesForceAndTorqueAsTheyWereWithFrictionAndDamping)
{
    // A ball through the middle of a box, 3.5 cm deep, where the way out turns from up to down: 17.5 N, and the point where it
    // rubs is on its other side.
    const Smoothing smoothing = ball_of(0.005);
    ZoneOptions o = with(Averaging::Ball);
    o.smoothing = smoothing;
    o.damping = 2;
    Tool tool(stencil_points(smoothing), o);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Coulomb;
    const Vec3d motion{3e-5, 0, -1e-4};
    const double fade = 250 * 0.001, explained = 3 * k * norm(motion);
    Vec3d at{-0.01, 0, 0.034};
    Wrench before = tool.touch(solid, at);
    bool jumped = false;
    double largest = 0, rubbed = 0;
    for (int i = 0; i < 500; ++i) {
        at += motion;
        const Wrench w = tool.touch(solid, at);
        const double force = norm(w.force - before.force), torque = norm(w.torque - before.torque);
        if (!jumped && (tool.result.status & k_step_blended) != 0) {
            jumped = true;
            EXPECT_LT(force, 1.001 * explained);
            EXPECT_LT(torque, 0.002);
        }
        EXPECT_LT(force, explained + fade);
        EXPECT_LT(torque, 0.003);
        largest = std::max(largest, norm(w.force));
        rubbed = std::max(rubbed, norm(w.torque));
        before = w;
    }
    EXPECT_TRUE(jumped);
    EXPECT_GT(largest, 17);
    EXPECT_GT(rubbed, 0.02) << "it rubs";
    EXPECT_LT(before.force.z, -9) << "and in the end the way out is down";
}

TEST(Step, ATorqueThatJumpsWhereTheForceDoesNotIsBlended)
{
    // A seesaw in a plate: both ends pass to the other side at once.
    for (const double blend : {0.0, 0.01}) {
        ZoneOptions o = with(Averaging::Patch);
        o.blend_time = blend;
        Tool tool({{0.03, 0, 0}, {-0.03, 0, 0}}, o);
        const auto at = [](double angle, double x) { return Pose{rotation_about({0, 1, 0}, angle), {x, 0, 1e-6}}; };
        Wrench before = tool.touch(frictionless(plate()), at(-0.00205, 0));
        double largest = 0, force = 0;
        for (int i = 1; i <= 41; ++i) {
            const Wrench w = tool.touch(frictionless(plate()), at(-0.00205 + 1e-4 * i, 1e-5 * i));
            largest = std::max(largest, norm(w.torque - before.torque));
            force = std::max(force, norm(w.force));
            before = w;
        }
        EXPECT_LT(force, 0.01);
        if (blend > 0)
            EXPECT_LT(largest, 0.01);
        else
            EXPECT_GT(largest, 0.05);
    }
}

TEST(Step, ALightTouchTurnsNoFasterThanADeepOne)
{
    // A point under a plate's edge passes from the top to the side: a right angle, and less than stiffness times motion explains.
    for (const double depth : {0.0002, 0.0009}) {
        Tool tool({{0, 0, 0}}, with(Averaging::Patch));
        const auto touch = [&](double x) { return tool.touch(frictionless(plate()), Vec3d{x, 0, 0.001 - depth}).force; };
        Vec3d before = touch(0.04998 - depth);
        EXPECT_GT(before.z, 0.05);
        const Vec3d after = touch(0.05002 - depth);
        EXPECT_LT(angle_between(before, after), 1.01 * 4e-5 / 0.001);
        Vec3d f = after;
        for (int i = 0; i < 100; ++i) {
            before = f;
            f = touch(0.05002 - depth);
            EXPECT_LT(angle_between(before, f), 0.15);
        }
        EXPECT_GT(angle_between(f, {0, 0, 1}), 1.5) << "and in the end it has turned";
    }
}

TEST(Step, AnEdgeIsCrossedWithoutAJump)
{
    // A coarse ball: its edges turn by 8 to 18 degrees.
    const sqmap::test::Solid ball(mesh::sphere(0.05, 2));
    const mesh::Solid oracle(ball.mesh);
    Tool tool = Tool::point(exact);
    Vec3d ours_before{}, mesh_before{};
    double ours = 0, of_mesh = 0;
    for (int i = 0; i < 3000; ++i) {
        const double a = 1e-4 * i / 0.049;
        const Vec3d at = 0.0485 * normalized(Vec3d{std::cos(a), std::sin(a), 0.3 * std::sin(0.7 * a)});
        const mesh::ClosestPoint c = oracle.closest_boundary(at);
        ASSERT_TRUE(oracle.inside(at));
        const auto& t = ball.mesh.triangles[c.triangle];
        const Vec3d n = normalized(
            cross(ball.mesh.vertices[t[1]] - ball.mesh.vertices[t[0]], ball.mesh.vertices[t[2]] - ball.mesh.vertices[t[0]]));
        const Vec3d m = (k * c.distance) * n, f = tool.touch(frictionless(ball), at).force;
        if (i > 0) ours = std::max(ours, norm(f - ours_before)), of_mesh = std::max(of_mesh, norm(m - mesh_before));
        ours_before = f, mesh_before = m;
        EXPECT_NEAR(norm(f), k * c.distance, k * 2.1e-4);
    }
    EXPECT_GT(of_mesh, 0.05);
    EXPECT_LT(ours, 0.1 * of_mesh);
}

}  // namespace
}  // namespace sqmap::haptic::test
