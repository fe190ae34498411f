// Every step of the safety filter by what it must prevent. tests/unit/haptic/CMakeLists.txt builds this file against filters that
// lack one step each, and expects the test of that step to fail.
#include "sqmap/haptic/safety.h"

#include "sqmap/math/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace sqmap::haptic {
namespace {

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN(), k_inf = std::numeric_limits<double>::infinity();
constexpr double k_tick = 1e-3;

/// A strong device: only the user's limits bind.
DeviceLimits strong()
{
    return {
        .max_force = 20, .max_torque = 1, .continuous_force = 20, .damping = 1, .coulomb_friction = 0.05, .resolution = 20e-6};
}

/// A filter, a clock and a device that answers every tick.
class Bench {
public:
    explicit Bench(const DeviceLimits& device = strong(), const SafetyOptions& options = {}, std::size_t zones = 1)
        : filter(device, options), poses(zones), commanded(zones), safe(zones)
    {
    }

    /// One tick; fresh or with the sample before.
    SafetyReport tick(bool fresh = true, double dt = k_tick)
    {
        input.time += dt;
        if (fresh) {
            ++input.sequence;
            input.sample_time = input.time;
        }
        input.poses = poses;
        input.commanded = commanded;
        report = filter.tick(input, safe);
        input.resume = input.restart = false;
        return report;
    }
    SafetyReport run(double seconds, Vec3d force)
    {
        for (int i = 0; i < std::lround(seconds / k_tick); ++i) {
            for (Wrench& w : commanded) w.force = force;
            tick();
        }
        return report;
    }
    /// Nothing commanded until all is engaged.
    void engage()
    {
        run(0.6, {});
        ASSERT_TRUE(report.engaged);
    }
    void engage_and_push(Vec3d force)
    {
        engage();
        run(0.1, force);
    }
    [[nodiscard]] Vec3d force(std::size_t zone = 0) const { return safe[zone].force; }
    [[nodiscard]] bool silent() const
    {
        for (const Wrench& w : safe)
            if (!(w == Wrench{})) return false;
        return true;
    }

