// Tests the safety filter as a whole: its user, any input, the same bits; and the stiffness that a device can show.
#include "bench.h"
#include "math/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <cstring>
#include <vector>

namespace sqmap::haptic {
namespace {

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
