// Touch through the servo. Waits for what happens, bounded; asserts no time.
#include "viewer/server/touch/touch.h"

#include "sqmap/mesh/shapes.h"
#include "viewer/server/scene/load.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

namespace sqmap::viewer {
namespace {

/// A ball of 0.1 m across about the origin.
const ObjectPtr& ball()
{
    static const ObjectPtr object = [] {
        AdmittedMesh j;
        j.admission = mesh::Admission::Accept;
        j.solid = true;
        j.mesh = mesh::sphere(1, 4);
        return object_from_mesh(j, "ball.obj", 0.1, {});
    }();
    return object;
}

/// Frames until done says so, or ten seconds.
template <class Done>
TouchFrame wait_for(Touch& touch, Done done)
{
    TouchFrame frame;
    for (int i = 0; i < 1000; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        if (touch.frame(frame) && done(frame)) break;
    }
    return frame;
}

TEST(Touch, APressedBallPushesBackAlongItsNormal)
{
    const Settings settings{.friction = 0};
    Touch touch({ball()}, settings, nullptr, {0, 0, 0.08});
    (void)wait_for(touch, [](const TouchFrame& f) { return f.engaged; });
    touch.aim({0, 0, 0.05 + settings.tool_radius - 0.003});
    double before = -1;
    int still = 0;  // frames on end: one that stands still may be about to turn
    const TouchFrame f = wait_for(touch, [&](const TouchFrame& x) {
        still = x.contacts > 0 && norm(x.force) > 0.3 && std::abs(x.tool.z - before) < 1e-6 ? still + 1 : 0;
        before = x.tool.z;
        return still >= 20;
    });
    ASSERT_GT(f.contacts, 0u);
    EXPECT_EQ(f.object, 0);
    EXPECT_GE(f.part, 0);
    EXPECT_GT(f.normal.z, 0.99);
    EXPECT_GT(f.force.z, 0.99 * norm(f.force));
    // As deep as the hand is below where a ball lies: the object is a polyhedron whose facets are up to 0.03 mm below the sphere.
    EXPECT_NEAR(f.depth, 0.05 + settings.tool_radius - f.hand.z, 4e-5);
    EXPECT_NEAR(norm(f.force), settings.stiffness * f.depth, 0.01);
    EXPECT_NEAR(f.tool.z, 0.05 + settings.tool_radius - 0.0012, 4e-5) << "drawn on the surface, as deep as it rests";
    EXPECT_NEAR(norm(f.point - Vec3d{0, 0, 0.05}), 0, 4e-4) << "on the surface, below the ball";
    // At rest the hand's spring, 400 N/m, holds what the surface gives.
    const double hand = 400 * (f.hand.z - (0.05 + settings.tool_radius - 0.003));
    EXPECT_NEAR(norm(f.force), hand, 0.02);
    touch.stop();
    const TouchFrame stopped = wait_for(touch, [](const TouchFrame& x) { return x.faults != 0; });
    EXPECT_EQ(norm(stopped.force), 0);
}

TEST(Touch, WhatWasRecordedIsComputedAgainToTheBit)
{
    Settings settings;
    std::shared_ptr<Take> take;
    // A busy machine may keep the recorder from hearing of every tick: such a take cannot be computed again.
    for (int attempt = 0; attempt < 5 && (!take || take->lost > 0); ++attempt) {
        settings = {.friction = 0.4, .texture = 0.0002};
        take = std::make_shared<Take>();
        Touch touch({ball()}, settings, nullptr, {0, 0, 0.08}, take);
        (void)wait_for(touch, [](const TouchFrame& f) { return f.engaged; });
        touch.aim({0.004, 0, 0.05 + settings.tool_radius - 0.003});
        (void)wait_for(touch, [](const TouchFrame& f) { return norm(f.force) > 0.3; });
        settings.stiffness = 250;  // while it touches
        ASSERT_TRUE(touch.adjust(settings));
        touch.aim({-0.01, 0.005, 0.05 + settings.tool_radius - 0.003});
        const std::size_t then = take->ticks.size();
        (void)wait_for(touch, [&](const TouchFrame&) { return take->ticks.size() > then + 300; });
    }
    ASSERT_GT(take->ticks.size(), 300u);
    if (take->lost > 0) GTEST_SKIP() << "the machine was too busy to hear of every tick, five times";
    const Again again = compute_again({take}, std::nullopt);
    EXPECT_EQ(again.ticks.size(), take->ticks.size());
    EXPECT_EQ(again.different, 0u);
    EXPECT_EQ(again.largest_force, 0);
    // Twice, one after the other: each take begins with an empty memory.
    EXPECT_EQ(compute_again({take, take}, std::nullopt).different, 0u);

    // Without the object there is no force: the difference is what was felt.
    double max = 0;
    for (const Take::Tick& t : take->ticks) max = std::max(max, norm(t.commanded.force));
    EXPECT_GT(max, 0.3);
    const Again away = compute_again({take}, Other{{}, settings});
    EXPECT_EQ(away.largest_force, max);
    EXPECT_GT(away.different, 0u);
    // At one depth the spring's stiffness is in proportion to the force: 250 to 500 at the end, without friction.
    Settings soft = settings, hard = settings;
    soft.friction = hard.friction = soft.texture = hard.texture = soft.damping = hard.damping = 0;
    hard.stiffness = 2 * soft.stiffness;
    const Again one = compute_again({take}, Other{{ball()}, soft}), two = compute_again({take}, Other{{ball()}, hard});
    ASSERT_GT(one.ticks.back().force, 0.1f);
    EXPECT_NEAR(two.ticks.back().force / one.ticks.back().force, 2, 1e-3);
    EXPECT_EQ(two.ticks.back().depth, one.ticks.back().depth);

    // The comparison finds the one difference: one bit of one tick.
    auto wrong = std::make_shared<Take>(*take);
    Vec3d& force = wrong->ticks[wrong->ticks.size() / 2].commanded.force;
    force.x = std::nextafter(force.x, 1e9);
    EXPECT_EQ(compute_again({wrong}, std::nullopt).different, 1u);
}

TEST(Touch, NothingIsFeltAway)
{
    Touch touch({ball()}, {}, nullptr, {0, 0, 0.2});
    const TouchFrame f = wait_for(touch, [](const TouchFrame& x) { return x.engaged; });
    EXPECT_EQ(f.contacts, 0u);
    EXPECT_EQ(f.object, -1);
    EXPECT_EQ(norm(f.force), 0);
}

TEST(Touch, SettingsOfTheToolNeedAnotherTouch)
{
    Settings settings;
    Touch touch({ball()}, settings, nullptr, {0, 0, 0.2});
    settings.stiffness = 900;
    settings.friction = 0.5;
    EXPECT_TRUE(touch.adjust(settings));
    settings.tool_radius = 0.01;
    EXPECT_FALSE(touch.adjust(settings));
}

TEST(Touch, TheForceNeverPassesTheLimit)
{
    Touch touch({ball()}, {.stiffness = 2000, .force_limit = 0.5}, nullptr, {0, 0, 0.08});
    (void)wait_for(touch, [](const TouchFrame& f) { return f.engaged; });
    touch.aim({0, 0, 0.03});
    float max = 0;
    for (int i = 0; i < 60; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        TouchFrame f;
        (void)touch.frame(f);
        for (const TickPoint& t : f.ticks) max = std::max(max, t.force);
    }
    EXPECT_GT(max, 0.4f);
    EXPECT_LE(max, 0.5f * (1 + 1e-6f));
}

}  // namespace
}  // namespace sqmap::viewer
