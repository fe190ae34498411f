// The steps of the safety filter that bound force: engaging (3), the clamp (4), the slew (5) and the top speed (6).
// safety_mutants.cmake builds these tests against filters that lack one step each, and expects the tests of that step to fail.
#include "bench.h"
#include "math/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::haptic {
namespace {

// ---- Step 3

TEST(SafetyEngage, WaitsForNextToNothingThenRampsForHalfASecond)
{
    Bench bench;
    bench.run(2, {1, 0, 0});
    EXPECT_TRUE(bench.silent()) << "started inside the object";
    bench.run(0.003, {0.1, 0, 0});
    EXPECT_TRUE(bench.silent()) << "three ticks are not more than three";
    bench.run(0.001, {0.1, 0, 0});
    double last = 0;
    for (int i = 1; i < 500; ++i) {
        bench.run(k_tick, {1, 0, 0});
        const double f = norm(bench.force());
        EXPECT_LE(f, (i + 1) / 500. + 1e-9);
        EXPECT_GE(f, last);
        last = f;
    }
    bench.run(0.01, {1, 0, 0});
    EXPECT_EQ(bench.force().x, 1);
    EXPECT_TRUE(bench.report.engaged);
}

TEST(SafetyEngage, ReportsWhichZonesAreInsideWhereForcesAreToBegin)
{
    Bench bench(strong(), {}, 3);
    EXPECT_EQ(bench.tick().waiting, 0u) << "nobody asks for anything";
    for (int i = 0; i < 700; ++i) {
        bench.commanded[1].force = {1, 0, 0};
        bench.commanded[2].torque = {0, 0.1, 0};
        bench.tick();
        ASSERT_EQ(bench.report.waiting, 0b110u) << i;
        ASSERT_NE(bench.report.acted & k_acted_inside, 0u);
    }
    EXPECT_FALSE(bench.report.engaged);
    bench.commanded[0].force = {1, 0, 0};
    bench.commanded[2] = {};
    bench.tick();
    EXPECT_EQ(bench.report.waiting, 0b010u) << "the first has been free, and has its force";
    EXPECT_GT(norm(bench.force(0)), 0.2);
    // Once out, it is told no more, however much it asks for.
    bench.run(0.01, {});
    EXPECT_EQ(bench.report.waiting, 0u);
    bench.run(1, {1, 0, 0});
    EXPECT_EQ(bench.report.waiting, 0u);
    EXPECT_EQ(bench.report.acted & k_acted_inside, 0u);
    EXPECT_EQ(bench.force(1).x, 1);
    // Off is off, and says so by itself.
    bench.input.stop = true;
    EXPECT_EQ(bench.tick().waiting, 0u);
}

TEST(SafetyEngage, ATeleportEngagesThatZoneAnew)
{
    for (const bool turn : {false, true}) {
        Bench bench(strong(), {}, 2);
        bench.engage_and_push({1, 0, 0});
        if (turn)
            bench.poses[1].rotation = {{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
        else
            bench.poses[1].translation.x += 0.06;
        bench.tick();
        EXPECT_EQ(bench.force(0).x, 1);
        EXPECT_EQ(bench.safe[1], Wrench{});
        bench.run(0.5, {1, 0, 0});
        EXPECT_EQ(bench.safe[1], Wrench{});
        EXPECT_EQ(bench.filter.counters().teleports, 1u);
        EXPECT_EQ(bench.report.faults, 0u);
        bench.run(0.01, {});
        bench.run(0.6, {1, 0, 0});
        EXPECT_EQ(bench.force(1).x, 1);
    }
}

TEST(SafetyEngage, ATouchWithinTheRampEndsAtFullForceWithoutLifting)
{
    // A hand of 40 N/m that pushes 1 N lies 25 mm deep until the ramp has made the wall: what that gives the hand, some 12 mJ, is
    // the filter's own doing and must not close the passivity step's valve.
    for (const double hand : {40., 200., 800.}) {
        Bench bench(strong(), {.softest = 500});
        double x = 0;  // depth; the hand moves to where it balances what is sent, at most 0.5 m/s
        for (int i = 0; i < 3000; ++i) {
            const double target = i < 20 ? -0.001 : 1 / hand + 1. / 500;
            x += std::clamp(0.05 * (target - bench.force().x / hand - x), -5e-4, 5e-4);
            bench.poses[0].translation.x = -x;
            bench.commanded[0].force.x = std::max(0., 500 * x);
            bench.tick();
        }
        EXPECT_NEAR(bench.force().x, 1, 0.02) << hand;
        EXPECT_EQ(bench.filter.counters().passivity, 0u) << hand;
        EXPECT_TRUE(bench.report.engaged);
    }
}

TEST(SafetyEngage, TheRampMayGiveFiftyMillijoulesAndThenThePassivityStepActs)
{
    // An algorithm that asks for force along the motion, whatever the place, from the ramp's first tick on.
    DeviceLimits device = strong();
    device.damping = 0;  // unknown: nothing is taken off
    Bench bench(device);
    double given = 0;
    bench.run(0.01, {});
    for (int i = 0; i < 490; ++i) {
        given += bench.force().x * 4e-4;
        bench.poses[0].translation.x += 4e-4;
        bench.commanded[0].force.x = 1000;
        bench.tick();
    }
    EXPECT_LT(given, 0.05 + 0.005);
    EXPECT_GT(bench.filter.counters().passivity, 0u);
}

TEST(SafetyEngage, AChangeOfSceneEngagesAnew)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    bench.input.restart = true;
    bench.tick();
    EXPECT_TRUE(bench.silent());
}

// ---- Step 4

TEST(SafetyClamp, TooMuchIsShortenedAlongItsDirectionBeforeTheOtherSteps)
{
    Bench bench;
    bench.engage();
    for (int i = 0; i < 100; ++i) {
        bench.commanded[0] = {{30, 40, 0}, {0, 5, 0}};
        bench.tick();
        EXPECT_NE(bench.report.acted & k_acted_clamp, 0u);
    }
    EXPECT_NEAR(bench.force().x, 0.6, 1e-12) << "torque is at its limit, so force falls by the same factor";
    EXPECT_NEAR(bench.force().y, 0.8, 1e-12);
    EXPECT_NEAR(bench.safe[0].torque.y, 0.1, 1e-12);
    EXPECT_EQ(bench.filter.counters().last_clamped, 0u) << "nothing was left for the final clamp to do";
}

TEST(SafetyClamp, TorqueKeepsItsRatioToForceWhicheverLimitActs)
{
    // Commanded ever stronger about one line of action, past the limit in force, then past the limit in torque.
    for (const double lever : {0.001, 0.02, 0.05, 0.08, 0.5}) {
        Bench bench;
        bench.engage();
        for (double force = 0; force < 40; force += 0.05) {
            bench.commanded[0] = {{0, force, 0}, {0, 0, lever * force}};
            bench.tick();
            ASSERT_NEAR(bench.safe[0].torque.z, lever * bench.force().y, 1e-12) << lever << " m, " << force << " N";
        }
        EXPECT_NEAR(bench.force().y, std::min(2., 0.1 / lever), 1e-12);
    }
}

TEST(SafetyClamp, TheLeastOfUserAndDeviceHolds)
{
    const auto limit = [](double device, std::optional<double> user) {
        DeviceLimits limits = strong();
        limits.max_force = device;
        return SafetyFilter(limits, {.force_limit = user}).force_limit();
    };
    EXPECT_EQ(limit(20, {}), 2);
    EXPECT_EQ(limit(1.5, {}), 1.5);
    EXPECT_EQ(limit(0, {}), 1) << "unknown";
    EXPECT_EQ(limit(20, 7.5), 7.5);
    EXPECT_EQ(limit(0, 0.5), 0.5);
}

TEST(SafetyClamp, RefusedLimitsGiveNoForceAtAll)
{
    const auto setup_status = [](auto change) {
        DeviceLimits device = strong();
        SafetyOptions options;
        change(device, options);
        Bench bench(device, options);
        bench.run(0.6, {});
        bench.input.resume = true;
        bench.run(0.6, {1, 0, 0});
        if (bench.filter.setup_status() != SetupStatus::Ok) {
            EXPECT_TRUE(bench.silent());
            EXPECT_EQ(bench.report.faults, k_fault_setup);
        }
        EXPECT_STRNE(describe(bench.filter.setup_status()), "");
        return bench.filter.setup_status();
    };
    using D = DeviceLimits&;
    using O = SafetyOptions&;
    EXPECT_EQ(setup_status([](D, O) {}), SetupStatus::Ok);
    EXPECT_EQ(setup_status([](D, O o) { o.force_limit = 0; }), SetupStatus::LimitNotPositive);
    EXPECT_EQ(setup_status([](D, O o) { o.force_limit = -1; }), SetupStatus::LimitNotPositive);
    EXPECT_EQ(setup_status([](D, O o) { o.torque_limit = 0; }), SetupStatus::LimitNotPositive);
    EXPECT_EQ(setup_status([](D, O o) { o.force_limit = 20.01; }), SetupStatus::LimitAboveDevice);
    EXPECT_EQ(setup_status([](D, O o) { o.torque_limit = 1.01; }), SetupStatus::LimitAboveDevice);
    EXPECT_EQ(setup_status([](D d, O o) { d.max_force = 0, o.force_limit = 1.01; }), SetupStatus::LimitAboveDevice);
    EXPECT_EQ(setup_status([](D, O o) { o.force_limit = k_nan; }), SetupStatus::NotFinite);
    EXPECT_EQ(setup_status([](D, O o) { o.torque_limit = k_inf; }), SetupStatus::NotFinite);
    EXPECT_EQ(setup_status([](D d, O) { d.max_force = k_nan; }), SetupStatus::NotFinite);
    EXPECT_EQ(setup_status([](D d, O) { d.damping = -1; }), SetupStatus::NotFinite);
    EXPECT_EQ(setup_status([](D, O o) { o.slew = 0; }), SetupStatus::BadOption);
    EXPECT_EQ(setup_status([](D, O o) { o.slew = 1001; }), SetupStatus::BadOption);
    EXPECT_EQ(setup_status([](D, O o) { o.slew = k_nan; }), SetupStatus::BadOption);
    EXPECT_EQ(setup_status([](D, O o) { o.energy_margin = 0.02; }), SetupStatus::BadOption);
    EXPECT_EQ(setup_status([](D, O o) { o.energy_margin = -1e-3; }), SetupStatus::BadOption);
    EXPECT_EQ(setup_status([](D, O o) { o.softest = 19; }), SetupStatus::BadOption);
    EXPECT_EQ(setup_status([](D, O o) { o.softest = k_inf; }), SetupStatus::BadOption);
    EXPECT_EQ(setup_status([](D d, O) { d.delay = 1e300; }), SetupStatus::NotFinite);
    EXPECT_EQ(setup_status([](D d, O o) { d.max_torque = 0, o.torque_limit = 0.051; }), SetupStatus::LimitAboveDevice);
    EXPECT_EQ(setup_status([](D d, O) { d.period = 0; }), SetupStatus::BadPeriod);
    EXPECT_EQ(setup_status([](D d, O) { d.period = 0.1; }), SetupStatus::BadPeriod);
}

// ---- Step 5

TEST(SafetySlew, ForceGrowsByAQuarterNewtonATickAndFallsAtOnce)
{
    Bench bench;
    bench.engage();
    for (int i = 1; i <= 8; ++i) {
        bench.commanded[0] = {{0, 2, 0}, {0.1, 0, 0}};
        bench.tick();
        EXPECT_NEAR(bench.force().y, 0.25 * i, 1e-9);
        EXPECT_NEAR(bench.safe[0].torque.x, 0.0125 * i, 1e-9) << "torque by the same share of its limit";
    }
    bench.commanded[0] = {{0, 0.3, 0}, {}};
    bench.tick();
    EXPECT_EQ(bench.force().y, 0.3);
    EXPECT_EQ(bench.safe[0].torque.x, 0);
}

TEST(SafetySlew, ForceAndTorqueGrowTogether)
{
    for (const double lever : {0.001, 0.05, 0.4}) {
        Bench bench;
        bench.engage();
        for (int i = 0; i < 20; ++i) {
            bench.commanded[0] = {{0, 0.2, 0}, {0, 0, lever * 0.2}};
            bench.tick();
            ASSERT_NEAR(bench.safe[0].torque.z, lever * bench.force().y, 1e-12) << lever << " m, tick " << i;
        }
        EXPECT_NEAR(bench.force().y, 0.2, 1e-12);
    }
}

TEST(SafetySlew, AReversalGoesThroughZeroAndGrowsFromThere)
{
    Bench bench;
    bench.engage_and_push({2, 0, 0});
    bench.run(k_tick, {-2, 0, 0});
    EXPECT_NEAR(bench.force().x, -0.25, 1e-12);
}

TEST(SafetySlew, NeitherALateNorAnEarlyTickGrowsMore)
{
    Bench bench;
    bench.engage();
    bench.commanded[0].force = {2, 0, 0};
    bench.tick(true, 0.004);
    EXPECT_LE(bench.force().x, 0.25 + 1e-12);
    const double before = bench.force().x;
    bench.tick(true, 0.0001);
    EXPECT_LE(bench.force().x - before, 0.025 + 1e-12);
}

TEST(SafetySlew, NeverMoreThanCommandedAndNeverGrowsTooFastWhateverIsCommanded)
{
    Bench bench(strong(), {}, 2);
    bench.engage();
    SplitMix64 random(3);
    const auto grown = [](const Vec3d& from, const Vec3d& to) {  // what is left after all that a free decrease explains
        const double share = norm_sq(from) > 0 ? std::clamp(dot(from, to) / norm_sq(from), 0., 1.) : 0;
        return norm(to - share * from);
    };
    for (int i = 0; i < 20000; ++i) {
        const Vec3d before = bench.force();
        if (random.bits() % 4 == 0)
            bench.commanded[0].force = {random.between(-3, 3), random.between(-3, 3), random.between(-3, 3)};
        bench.tick();
        EXPECT_LE(norm(bench.force()), norm(bench.commanded[0].force) + 1e-12);
        EXPECT_LE(grown(before, bench.force()), 0.25 + 1e-9);
    }
}

// ---- Step 6

TEST(SafetySpeed, AboveAMetreASecondOnlyADamperThenAFault)
{
    Bench bench;
    bench.engage_and_push({2, 0, 0});
    bool faulted = false;
    for (int i = 0; i < 30; ++i) {
        bench.poses[0].translation.x += 1.5e-3;  // 1.5 m/s, pushed along: the force must not help
        bench.tick();
        EXPECT_LE(bench.force().x, 0) << i;
        if (i < 18) {
            EXPECT_EQ(bench.report.faults, 0u) << i;
        }
        faulted = faulted || (bench.report.faults & k_fault_fast) != 0;
    }
    EXPECT_TRUE(faulted);
    EXPECT_TRUE(bench.silent());
    bench.run(1, {});
    bench.run(1, {1, 0, 0});
    EXPECT_TRUE(bench.silent()) << "latched";
}

TEST(SafetySpeed, ASpinCountsAndAMeasuredTwistDoes)
{
    for (const bool measured : {false, true}) {
        Bench bench;
        std::vector<Twist> twists(1);
        bench.input.twists = twists;
        bench.engage_and_push({1, 0, 0});
        double angle = 0;
        for (int i = 0; i < 30; ++i) {
            if (measured)
                twists[0].angular = {0, 0, 25};
            else
                angle += 0.025;
            bench.poses[0].rotation = {
                {{std::cos(angle), -std::sin(angle), 0}, {std::sin(angle), std::cos(angle), 0}, {0, 0, 1}}};
            bench.tick();
        }
        EXPECT_EQ(bench.report.faults, k_fault_fast) << measured;
    }
}

TEST(SafetySpeed, OneGlitchIsBrakedByNoMoreThanTheSlew)
{
    Bench bench;
    bench.engage_and_push({});
    bench.poses[0].translation.x += 0.01;  // 10 m/s for a tick
    bench.tick();
    EXPECT_LE(norm(bench.force()), 0.25 + 1e-12);
    bench.run(0.1, {1, 0, 0});
    EXPECT_EQ(bench.force().x, 1);
}

TEST(SafetySpeed, AGlitchOfMillimetresNeverBecomesABlow)
{
    // For a tick or two, or for good; the force commanded follows the place, as a spring's does.
    for (const double damping : {0., 0.5, 1., 2., 5., 10.})
        for (const double glitch : {-0.004, 0.0015, 0.002, 0.004, 0.01, 0.04})
            for (const int ticks : {1, 2, 500}) {
                DeviceLimits device = strong();
                device.damping = damping;
                Bench bench(device, {.softest = 500});
                bench.engage();
                bench.run(0.5, {0.75, 0, 0});
                double before = bench.force().x;
                for (int i = 0; i < 500; ++i) {
                    const double off = i < ticks ? glitch : 0;
                    bench.poses[0].translation.x = off;
                    bench.commanded[0].force.x = std::max(0.75 - 500 * off, 0.);
                    bench.tick();
                    const double now = bench.force().x, kept = now * before > 0 ? std::fabs(before) : 0;
                    ASSERT_LE(std::fabs(now) - kept, 0.25 + 1e-12) << damping << ' ' << glitch << ' ' << ticks << ' ' << i;
                    before = now;
                }
            }
}

TEST(SafetySpeed, NineTenthsOfAMetreASecondIsAMotion)
{
    Bench bench;
    bench.engage();
    for (int i = 0; i < 50; ++i) {
        bench.commanded[0].force = {-1, 0, 0};
        bench.poses[0].translation.x += 0.9e-3;
        bench.tick();
    }
    EXPECT_EQ(bench.filter.counters().fast, 0u);
    EXPECT_NEAR(bench.force().x, -1, 1e-12);
}

}  // namespace
}  // namespace sqmap::haptic
