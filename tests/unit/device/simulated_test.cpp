// The simulated mechanism and hand against closed forms.
#include "sqmap/device/simulated.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

namespace sqmap::device {
namespace {

constexpr double k_tick = 1e-3;

/// No friction, no encoder, no delay, motors without limits.
Mechanism plain()
{
    return {.mass = 0.05,
            .damping = 0,
            .coulomb_friction = 0,
            .turn_damping = 0,
            .resolution = 0,
            .delay_ticks = 0,
            .max_force = 100,
            .max_torque = 100};
}

void run(HeldTool& tool, double seconds, const Wrench& wrench, const HandTarget& target = {})
{
    for (int i = 0; i < std::lround(seconds / k_tick); ++i) tool.step(&wrench, target, k_tick);
}

TEST(HeldTool, ComesToRestWhereTheHandsSpringBalancesTheForce)
{
    for (const HandProfile& hand : k_hand_profiles) {
        HeldTool tool(plain(), hand);
        run(tool, 5, {{0.3, 0, -0.1}, {0, 0.001, 0}});
        EXPECT_NEAR(tool.pose().translation.x, 0.3 / hand.stiffness, 1e-6) << hand.name;
        EXPECT_NEAR(tool.pose().translation.z, -0.1 / hand.stiffness, 1e-6) << hand.name;
        EXPECT_NEAR(tool.pose().rotation.row[0].z, std::sin(0.001 / hand.turn_stiffness), 1e-6) << hand.name;
    }
}

TEST(HeldTool, FallsLikeAMassInAFluid)
{
    Mechanism m = plain();
    m.damping = 0.5;
    HeldTool tool(m, {});  // nobody holds it
    const double f = 0.2, tau = m.mass / m.damping;
    double worst = 0;
    const Wrench w{{f, 0, 0}, {}};
    for (int i = 1; i <= 300; ++i) {
        tool.step(&w, {}, k_tick);
        const double t = i * k_tick, v = f / m.damping * (1 - std::exp(-t / tau));
        worst = std::max(worst, std::fabs(tool.twist().linear.x - v));
    }
    EXPECT_LT(worst, 1e-3 * f / m.damping);
    const double kinetic = 0.5 * m.mass * norm_sq(tool.twist().linear);
    EXPECT_NEAR(tool.work(), kinetic + tool.dissipated(), 2e-3 * tool.work());
}

TEST(HeldTool, SwingsAtItsNaturalFrequency)
{
    HeldTool tool(plain(), {.mass = 0.05, .damping = 0, .stiffness = 400});
    tool.reset({{}, {0.01, 0, 0}});
    double first = 0, last = 0;
    int crossings = 0;
    double before = 0.01;
    for (int i = 1; i <= 2000; ++i) {
        tool.step(nullptr, {}, k_tick);
        const double x = tool.pose().translation.x;
        if (before > 0 && x <= 0) {
            const double t = (i - x / (x - before)) * k_tick;
            if (crossings++ == 0) first = t;
            last = t;
        }
        before = x;
    }
    EXPECT_NEAR((last - first) / (crossings - 1), 2 * 3.14159265358979 * std::sqrt(0.1 / 400), 1e-5);
}

TEST(HeldTool, SticksBelowCoulombFrictionAndSlidesAbove)
{
    Mechanism m = plain();
    m.coulomb_friction = 0.1;
    HeldTool tool(m, {.inertia = 1});
    run(tool, 1, {{0.099, 0, 0}, {}});
    EXPECT_EQ(tool.pose().translation.x, 0);
    run(tool, 1, {{0.2, 0, 0}, {}});
    EXPECT_NEAR(tool.twist().linear.x, (0.2 - 0.1) / m.mass, 0.01);
}

TEST(HeldTool, TheEncoderRoundsToItsSteps)
{
    Mechanism m = plain();
    m.resolution = 40e-6;
    HeldTool tool(m, k_hand_profiles[0]);
    for (int i = 0; i < 300; ++i) {
        const Wrench w{{0.01 * i, 0.003 * i, 0}, {}};
        tool.step(&w, {}, k_tick);
        for (int k = 0; k < 3; ++k) {
            const double steps = tool.measured().translation[k] / 40e-6;
            EXPECT_NEAR(steps, std::round(steps), 1e-9);
            EXPECT_LE(std::fabs(tool.measured().translation[k] - tool.pose().translation[k]), 20e-6 + 1e-12);
        }
    }
}

TEST(HeldTool, AWrenchIsExertedAfterTheDelayAndSaturated)
{
    for (const int delay : {0, 1, 3}) {
        Mechanism m = plain();
        m.delay_ticks = delay;
        m.max_force = 2;
        HeldTool tool(m, k_hand_profiles[4]);
        const Wrench push{{3, 4, 0}, {}}, none{};
        tool.step(&push, {}, k_tick);
        for (int i = 0; i < 6; ++i) {
            EXPECT_NEAR(norm(tool.exerted().force), i == delay ? 2 : 0, 1e-12) << delay << " after " << i;
            tool.step(&none, {}, k_tick);
        }
    }
}

TEST(HeldTool, LetsGoTwentyMillisecondsAfterTheLastWrench)
{
    Mechanism m = plain();
    m.delay_ticks = 2;
    HeldTool tool(m, k_hand_profiles[4]);
    run(tool, 0.05, {{1, 0, 0}, {}});
    for (int i = 1; i <= 40; ++i) {
        tool.step(nullptr, {}, k_tick);
        EXPECT_EQ(tool.exerted().force.x, i < 20 ? 1 : 0) << i;
    }
    run(tool, 0.01, {{1, 0, 0}, {}});
    EXPECT_EQ(tool.exerted().force.x, 1);
    tool.zero();
    tool.step(nullptr, {}, k_tick);
    EXPECT_EQ(tool.exerted(), Wrench{});
}

TEST(HeldTool, TheSameStepsGiveTheSameBits)
{
    HeldTool a({}, k_hand_profiles[1]), b({}, k_hand_profiles[1]);
    for (int i = 0; i < 2000; ++i) {
        const Wrench w{{std::sin(0.01 * i), 0.2, 0}, {0, 0.001 * std::cos(0.02 * i), 0}};
        const HandTarget t{{{}, {0.01 * std::sin(0.003 * i), 0, 0}}, {}};
        a.step(&w, t, k_tick);
        b.step(&w, t, k_tick);
        ASSERT_EQ(std::memcmp(&a.pose(), &b.pose(), sizeof(Pose)), 0);
    }
}

TEST(SimulatedDevice, SaysThatItIsOneAndKnowsItsNumbers)
{
    SimulatedDevice device({.zones = 6});
    const Capabilities& c = device.capabilities();
    EXPECT_TRUE(c.simulated);
    EXPECT_EQ(c.zones, 6u);
    EXPECT_EQ(c.damping, Mechanism{}.damping);
    EXPECT_EQ(c.delay, 1e-3);
    EXPECT_THROW(SimulatedDevice({.zones = 0}), std::invalid_argument);
    EXPECT_THROW(SimulatedDevice({.zones = 17}), std::invalid_argument);
}

TEST(SimulatedDevice, AStepOfItsOwnPassesAtEveryReadWhateverTheClock)
{
    const HandScript moves = [](const void*, double time, std::size_t) noexcept {
        return HandTarget{{{}, {0.1 * std::sin(time), 0, 0}}, {}};
    };
    for (const double step : {k_tick, 3 * k_tick}) {
        SimulatedDevice one({.script = moves, .step = step}), other({.script = moves, .step = step});
        Sample a, b, before;
        ASSERT_TRUE(one.read(before));
        for (int i = 1; i < 500; ++i) {
            ASSERT_TRUE(one.read(a));
            EXPECT_NEAR(a.time - before.time, step, 1e-9);
            EXPECT_EQ(a.sequence, before.sequence + 1);
            before = a;
        }
        for (int i = 0; i < 500; ++i) ASSERT_TRUE(other.read(b));
        EXPECT_EQ(a.poses[0].translation.x, b.poses[0].translation.x);
        EXPECT_GT(a.poses[0].translation.x, 0.01);
    }
}

TEST(SimulatedDevice, GoesWhenItIsUnpluggedAndRepeatsItselfWhenFrozen)
{
    SimulatedDevice device;
    Sample a, b;
    ASSERT_TRUE(device.read(a));
    device.freeze(true);
    b = a;
    ASSERT_TRUE(device.read(b));
    EXPECT_EQ(a.sequence, b.sequence);
    device.freeze(false);
    ASSERT_TRUE(device.read(b));
    EXPECT_EQ(b.sequence, a.sequence + 1);
    device.unplug();
    const Sample before = b;
    EXPECT_FALSE(device.read(b));
    EXPECT_EQ(b.sequence, before.sequence);
    EXPECT_FALSE(device.write({}));
}

}  // namespace
}  // namespace sqmap::device
