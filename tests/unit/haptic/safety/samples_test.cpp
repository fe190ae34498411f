// The steps of the safety filter that judge samples: what is not finite (1) and what is old (2).
// safety_mutants.cmake builds these tests against filters that lack one step each, and expects the tests of that step to fail.
#include "bench.h"

#include <gtest/gtest.h>

#include <vector>

namespace sqmap::haptic {
namespace {

// ---- Step 1

TEST(SafetyFinite, AnythingNotFiniteIsZeroInTheSameTickInEveryZone)
{
    for (const double bad : {k_nan, k_inf, -k_inf, 1e300})
        for (int what = 0; what < 10; ++what) {
            Bench bench(strong(), {}, 3);
            std::vector<Twist> twists(3);
            bench.input.twists = twists;
            bench.engage_and_push({1, 0, 0});
            ASSERT_EQ(bench.force(0), (Vec3d{1, 0, 0}));
            const double time = bench.input.time;
            if (what == 0) bench.poses[1].translation.y = bad;
            if (what == 1) bench.poses[2].rotation.row[1].x = bad;
            if (what == 2) bench.commanded[0].force.z = bad;
            if (what == 3) bench.commanded[1].torque.x = bad;
            if (what == 4) twists[2].linear.x = bad;
            if (what == 5) twists[0].angular.z = bad;
            if (what == 6) bench.input.time = bad;
            if (what == 7) bench.poses[0].rotation.row[0].z = bad;
            if (what == 8) bench.poses[0].rotation.row[2].y = bad;
            const bool own_clock = what == 9;
            if (own_clock) {
                bench.input.time += k_tick;
                ++bench.input.sequence;
                bench.input.sample_time = bad;
                bench.tick(false, 0);
            } else {
                bench.tick();
            }
            EXPECT_TRUE(bench.silent()) << bad << " in " << what;
            EXPECT_EQ(bench.filter.counters().not_finite, 1u);
            EXPECT_EQ(bench.report.faults, 0u) << "one bad tick is no fault";
            // Back to health: it grows again, no faster than the slew allows.
            bench.poses.assign(3, {});
            bench.commanded.assign(3, {{1, 0, 0}, {}});
            twists.assign(3, {});
            bench.input.time = time + k_tick;
            bench.tick();
            EXPECT_LE(norm(bench.force()), 0.25 + 1e-12);
            for (int i = 0; i < 10; ++i) bench.tick();
            EXPECT_EQ(bench.force(0), (Vec3d{1, 0, 0}));
        }
}

TEST(SafetyFinite, ThreeBadTicksWithinATenthOfASecondAreAFaultThreeInASecondAreNot)
{
    for (const double apart : {0.03, 0.06}) {
        Bench bench;
        bench.engage_and_push({1, 0, 0});
        for (int i = 0; i < 3; ++i) {
            bench.poses[0].translation.x = k_nan;
            bench.tick();
            EXPECT_TRUE(bench.silent());
            bench.poses[0] = {};
            if (i < 2) bench.run(apart - k_tick, {1, 0, 0});
        }
        EXPECT_EQ(bench.report.faults, apart < 0.05 ? k_fault_not_finite : 0u);
        bench.run(0.05, {1, 0, 0});
        EXPECT_EQ(bench.silent(), apart < 0.05);
    }
}

TEST(SafetyFinite, ARotationThatIsNoneIsNotBelieved)
{
    const Mat3d none[] = {{{{}, {}, {}}},
                          {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                          {{{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}},
                          {{{1, 0, 0}, {0.01, 1, 0}, {0, 0, 1}}},
                          {{{1, 0, 0}, {1, 0, 0}, {0, 0, 1}}},
                          {{{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}},
                          {{{1, 0, 0}, {0, 1.005, 0}, {0, 0, 1}}}};
    for (const Mat3d& rotation : none) {
        Bench bench(strong(), {}, 2);
        bench.engage_and_push({1, 0, 0});
        bench.poses[1].rotation = rotation;
        bench.tick();
        EXPECT_TRUE(bench.silent()) << rotation.row[0].x << ' ' << rotation.row[1].x << ' ' << rotation.row[1].y;
        bench.poses[1].rotation = {};
        bench.run(0.01, {1, 0, 0});
        EXPECT_EQ(bench.force(1), (Vec3d{1, 0, 0}));
    }
    // Seven digits are a rotation.
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    bench.poses[0].rotation = {{{0.9999500f, -0.0099998f, 0}, {0.0099998f, 0.9999500f, 0}, {0, 0, 1}}};
    bench.tick();
    EXPECT_EQ(bench.force(), (Vec3d{1, 0, 0}));
    EXPECT_EQ(bench.filter.counters().not_finite, 0u);
}

TEST(SafetyFinite, AClockThatRunsBackIsNotBelieved)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    bench.tick(true, -0.5);
    EXPECT_TRUE(bench.silent());
    EXPECT_EQ(bench.filter.counters().not_finite, 1u);
}

// ---- Step 2

TEST(SafetyStale, ForceIsHeldFallsAndIsZeroTwentyMillisecondsAfterTheLastSample)
{
    Bench bench(strong(), {}, 2);
    bench.engage_and_push({1.6, 0, 0});
    for (Wrench& w : bench.commanded) w.force = {0, 1.6, 0};  // a stale pose is no reason for another force
    double last = 1.6;
    for (int age = 1; age <= 120; ++age) {
        bench.tick(false);
        const double f = norm(bench.force(1));
        EXPECT_NEAR(bench.report.age, age * k_tick, 1e-9);
        EXPECT_EQ(bench.force(1).y, 0);
        if (age < 5) {
            EXPECT_EQ(f, 1.6) << age;
        }
        if (age > 5 && age < 20) {
            EXPECT_NEAR(f, 1.6 * (20 - age) / 15, 1e-6) << age;
        }
        if (age >= 20) {
            EXPECT_TRUE(bench.silent()) << age;
        }
        EXPECT_LE(f, last);
        last = f;
        if (age != 100) {
            EXPECT_EQ(bench.report.faults, age > 100 ? k_fault_stale : 0u) << age;
        }
    }
    bench.run(1, {1, 0, 0});
    EXPECT_TRUE(bench.silent()) << "the fault is latched";
}

TEST(SafetyStale, ASlowDeviceIsHeldLongerButGoneAtTheSameTime)
{
    DeviceLimits slow = strong();
    slow.sample_period = 0.008;
    Bench bench(slow);
    bench.engage();
    for (int i = 0; i < 400; ++i) {
        bench.commanded[0].force = {1, 0, 0};
        bench.tick(i % 8 == 0);
        if (i > 10) {
            EXPECT_EQ(bench.force().x, 1) << "samples 8 ms apart are not late";
        }
    }
    const double age = bench.report.age;
    for (int i = 1; i <= 30; ++i) {
        bench.tick(false);
        if (age + i * k_tick >= 0.02 - 1e-9) {
            EXPECT_TRUE(bench.silent());
        }
    }
}

TEST(SafetyStale, AnOldSampleThatComesLateIsOld)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    const double stopped = bench.input.sample_time;
    for (int i = 0; i < 25; ++i) {  // new numbers, the device's clock stands still
        ++bench.input.sequence;
        bench.input.sample_time = stopped;
        bench.tick(false);
    }
    EXPECT_TRUE(bench.silent());
}

TEST(SafetyStale, AfterTheForceHasGoneItComesBackOnlyByEngaging)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    for (int i = 0; i < 25; ++i) bench.tick(false);
    bench.run(1, {1, 0, 0});
    EXPECT_TRUE(bench.silent()) << "still pushed in: waits";
    bench.run(0.01, {});
    bench.run(0.1, {1, 0, 0});
    EXPECT_GT(norm(bench.force()), 0.1);
    EXPECT_LT(norm(bench.force()), 0.3);
}

TEST(SafetyStale, ATickTwentyMillisecondsLateIsSilent)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    bench.tick(true, 0.019);
    EXPECT_FALSE(bench.silent());
    bench.tick(true, 0.021);
    EXPECT_TRUE(bench.silent());
    EXPECT_EQ(bench.report.faults, 0u);
    bench.tick(true, 0.101);
    EXPECT_EQ(bench.report.faults, k_fault_stale);
}

TEST(SafetyStale, AnUnpluggedDeviceGetsNothingAtOnce)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    bench.input.connected = false;
    bench.tick(false);
    EXPECT_TRUE(bench.silent());
    bench.input.connected = true;
    bench.run(0.5, {1, 0, 0});
    EXPECT_TRUE(bench.silent()) << "reconnected: engages anew";
}

