#include "sqmap/haptic/step.h"

#include "haptic/rigid_motion.h"
#include "haptic/stencil.h"
#include "touching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

namespace sqmap::haptic::test {
namespace {

TEST(Step, ATeleportForgetsWhatWasTouchedBefore)
{
    for (const Mode mode : {Mode::Direct, Mode::Proxy, Mode::Coupled}) {
        ZoneOptions o = with(Averaging::Patch);
        o.mode = mode;
        Tool tool(square(8), o), fresh(square(8), o);
        TouchedBody solid = frictionless(box());
        solid.material.friction = Friction::Coulomb;
        for (int i = 0; i < 60; ++i) (void)tool.touch(solid, Vec3d{1e-4 * i, 0, 0.031 - 5e-5 * i});
        EXPECT_GT(std::fabs(tool.touch(solid, Vec3d{0.006, 0, 0.028}).force.x), 0.05) << "it rubs";
        EXPECT_EQ(tool.touch(solid, Vec3d{0.006, 0, 0.2}).force.z, 0);
        EXPECT_TRUE(tool.result.status & k_step_teleport);
        const Wrench back = tool.touch(solid, Vec3d{0.006, 0, 0.0295}), first = fresh.touch(solid, Vec3d{0.006, 0, 0.0295});
        EXPECT_TRUE(tool.result.status & k_step_teleport);
        EXPECT_EQ(back, first) << "as though it had never been there";
    }
}

TEST(Step, ALateTickIsAnsweredFromThePlanesOfTheLastOne)
{
    for (const Averaging averaging : {Averaging::Stencil, Averaging::Patch}) {
        Tool tool(averaging == Averaging::Patch ? square(9) : stencil_points({}), with(averaging)),
            sure(averaging == Averaging::Patch ? square(9) : stencil_points({}), with(averaging));
        (void)tool.touch(frictionless(box()), Vec3d{0, 0, 0.029});
        (void)sure.touch(frictionless(box()), Vec3d{0, 0, 0.029});
        tool.input.degraded = true;
        for (const double z : {0.0289, 0.0288, 0.0292, 0.0297, 0.0299}) {
            const Wrench late = tool.touch(frictionless(box()), Vec3d{0.0001, 0, z});
            EXPECT_NE(tool.result.status & k_step_degraded, 0u);
            EXPECT_NEAR(tool.result.deepest, 0.03 - z, 1e-4);
            EXPECT_GT(tool.result.contacts, 0u);
            EXPECT_LT(norm(late.force - sure.touch(frictionless(box()), Vec3d{0.0001, 0, z}).force), 0.02) << z;
        }
        EXPECT_EQ(tool.touch(frictionless(box()), Vec3d{0, 0, 0.0301}), Wrench{});
        EXPECT_EQ(tool.state().degraded_steps(), 6u);
        // Nothing was ever touched: nothing is felt, deep though it be.
        tool.state().reset();
        EXPECT_EQ(tool.touch(frictionless(box()), Vec3d{0, 0, 0.02}), Wrench{});
    }
}

TEST(Step, ALateTickAtTheSamePoseGetsTheSameForce)
{
    for (const Averaging averaging : {Averaging::Stencil, Averaging::Ball})
        for (const Shading shading : {Shading::Levelled, Shading::Consistent}) {
            ZoneOptions o = with(averaging);
            o.shading = shading;
            Tool tool(stencil_points(o.smoothing), o);
            const Vec3d on_ridge{0.0002, 0, averaging == Averaging::Ball ? 0.001 : -0.001};
            const Wrench in_time = tool.touch(frictionless(roof(1)), on_ridge);
            tool.input.degraded = true;
            EXPECT_GT(norm(in_time.force), 0.1);
            EXPECT_LT(norm(tool.touch(frictionless(roof(1)), on_ridge).force - in_time.force), 1e-9);
        }
}

TEST(Step, WhatIsNotFiniteGivesNoForceAndHarmsNoOtherZone)
{
    const query::Probe probe(square(5));
    const Zone zones[2] = {{.probe = &probe, .options = exact}, {.probe = &probe, .options = exact}};
    State state(zones);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    TouchedBody solid = frictionless(box());
    Pose poses[2] = {shifted({0, 0, 0.029}), shifted({0, 0, 0.029})};
    Wrench w[2];
    (void)step(state, {.touched = std::span(&solid, 1), .poses = poses}, w);
    poses[1].translation.y = nan;
    const StepResult r = step(state, {.touched = std::span(&solid, 1), .poses = poses}, w);
    EXPECT_NE(r.status & k_step_not_finite, 0u);
    EXPECT_NEAR(w[0].force.z, k * 0.001, 1e-3);
    EXPECT_EQ(w[1], Wrench{});
    for (const double dt : {nan, 0., -1., std::numeric_limits<double>::infinity()}) {
        (void)step(state, {.touched = std::span(&solid, 1), .poses = poses, .dt = dt}, w);
        EXPECT_EQ(w[0], Wrench{});
    }
    poses[1].translation.y = 0;
    // A force whose components are finite and whose size is not.
    state.options(0).stiffness = 1e200;
    EXPECT_NE(step(state, {.touched = std::span(&solid, 1), .poses = poses}, w).status & k_step_not_finite, 0u);
    EXPECT_EQ(w[0], Wrench{});
    state.options(0).stiffness = k;
    solid.pose.rotation.row[1].x = nan;
    EXPECT_NE(step(state, {.touched = std::span(&solid, 1), .poses = poses}, w).status & k_step_not_finite, 0u);
    EXPECT_EQ(w[0], Wrench{});
    EXPECT_NE(step(state, {.touched = std::span(&solid, 1), .poses = poses}, std::span(w).first(1)).status & k_step_short_span,
              0u);
}

/// Work around closed ways of 3 mm about places of the hand's skin, by the trapezium rule; and what the force is worth.
struct Work {
    double around = 0, passed = 0;
};
template <class MakePose>
Work work_around(Tool& tool, const TouchedBody& solid, MakePose&& pose_at)
{
    Work work;
    constexpr int n = 1500;
    Wrench before{};
    Pose at{};
    for (int i = 0; i <= n; ++i) {
        const Pose next = pose_at(6.283185307179586 * (i % n) / n);
        const Wrench w = tool.touch(solid, next);
        if (i > 0) {
            const Twist moved = twist_between(at, next, 1);
            work.around +=
                dot(0.5 * (w.force + before.force), moved.linear) + dot(0.5 * (w.torque + before.torque), moved.angular);
            work.passed += norm(w.force) * norm(moved.linear) + norm(w.torque) * norm(moved.angular);
        }
        before = w, at = next;
    }
    return work;
}

TEST(Step, ConsistentForcesGiveNoEnergyAroundAClosedPath)
{
    ZoneOptions o = exact;
    o.shading = Shading::Consistent;
    o.blend_time = 0;
    Tool point = Tool::point(o);
    o.averaging = Averaging::Patch;
    Tool patch(mapped(mesh::sphere(0.008, 3), 1, {0.01, 0, 0}).vertices, o);
    sqmap::test::Random random(21);
    int touching = 0;
    for (int i = 0; i < 12; ++i) {
        const auto& t = hand().mesh.triangles[random.below(hand().mesh.triangles.size())];
        const Vec3d at = hand().mesh.vertices[t[0]], u = random.direction(), v = normalized(cross(u, random.direction()));
        point.state().reset();
        const Work a = work_around(point, frictionless(hand()),
                                   [&](double s) { return shifted(at + 0.003 * std::cos(s) * u + 0.003 * std::sin(s) * v); });
        EXPECT_LT(std::abs(a.around), 0.001 * a.passed + 1e-7);
        patch.state().reset();
        const Work b = work_around(patch, frictionless(hand()), [&](double s) {
            return Pose{rotation_about(u, 0.2 * std::sin(s)), at + 0.003 * std::cos(s) * u + 0.003 * std::sin(s) * v};
        });
        EXPECT_LT(std::abs(b.around), 0.001 * b.passed + 1e-7);
        touching += a.passed > 1e-4 && b.passed > 1e-4 ? 1 : 0;
    }
    EXPECT_GT(touching, 6);
}

TEST(Step, AConsistentForceIsTheSlopeOfItsPotential)
{
    ZoneOptions o = exact;
    o.shading = Shading::Consistent;
    o.blend_time = 0;
    for (const Averaging averaging : {Averaging::Stencil, Averaging::Patch}) {
        Tool tool(averaging == Averaging::Patch ? mesh::sphere(0.008, 3).vertices : stencil_points({}), with(averaging, o));
        for (const Vec3d at : {Vec3d{0.01, 0.02, 0.0295}, Vec3d{0.0455, 0.01, 0.0255}}) {  // flat, and on a rounded edge
            const auto potential = [&](Vec3d p) {
                tool.state().reset();
                (void)tool.touch(frictionless(box()), p);
                return tool.report().potential;
            };
            tool.state().reset();
            const Vec3d force = tool.touch(frictionless(box()), at).force;
            ASSERT_GT(norm(force), 0.05);
            Vec3d slope{};
            for (int axis = 0; axis < 3; ++axis) {
                Vec3d h{};
                h[axis] = 2e-5;
                slope[axis] = -(potential(at + h) - potential(at - h)) / 4e-5;
            }
            EXPECT_LT(norm(slope - force), 0.03 * norm(force));
        }
    }
}

TEST(Step, ReplaysToTheLastBit)
{
    const auto hash_of_run = [] {
        ZoneOptions o = exact;
        o.layer = query::Layer::Three;
        Tool tool(hand().mesh.vertices, o);
        Tool point = Tool::point(exact);
        TouchedBody solid = frictionless(box());
        solid.material.friction = Friction::Coulomb;
        std::uint64_t hash = 14695981039346656037ull;
        for (int i = 0; i < 10000; ++i) {
            const double a = 0.001 * i;
            tool.input.degraded = i % 17 == 0;
            const Pose pose{rotation_about({0, 0, 1}, 0.3 * a), {0.05 + 0.01 * std::sin(a), -0.05, 0.02 + 0.01 * std::cos(a)}};
            for (const Wrench& w : {tool.touch(solid, pose), point.touch(solid, Vec3d{0.01 * std::sin(a), 0, 0.029})})
                for (const Vec3d& v : {w.force, w.torque})
                    for (int k3 = 0; k3 < 3; ++k3) {
                        const double x = v[k3];
                        std::uint64_t bits = 0;
                        std::memcpy(&bits, &x, sizeof bits);
                        hash = (hash ^ bits) * 1099511628211ull;
                    }
        }
        return hash;
    };
    const std::uint64_t alone = hash_of_run();
    std::uint64_t together[3] = {};
    std::thread threads[3];
    for (int i = 0; i < 3; ++i) threads[i] = std::thread([&, i] { together[i] = hash_of_run(); });
    for (std::thread& t : threads) t.join();
    for (const std::uint64_t hash : together) EXPECT_EQ(hash, alone);
}

TEST(Step, ALateTickHasTheTextureToo)
{
    std::vector<float> values;
    const Texture texture = gaussian_texture({.amplitude = 0.0002}, values);
    for (const Mode mode : {Mode::Direct, Mode::Proxy})
        for (const bool patch : {false, true}) {
            ZoneOptions o = patch ? with(Averaging::Patch) : exact;
            o.mode = mode;
            o.averaging = patch ? Averaging::Patch : Averaging::Stencil;
            Tool late(patch ? square(4) : stencil_points(o.smoothing), o),
                other(patch ? square(4) : stencil_points(o.smoothing), o);
            TouchedBody rough = frictionless(box());
            rough.material.texture = &texture;
            double largest = 0, flat = 0;
            for (int i = 0; i < 400; ++i) {
                const Vec3d at{-0.02 + 1e-4 * i, 0, 0.029};
                late.input.degraded = i % 5 == 4;
                const double a = late.touch(rough, at).force.z, b = other.touch(rough, at).force.z;
                largest = std::max(largest, std::fabs(a - b));
                flat = std::max(flat, std::fabs(k * 0.001 - b));
            }
            EXPECT_GT(flat, patch ? 0.02 : 0.1) << "the relief is felt";
            EXPECT_LT(largest, 0.02) << int(mode) << patch;
        }
}

TEST(Step, TextureKeepsItsPositionAndIsNeverOutside)
{
    std::vector<float> values;
    const Texture texture = gaussian_texture({.amplitude = 0.0001}, values);
    Tool tool(square(3), exact);
    TouchedBody rough = frictionless(box()), smooth = rough;
    rough.material.texture = &texture;
    double least = 1e9, largest = 0;
    for (int i = 0; i < 200; ++i) {
        const Vec3d at{-0.01 + 1e-4 * i, 0, 0.029};
        tool.state().reset();
        const Wrench first = tool.touch(rough, at);
        tool.state().reset();
        EXPECT_EQ(tool.touch(rough, at), first);
        tool.state().reset();
        EXPECT_LE(first.force.z, tool.touch(smooth, at).force.z);
        least = std::min(least, first.force.z), largest = std::max(largest, first.force.z);
    }
    EXPECT_GT(largest - least, 0.02);
    EXPECT_EQ(tool.touch(rough, Vec3d{0, 0, 0.0301}), Wrench{});
}

}  // namespace
}  // namespace sqmap::haptic::test
