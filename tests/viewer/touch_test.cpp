// Touch through the servo. Waits for what happens, bounded; asserts no time.
#include "touch.h"

#include "sqmap/mesh/shapes.h"

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
        Judgement j;
        j.accepted = j.solid = true;
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
    // As deep as tool and object overlap: the tool is a true ball, the object a polyhedron whose facets lie up to 0.03 mm below.
    EXPECT_NEAR(f.depth, 0.05 + settings.tool_radius - f.tool.z, 4e-5);
    EXPECT_NEAR(norm(f.point - Vec3d{0, 0, 0.05}), 0, 4e-4) << "on the surface, below the ball";
    // At rest the hand's spring, 400 N/m, holds what the surface gives, less what the device's own friction bears, 0.05 N.
    const double hand = 400 * (f.tool.z - (0.05 + settings.tool_radius - 0.003));
    EXPECT_NEAR(norm(f.force), hand, 0.12);
    touch.stop();
    const TouchFrame stopped = wait_for(touch, [](const TouchFrame& x) { return x.faults != 0; });
    EXPECT_EQ(norm(stopped.force), 0);
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
    float most = 0;
    for (int i = 0; i < 60; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        TouchFrame f;
        (void)touch.frame(f);
        for (const TickPoint& t : f.ticks) most = std::max(most, t.force);
    }
    EXPECT_GT(most, 0.4f);
    EXPECT_LE(most, 0.5f * (1 + 1e-6f));
}

}  // namespace
}  // namespace sqmap::viewer