TEST(SafetyStale, ADeviceThatWasGoneForLongComesBackWithoutAFault)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    bench.input.connected = false;
    for (int i = 0; i < 500; ++i) {
        bench.tick(false);
        ASSERT_TRUE(bench.silent());
    }
    EXPECT_EQ(bench.report.faults, 0u);
    bench.input.connected = true;
    bench.run(0.6, {});
    bench.run(0.1, {1, 0, 0});
    EXPECT_EQ(bench.force(), (Vec3d{1, 0, 0}));
}

TEST(SafetyFinite, OneBadSampleOfASlowDeviceIsNoFaultAndThreeAre)
{
    Bench bench;
    bench.engage();
    for (int sample = 0; sample < 3; ++sample) {
        bench.poses[0].translation.x = k_nan;
        bench.tick();
        for (int i = 0; i < 3; ++i) {
            EXPECT_TRUE(bench.silent());
            EXPECT_EQ(bench.report.faults, sample < 2 ? 0u : k_fault_not_finite);
            bench.tick(false);
        }
        bench.poses[0] = {};
        bench.tick();
    }
}

TEST(SafetyStale, WithoutAFirstSampleThereIsNoForce)
{
    Bench bench;
    for (int i = 0; i < 50; ++i) {
        bench.input.sequence = 0;
        bench.tick(false);
        EXPECT_TRUE(bench.silent());
    }
    EXPECT_EQ(bench.report.faults, 0u) << "a device may take its time to start";
}

}  // namespace
}  // namespace sqmap::haptic