    SafetyFilter filter;
    SafetyInput input;
    std::vector<Pose> poses;
    std::vector<Wrench> commanded, safe;
    SafetyReport report;
};

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
    EXPECT_NEAR(bench.force().x, 1.2, 1e-12);
    EXPECT_NEAR(bench.force().y, 1.6, 1e-12);
    EXPECT_NEAR(bench.safe[0].torque.y, 0.1, 1e-12);
    EXPECT_EQ(bench.filter.counters().last_clamped, 0u) << "nothing was left for the final clamp to do";
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
    const auto verdict = [](auto change) {
        DeviceLimits device = strong();
        SafetyOptions options;
        change(device, options);
        Bench bench(device, options);
        bench.run(0.6, {});
        bench.input.resume = true;
        bench.run(0.6, {1, 0, 0});
        if (bench.filter.verdict() != SetupVerdict::Ok) {
            EXPECT_TRUE(bench.silent());
            EXPECT_EQ(bench.report.faults, k_fault_setup);
        }
        EXPECT_STRNE(describe(bench.filter.verdict()), "");
        return bench.filter.verdict();
    };
    using D = DeviceLimits&;
    using O = SafetyOptions&;
    EXPECT_EQ(verdict([](D, O) {}), SetupVerdict::Ok);
    EXPECT_EQ(verdict([](D, O o) { o.force_limit = 0; }), SetupVerdict::LimitNotPositive);
    EXPECT_EQ(verdict([](D, O o) { o.force_limit = -1; }), SetupVerdict::LimitNotPositive);
    EXPECT_EQ(verdict([](D, O o) { o.torque_limit = 0; }), SetupVerdict::LimitNotPositive);
    EXPECT_EQ(verdict([](D, O o) { o.force_limit = 20.01; }), SetupVerdict::LimitAboveDevice);
    EXPECT_EQ(verdict([](D, O o) { o.torque_limit = 1.01; }), SetupVerdict::LimitAboveDevice);
    EXPECT_EQ(verdict([](D d, O o) { d.max_force = 0, o.force_limit = 1.01; }), SetupVerdict::LimitAboveDevice);
    EXPECT_EQ(verdict([](D, O o) { o.force_limit = k_nan; }), SetupVerdict::NotFinite);
    EXPECT_EQ(verdict([](D, O o) { o.torque_limit = k_inf; }), SetupVerdict::NotFinite);
    EXPECT_EQ(verdict([](D d, O) { d.max_force = k_nan; }), SetupVerdict::NotFinite);
    EXPECT_EQ(verdict([](D d, O) { d.damping = -1; }), SetupVerdict::NotFinite);
    EXPECT_EQ(verdict([](D, O o) { o.slew = 0; }), SetupVerdict::BadOption);
    EXPECT_EQ(verdict([](D, O o) { o.slew = 1001; }), SetupVerdict::BadOption);
    EXPECT_EQ(verdict([](D, O o) { o.slew = k_nan; }), SetupVerdict::BadOption);
    EXPECT_EQ(verdict([](D, O o) { o.energy_margin = 0.02; }), SetupVerdict::BadOption);
    EXPECT_EQ(verdict([](D, O o) { o.energy_margin = -1e-3; }), SetupVerdict::BadOption);
    EXPECT_EQ(verdict([](D, O o) { o.softest = 19; }), SetupVerdict::BadOption);
    EXPECT_EQ(verdict([](D, O o) { o.softest = k_inf; }), SetupVerdict::BadOption);
    EXPECT_EQ(verdict([](D d, O) { d.delay = 1e300; }), SetupVerdict::NotFinite);
    EXPECT_EQ(verdict([](D d, O o) { d.max_torque = 0, o.torque_limit = 0.051; }), SetupVerdict::LimitAboveDevice);
    EXPECT_EQ(verdict([](D d, O) { d.period = 0; }), SetupVerdict::BadPeriod);
    EXPECT_EQ(verdict([](D d, O) { d.period = 0.1; }), SetupVerdict::BadPeriod);
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

// ---- User, determinism, totality

TEST(SafetyUser, StopHoldsUntilTheUserResumesAndThenEngages)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    bench.input.stop = true;
    bench.tick();
    EXPECT_TRUE(bench.silent());
    EXPECT_EQ(bench.report.faults, k_fault_stop);
    bench.input.stop = false;
    bench.run(1, {});
    bench.run(1, {1, 0, 0});
    EXPECT_TRUE(bench.silent());
    bench.input.resume = true;
    bench.run(0.1, {1, 0, 0});
    EXPECT_TRUE(bench.silent()) << "engages anew";
    EXPECT_EQ(bench.report.faults, 0u);
    bench.run(0.6, {});
    bench.run(0.1, {1, 0, 0});
    EXPECT_EQ(bench.force().x, 1);
}

TEST(SafetyUser, StopBeatsResume)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    bench.input.stop = bench.input.resume = true;
    bench.tick();
    EXPECT_TRUE(bench.silent());
    EXPECT_EQ(bench.report.faults, k_fault_stop);
}

TEST(SafetyUser, LettingGoOfTheDeadMansSwitchIsZeroAtOnce)
{
    Bench bench(strong(), {.dead_man = true});
    bench.engage_and_push({1, 0, 0});
    EXPECT_EQ(bench.force().x, 1);
    bench.input.held = false;
    bench.tick();
    EXPECT_TRUE(bench.silent());
    EXPECT_EQ(bench.report.faults, 0u) << "no fault: holding it again engages";
    bench.input.held = true;
    bench.run(0.5, {1, 0, 0});
    EXPECT_TRUE(bench.silent());
    bench.run(0.6, {});
    bench.run(0.1, {1, 0, 0});
    EXPECT_EQ(bench.force().x, 1);
}

TEST(SafetyUser, AFaultWhoseCauseStaysCannotBeCleared)
{
    Bench bench;
    bench.engage_and_push({1, 0, 0});
    for (int i = 0; i < 120; ++i) bench.tick(false);
    bench.input.resume = true;
    bench.tick(false);
    EXPECT_EQ(bench.report.faults, k_fault_stale);
    bench.tick();
    bench.input.resume = true;
    bench.tick();
    EXPECT_EQ(bench.report.faults, 0u);
}

