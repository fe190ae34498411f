// The steps of the safety filter that bound energy and heat: passivity (7), duty (8), and the last clamp, of what they add.
// safety_mutants.cmake builds these tests against filters that lack one step each, and expects the tests of that step to fail.
#include "bench.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::haptic {
namespace {

// ---- Step 7

/// A swing of the hand, +-1 cm at 2 Hz, and an algorithm that pushes it along: a motor. Returns the work done on the hand.
double driven_energy(Bench& bench, double strength, bool turning)
{
    double work = 0;
    double last = 0;
    for (int i = 0; i < 4000; ++i) {
        const double phase = 2 * 3.14159265358979 * 2 * i * k_tick, position = 0.01 * std::sin(phase), speed = std::cos(phase);
        const Wrench before = bench.safe[0];
        if (turning) {
            const double angle = 20 * position;
            bench.poses[0].rotation = {
                {{std::cos(angle), -std::sin(angle), 0}, {std::sin(angle), std::cos(angle), 0}, {0, 0, 1}}};
            work += before.torque.z * 20 * (position - last);
            bench.commanded[0].torque = {0, 0, 0.05 * strength * speed};
        } else {
            bench.poses[0].translation.x = position;
            work += before.force.x * (position - last);
            bench.commanded[0].force = {strength * speed, 0, 0};
        }
        last = position;
        bench.tick();
    }
    return work;
}

TEST(SafetyPassivity, AnAlgorithmThatGivesEnergyIsHeldNearTheMargin)
{
    for (const bool turning : {false, true}) {
        DeviceLimits device = strong();
        device.damping = 0;
        Bench bench(device);
        bench.engage();
        // Unfiltered it would give some 8 swings x 2 x 2 cm x 0.8 N = 0.25 J. The margin twice, and what is forgiven.
        EXPECT_LT(driven_energy(bench, 1, turning), 2e-3 + 1e-3);
        EXPECT_GT(bench.filter.counters().passivity, 0u);
        EXPECT_LT(bench.filter.energy(0), 3e-3);
    }
}

TEST(SafetyPassivity, AMotorThatLetsGoBetweenItsPushesIsHeldNearTheMarginToo)
{
    DeviceLimits device = strong();
    device.damping = 0;
    Bench bench(device);
    bench.engage();
    double work = 0, last = 0;
    for (int i = 0; i < 8000; ++i) {  // a circle of 1 cm, four times a second; pushed along for half of it
        const double phase = 2 * 3.14159265358979 * 4 * i * k_tick, position = 0.01 * std::sin(phase);
        bench.poses[0].translation = {position, 0.01 * std::cos(phase), 0};
        work += bench.force().x * (position - last);
        last = position;
        bench.commanded[0].force = {std::max(0., std::cos(phase)), 0, 0};
        bench.tick();
    }
    // Unfiltered it would give 32 x 16 mJ; forgiven between the pushes, with a second for 1/e, 32 x 0.2 mJ.
    EXPECT_LT(work, 2e-3 + 5e-4);
}

TEST(SafetyPassivity, ASpringGivesBackWhatItTookAndNothingIsChanged)
{
    Bench bench;
    bench.engage();
    for (int i = 0; i < 4000; ++i) {
        const double phase = 2 * 3.14159265358979 * i * k_tick, depth = 0.005 * (1 - std::cos(phase));
        bench.poses[0].translation.z = -depth;
        bench.commanded[0].force = {0, 0, 150 * depth};
        bench.tick();
        EXPECT_EQ(bench.force().z, bench.commanded[0].force.z) << i;
    }
    EXPECT_EQ(bench.filter.counters().passivity, 0u);
}

TEST(SafetyPassivity, WhatFrictionHasTakenDoesNotPayForAMotor)
{
    // A second of rubbing against 1 N takes 0.1 J; then the same 1 N pushes along. Springs of 500 N/m hold 1 mJ of it.
    DeviceLimits device = strong();
    device.damping = 0;
    Bench bench(device, {.softest = 500});
    bench.engage();
    double work = 0;
    for (int i = 0; i < 2000; ++i) {
        const double step = i < 1000 ? -1e-4 : 1e-4;
        work += i < 1000 ? 0 : bench.force().x * step;
        bench.poses[0].translation.x += step;
        bench.commanded[0].force = {1, 0, 0};
        bench.tick();
    }
    EXPECT_LT(work, 1.25e-3 + 2e-3 + 2e-4);
}

TEST(SafetyPassivity, ASpringPressedBeyondTheLimitGivesBackWhatItTook)
{
    Bench bench(strong(), {.softest = 500});
    bench.engage();
    for (int i = 0; i < 2000; ++i) {
        const double phase = 2 * 3.14159265358979 * i * k_tick,
                     depth = 0.005 * (1 - std::cos(phase));  // to 1 cm: 5 N are commanded
        bench.poses[0].translation.z = -depth;
        bench.commanded[0].force = {0, 0, 500 * depth};
        bench.tick();
        EXPECT_NEAR(bench.force().z, std::min(500 * depth, 2.), 1e-12) << i;
    }
    EXPECT_EQ(bench.filter.counters().passivity, 0u);
}

TEST(SafetyPassivity, WhatSpringsHoldThatCancelIsNotForgotten)
{
    // 2 cm into a wall of 500 N/m and into the middle between it and its back, where next to nothing is commanded; and out again.
    for (const bool reported : {false, true}) {
        Bench bench(strong(), {.softest = 500});
        bench.engage();
        std::vector<double> push(1);
        if (reported) bench.input.pushes = push;
        double least = 1;
        for (int i = 0; i < 1200; ++i) {
            const double phase = std::clamp((i - 100) / 1000., 0., 1.),
                         depth = 0.01 * (1 - std::cos(2 * 3.14159265358979 * phase));
            bench.poses[0].translation.z = -depth;
            push[0] = 500 * depth;
            const double commanded = i > 580 && i < 620 ? 0.1 : push[0];
            bench.commanded[0].force = {0, 0, commanded};
            bench.tick();
            if (i > 640) least = std::min(least, commanded > 0 ? bench.force().z / std::min(commanded, 2.) : 1);
        }
        if (reported)
            EXPECT_GT(least, 1 - 1e-12);
        else
            EXPECT_LT(least, 0.1);
    }
}

TEST(SafetyPassivity, ReportedSpringsAreNoCreditForAMotor)
{
    DeviceLimits device = strong();
    device.damping = 0;
    Bench bench(device);
    bench.engage();
    const std::vector<double> push{1e6};
    bench.input.pushes = push;
    EXPECT_LT(driven_energy(bench, 1, false), 2e-3 + 1e-3);
}

TEST(SafetyPassivity, MotionAboveTheTopSpeedIsCountedToo)
{
    // A device of 100 Hz: in by 11 mm within a sample, which is 1.1 m/s, and out again, with 2 N whenever it is in.
    DeviceLimits device = strong();
    device.period = device.sample_period = 0.01;
    device.damping = 0;
    Bench bench(device);
    for (int i = 0; i < 100; ++i) bench.tick(true, 0.01);
    double work = 0, largest = 0, before = 0;
    for (int i = 0; i < 1200; ++i) {
        const double position = i % 20 < 10 ? 0. : -0.011;
        work += bench.force().z * (position - before);
        largest = std::max(largest, work);
        before = position;
        bench.poses[0].translation.z = position;
        bench.commanded[0].force = {0, 0, position < 0 ? 5. : 0.};
        bench.tick(true, 0.01);
    }
    // One sample of a held force, and the valve: without it 60 x 22 mJ.
    EXPECT_LT(largest, 2 * 0.011 + 3e-3);
}

TEST(SafetyPassivity, AGlitchOwesNothing)
{
    Bench bench;
    bench.engage_and_push({0, 0, 0.4});
    bench.poses[0].translation.z -= 0.04;
    bench.commanded[0].force.z = 2;
    bench.tick();
    bench.poses[0].translation.z += 0.04;
    bench.commanded[0].force.z = 0.4;
    bench.tick();
    for (int i = 0; i < 40; ++i) bench.tick();
    EXPECT_EQ(bench.force().z, 0.4);
}

TEST(SafetyPassivity, TheDelayOfTheDeviceIsCounted)
{
    // A spring seen 3 ticks late gives K v delay per metre; the observer must see that, not the energy of the undelayed spring.
    for (const double delay : {0., 3e-3}) {
        DeviceLimits device = strong();
        device.damping = 0;
        device.delay = delay;
        Bench bench(device, {.energy_margin = 0.01});
        bench.engage();
        double work = 0, largest = 0;
        std::vector<double> positions, forces;
        for (int i = 0; i < 245; ++i) {  // one contact
            const double phase = 2 * 3.14159265358979 * 4 * i * k_tick, depth = 0.002 * (1 - std::cos(phase));
            positions.push_back(-depth);
            bench.poses[0].translation.z = -depth;
            bench.commanded[0].force = {0, 0, 300 * depth};
            bench.tick();
            forces.push_back(bench.force().z);
            const int then = i - 1 - static_cast<int>(std::lround(delay / k_tick));
            if (i > 0 && then >= 0) work += forces[then] * (positions[i] - positions[i - 1]);
            largest = std::max(largest, std::fabs(bench.filter.energy(0) - work));
            if (bench.filter.counters().passivity > 0) break;
        }
        EXPECT_LT(largest, 1e-9) << delay;
    }
}

TEST(SafetyPassivity, ComesAfterTheSlewSoThatDampingIsAtOnce)
{
    DeviceLimits device = strong();
    device.damping = 5;
    Bench bench(device, {.softest = 1e6});
    bench.engage();
    // Turns along a torque, which gives energy, until the valve is nearly shut; then a jerk: in one tick from next to nothing to
    // braking.
    double angle = 0, before = 0;
    for (int i = 0; i < 61; ++i) {
        before = bench.force().x;
        if (i < 60)
            angle += 0.01;
        else
            bench.poses[0].translation.x += 0.9e-3;
        bench.poses[0].rotation = {{{std::cos(angle), -std::sin(angle), 0}, {std::sin(angle), std::cos(angle), 0}, {0, 0, 1}}};
        bench.commanded[0] = {{0.1, 0, 0}, {0, 0, 0.1}};
        bench.tick();
    }
    EXPECT_GE(before, 0);
    EXPECT_LT(bench.force().x, -0.4) << "not grown from zero by a quarter newton a tick";
}

// ---- Step 8

TEST(SafetyDuty, TheMeanSquareOverTenSecondsStaysBelowTheContinuousForce)
{
    DeviceLimits device = strong();
    device.continuous_force = 1;
    Bench bench(device);
    bench.engage();
    std::vector<double> squares;
    double sum = 0, worst = 0, lowest = 2;
    for (int i = 0; i < 40000; ++i) {
        bench.commanded[0].force = {i < 500 || i % 7000 < 6000 ? 2. : 0., 0, 0};
        bench.tick();
        squares.push_back(norm_sq(bench.force()));
        sum += squares.back();
        if (i >= 10000) sum -= squares[i - 10000];
        worst = std::max(worst, std::sqrt(sum / 10000));
        if (i > 20000 && i % 7000 > 20 && i % 7000 < 6000) lowest = std::min(lowest, bench.force().x);
    }
    EXPECT_LE(worst, 1.0);
    EXPECT_GT(worst, 0.9) << "what may be used is used";
    EXPECT_GT(lowest, 0.89) << "and never falls far below it";
    EXPECT_GT(bench.filter.counters().duty, 0u);
}

TEST(SafetyDuty, WhatIsHeldAboveTheContinuousForceFallsSmoothlyToItAndNotToNothing)
{
    for (const double continuous : {1.6, 1.0, 0.5}) {
        DeviceLimits device = strong();
        device.continuous_force = continuous;
        Bench bench(device);
        bench.engage_and_push({2, 0, 0});
        EXPECT_GT(bench.force().x, continuous) << "a touch may be stronger";
        std::vector<double> squares;
        double sum = 0, worst = 0, before = bench.force().x, fall = 0;
        double lowest = 2, highest = 0;
        bool reported = true;
        for (int i = 0; i < 90000; ++i) {
            bench.tick();
            const double f = bench.force().x;
            lowest = std::min(lowest, f);
            if (i > 10000) {
                highest = std::max(highest, f);
                reported = reported && (bench.report.acted & k_acted_duty) != 0;
            }
            fall = std::max(fall, before - f);
            before = f;
            squares.push_back(f * f);
            sum += squares.back();
            if (i >= 10000) sum -= squares[static_cast<std::size_t>(i) - 10000];
            worst = std::max(worst, std::sqrt(sum / 10000));
        }
        EXPECT_GE(lowest, 0.82 * continuous);
        EXPECT_LE(highest, continuous);
        EXPECT_TRUE(reported);
        EXPECT_LE(worst, continuous);
        EXPECT_LT(fall, 0.02 * 2) << "no step";
        EXPECT_GT(bench.force().x, 0.9 * continuous) << "it rises again to what can be held";
        // Let go, and the budget is back.
        bench.run(60, {});
        bench.run(0.05, {2, 0, 0});
        EXPECT_GT(bench.force().x, continuous);
    }
}

TEST(SafetyDuty, ATenthBelowTheContinuousForceMayBeHeldForEver)
{
    DeviceLimits device = strong();
    device.continuous_force = 1;
    Bench bench(device);
    bench.engage_and_push({0.89, 0, 0});
    for (int i = 0; i < 30000; ++i) {
        bench.tick();
        EXPECT_EQ(bench.force().x, 0.89);
    }
}

TEST(SafetyDuty, AnUnknownContinuousForceIsHalfTheLimit)
{
    DeviceLimits device = strong();
    device.continuous_force = 0;
    Bench bench(device);
    bench.engage_and_push({2, 0, 0});
    double sum = 0;
    for (int i = 0; i < 10000; ++i) {
        bench.tick();
        sum += norm_sq(bench.force());
    }
    EXPECT_LE(std::sqrt(sum / 10000), 1.0 + 1e-6);
}

// ---- The final clamp

TEST(SafetyLast, WhatTheDampersAddNeverExceedsTheLimit)
{
    DeviceLimits device = strong();
    device.damping = 4;
    Bench bench(device, {.force_limit = 0.3, .energy_margin = 0.01, .softest = 1e6});
    bench.engage();
    // Turns along a torque, which gives energy; then is torn away, and the damper asks for 2 N s/m times 0.9 m/s.
    double largest = 0, angle = 0;
    for (int i = 0; i < 60; ++i) {
        if (i < 40)
            angle += 0.01;
        else
            bench.poses[0].translation.x -= 0.9e-3;
        bench.poses[0].rotation = {{{std::cos(angle), -std::sin(angle), 0}, {std::sin(angle), std::cos(angle), 0}, {0, 0, 1}}};
        bench.commanded[0] = {{0.1, 0, 0}, {0, 0, 0.1}};
        bench.tick();
        largest = std::max(largest, norm(bench.force()));
    }
    EXPECT_LE(largest, 0.3 + 1e-12);
    EXPECT_GT(bench.filter.counters().passivity, 0u);
    EXPECT_GT(bench.filter.counters().last_clamped, 0u);
}

}  // namespace
}  // namespace sqmap::haptic