/// Inputs of every kind, sane and not.
class Monkey {
public:
    explicit Monkey(std::uint64_t seed, std::size_t zones) : random_(seed), poses_(zones), twists_(zones), commanded_(zones) {}
    const SafetyInput& next()
    {
        const auto rare = [&](std::uint64_t one_in) { return random_.bits() % one_in == 0; };
        const double strange[] = {k_nan, k_inf, -k_inf, 1e308, -1e308, 1e200, 5e-324, 1e9, 0.};
        const auto any = [&] { return strange[random_.bits() % std::size(strange)]; };
        in_.time += rare(500) ? random_.between(0, 0.2) : random_.between(0.0005, 0.0015);
        if (!rare(20)) ++in_.sequence;
        in_.sample_time = in_.time - random_.between(0, 0.002);
        for (std::size_t z = 0; z < poses_.size(); ++z) {
            poses_[z].translation += Vec3d{random_.between(-2e-4, 2e-4), random_.between(-2e-4, 2e-4), 0};
            if (rare(2000)) poses_[z].translation.x = any();
            if (rare(100) || std::fabs(poses_[z].translation.x) > 2) poses_[z].translation = {};
            if (rare(2000)) poses_[z].translation.z = 0.1;
            if (rare(2000)) poses_[z].rotation.row[1].y = any();
            if (rare(100)) poses_[z].rotation = {};
            if (rare(200)) commanded_[z].force = {random_.between(-4, 4), random_.between(-4, 4), random_.between(-1, 1)};
            if (rare(200)) commanded_[z].torque = {0, random_.between(-0.3, 0.3), 0};
            if (rare(2000)) commanded_[z].force.y = any();
            if (rare(200)) commanded_[z] = {};
            twists_[z].linear = {rare(3000) ? any() : 0., 0, 0};
        }
        in_.twists = twists_;
        in_.poses = poses_;
        in_.commanded = commanded_;
        in_.connected = !rare(3000);
        in_.stop = rare(5000);
        in_.resume = rare(50);
        in_.restart = rare(5000);
        in_.held = !rare(1000);
        return in_;
    }
    [[nodiscard]] bool last_is_finite() const
    {
        const auto sane = [](const Vec3d& v) { return std::fabs(v.x) <= 1e9 && std::fabs(v.y) <= 1e9 && std::fabs(v.z) <= 1e9; };
        for (std::size_t z = 0; z < poses_.size(); ++z)
            if (!sane(poses_[z].translation) || !sane(poses_[z].rotation.row[1]) || !sane(commanded_[z].force) ||
                !sane(twists_[z].linear))
                return false;
        return true;
    }

private:
    SplitMix64 random_;
    SafetyInput in_;
    std::vector<Pose> poses_;
    std::vector<Twist> twists_;
    std::vector<Wrench> commanded_;
};

TEST(SafetyFilter, NoInputWhateverGetsMoreThanTheLimitsOrForceFromWhatIsNotFinite)
{
    std::uint64_t forces = 0;
    for (const std::size_t zones : {1, 5, 16}) {
        DeviceLimits device = strong();
        device.delay = 2e-3;
        SafetyFilter filter(device, {.dead_man = true});
        Monkey monkey(zones, zones);
        std::vector<Wrench> safe(zones);
        for (int i = 0; i < 60000; ++i) {
            const SafetyReport report = filter.tick(monkey.next(), safe);
            for (const Wrench& w : safe) {
                ASSERT_TRUE(norm(w.force) <= 2 + 1e-12 && norm(w.torque) <= 0.1 + 1e-12) << i;
                if (report.faults != 0 || !monkey.last_is_finite() || report.age >= k_stale_zero) {
                    ASSERT_EQ(w, Wrench{}) << i;
                }
                if (norm(w.force) > 0.5) ++forces;
            }
        }
        const SafetyCounters& c = filter.counters();
        EXPECT_GT(std::min({c.not_finite, c.held, c.stale, c.teleports, c.engagements, c.clamped, c.slewed, c.off, c.faults}),
                  10u);
    }
    EXPECT_GT(forces, 1000u) << "the monkey gets some force at all";
}

TEST(SafetyFilter, TheSameInputsGiveTheSameBits)
{
    for (int pass = 0; pass < 2; ++pass) {
        SafetyFilter a(strong(), {}), b(strong(), {});
        Monkey first(9, 4), second(9, 4);
        std::array<Wrench, 4> x{}, y{};
        for (int i = 0; i < 20000; ++i) {
            a.tick(first.next(), x);
            b.tick(second.next(), y);
            ASSERT_EQ(std::memcmp(x.data(), y.data(), sizeof x), 0);
        }
    }
}

TEST(SafetyFilter, RaisesNoFloatingPointException)
{
    SafetyFilter filter(strong(), {});
    Monkey monkey(11, 3);
    std::array<Wrench, 3> safe{};
    for (int i = 0; i < 50000; ++i) {
        const SafetyInput& in = monkey.next();
        std::feclearexcept(FE_ALL_EXCEPT);
        filter.tick(in, safe);
        ASSERT_EQ(std::fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW), 0) << i;
    }
}

TEST(SafetyFilter, ZonesThatAreNotGivenGetNothing)
{
    Bench bench(strong(), {}, 2);
    bench.safe.assign(20, Wrench{{9, 9, 9}, {}});
    bench.engage();
    bench.run(0.1, {1, 0, 0});
    for (std::size_t z = 0; z < 20; ++z) EXPECT_EQ(bench.safe[z].force.x, z < 2 ? 1 : 0);
}

// ---- The stiffness that a device can show

TEST(Stiffness, IsTheLeastOfTheBoundsAndSaysWhich)
{
    DeviceLimits d{.damping = 1, .coulomb_friction = 0.05, .resolution = 20e-6, .period = 1e-3};
    StiffnessCheck c = check_stiffness(d, 1000);
    EXPECT_NEAR(c.largest, 2000, 1e-4);  // 2b/T
    EXPECT_EQ(c.reason, StiffnessReason::Sampling);
    EXPECT_TRUE(c.safe);
    EXPECT_FALSE(c.assumed);
    EXPECT_FALSE(check_stiffness(d, 2000).safe) << "strictly less";
    EXPECT_TRUE(check_stiffness(d, c.largest).safe) << "what is offered is safe";
    d.coulomb_friction = 0.01;
    c = check_stiffness(d, 1000.1);
    EXPECT_EQ(c.largest, 2 * 0.01 / 20e-6);
    EXPECT_EQ(c.reason, StiffnessReason::Quantisation);
    EXPECT_FALSE(c.safe);
    EXPECT_TRUE(check_stiffness(d, c.largest).safe) << "Abbott and Okamura's bound may be reached";
    d.delay = 2e-3;
    c = check_stiffness(d, 500);
    EXPECT_NEAR(c.largest, 1 / 2.5e-3, 1e-4);
    EXPECT_EQ(c.reason, StiffnessReason::Delay);
    EXPECT_FALSE(c.safe);
    c = check_stiffness(d, 100, -0.4);
    EXPECT_NEAR(c.largest, 0.6 / 2.5e-3, 1e-4);
    c = check_stiffness(d, 0, 1.0);
    EXPECT_EQ(c.largest, 0);
    EXPECT_EQ(c.reason, StiffnessReason::VirtualDamping);
    EXPECT_FALSE(c.safe);
    EXPECT_FALSE(check_stiffness(d, k_nan).safe);
    EXPECT_FALSE(check_stiffness(d, -1).safe);
    for (double DeviceLimits::*number : {&DeviceLimits::damping, &DeviceLimits::coulomb_friction, &DeviceLimits::resolution,
                                         &DeviceLimits::period, &DeviceLimits::delay}) {
        DeviceLimits absurd = d;
        absurd.*number = k_inf;
        EXPECT_FALSE(check_stiffness(absurd, 1).safe);
    }
    for (const StiffnessReason reason :
         {StiffnessReason::Sampling, StiffnessReason::Quantisation, StiffnessReason::Delay, StiffnessReason::VirtualDamping})
        EXPECT_GT(std::strlen(describe(reason)), 20u);
}

TEST(Stiffness, AnUnknownDeviceGetsACarefulBoundThatSaysSo)
{
    const StiffnessCheck c = check_stiffness({}, 100);
    EXPECT_TRUE(c.assumed);
    EXPECT_NEAR(c.largest, 2 * 0.1 / 1e-3, 1e-4);
}

}  // namespace
}  // namespace sqmap::haptic
