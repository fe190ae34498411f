// Stability on surfaces with closed forms, up to the bound that check_stiffness offers, for every hand and delay.
#include "loop.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <vector>

namespace sqmap::test {
namespace {

/// Spring force of a plane z < 0.
auto plane(double stiffness)
{
    return [stiffness](const Pose& p) {
        const double depth = -p.translation.z;
        return depth > 0 ? Wrench{{0, 0, stiffness * depth}, {}} : Wrench{};
    };
}

/// A ball of radius 5 cm whose top is the origin.
auto ball(double stiffness)
{
    return [stiffness](const Pose& p) {
        const Vec3d from = p.translation - Vec3d{0, 0, -0.05};
        const double r = norm(from), depth = 0.05 - r;
        return depth > 0 && r > 0 ? Wrench{stiffness * depth / r * from, {}} : Wrench{};
    };
}

/// A bar of 4 cm along x that touches the plane with both ends: force and torque.
auto bar(double stiffness)
{
    return [stiffness](const Pose& p) {
        Wrench w;
        for (const double end : {-0.02, 0.02}) {
            const Vec3d arm = p.rotation * Vec3d{end, 0, 0};
            const double depth = -(p.translation + arm).z;
            if (depth <= 0) continue;
            const Vec3d force{0, 0, 0.5 * stiffness * depth};
            w = w + Wrench{force, cross(arm, force)};
        }
        return w;
    };
}

/// From light and fine to heavy and rough.
constexpr Mechanism k_mechanisms[] = {
    {.mass = 0.05, .damping = 0.5, .coulomb_friction = 0.02, .turn_damping = 2.5e-4, .resolution = 10e-6},
    {},
    {.mass = 0.07, .damping = 1.0, .coulomb_friction = 0.01, .resolution = 50e-6},
    {.mass = 0.10, .damping = 5.0, .coulomb_friction = 0.10, .turn_damping = 2.5e-3, .resolution = 50e-6},
};

/// About y.
Mat3d tilted(double angle)
{
    const double c = std::cos(angle), s = std::sin(angle);
    return {{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}};
}

struct Worst {
    double swing = 0, share = 0, turn = 0, created = -1, left = -1, gained = -1, largest = 0, stiffest = 0;
    int runs = 0;
    std::uint64_t passivity = 0;
    void add(const Figures& f, const Setting& s)
    {
        ++runs;
        swing = std::max(swing, f.swing);
        share = std::max(share, f.swing / still(s));
        turn = std::max(turn, f.turn_swing);
        created = std::max(created, f.created);
        left = std::max(left, f.left);
        gained = std::max(gained, f.gained);
        stiffest = std::max(stiffest, s.stiffness);
        largest = std::max(largest, f.largest);
        passivity += f.filter.passivity;
    }
};

/// The settings that a mechanism is tried at: shares of the stiffest that is allowed, and speeds in m/s.
struct Trials {
    std::vector<double> shares, speeds;
};

template <class MakeSurface>
void check_everything(const char* name, MakeSurface&& make, const Trials& trials, const Mat3d& rotation = {})
{
    Worst worst;
    for (const Mechanism& mechanism : k_mechanisms)
        for (const Action action : {Action::Press, Action::Slide, Action::Tap})
            for (const HandProfile& hand : device::k_hand_profiles)
                for (const int delay : {1, 2, 3})
                    for (const double share : trials.shares)
                        for (const double speed : trials.speeds) {
                            Setting setting{.mechanism = mechanism, .hand = hand};
                            setting.mechanism.delay_ticks = delay;
                            setting.stiffness = share * haptic::check_stiffness(limits_of(setting.mechanism), 0).largest;
                            const Figures f =
                                run(setting, action, {.speed = speed, .rotation = rotation}, make(setting.stiffness));
                            worst.add(f, setting);
                            const std::string what = std::string(name) + ' ' + test::name(action) + ' ' + hand.name + " b " +
                                                     std::to_string(mechanism.damping) + " delay " + std::to_string(delay) +
                                                     " K " + std::to_string(setting.stiffness) + " v " + std::to_string(speed);
                            EXPECT_LT(f.swing, still(setting)) << what;
                            EXPECT_LT(f.turn_swing, 0.02 * still(setting)) << what;
                            EXPECT_GT(f.mean, 0.3) << what << ": it is pressed at all";
                            EXPECT_GE(f.contacts, action == Action::Tap ? 2 : 1) << what;
                            EXPECT_LT(f.created, 1e-4) << what;
                            EXPECT_LT(f.left, 1e-5) << what << ": a closed path gives nothing";
                            EXPECT_LT(f.gained, 1e-6) << what << ": nor does holding still";
                            EXPECT_EQ(f.over, 0u) << what;
                            EXPECT_EQ(f.filter.faults, 0u) << what;
                        }
    std::printf(
        "%s: %d runs, K up to %.0f N/m; swing at rest at most %.4f N (%.2f of what counts as swinging), torque %.6f N m; "
        "energy created at most %.3g J, left by a contact %.3g J, by holding still %.3g J; greatest force %.3f N; passivity "
        "acted in %llu ticks\n",
        name, worst.runs, worst.stiffest, worst.swing, worst.share, worst.turn, worst.created, worst.left, worst.gained,
        worst.largest, static_cast<unsigned long long>(worst.passivity));
}

const Trials k_at_the_bound{{1.0}, {0.5}}, k_up_to_the_bound{{0.5, 1.0}, {0.2, 0.35, 0.5}};

TEST(Stability, OfAPlaneAtTheBound) { check_everything("plane", plane, k_at_the_bound); }
TEST(Stability, OfABallAtTheBound) { check_everything("ball", ball, k_at_the_bound); }
TEST(Stability, OfABarThatTiltsAtTheBound) { check_everything("bar", bar, k_at_the_bound, tilted(0.1)); }
TEST(StabilityUpToTheBound, OfAPlane) { check_everything("plane", plane, k_up_to_the_bound); }
TEST(StabilityUpToTheBound, OfABall) { check_everything("ball", ball, k_up_to_the_bound); }
TEST(StabilityUpToTheBound, OfABarThatTilts) { check_everything("bar", bar, k_up_to_the_bound, tilted(0.1)); }

TEST(Stability, AboveTheBoundIsDetectedSwingsUnfilteredAndIsHeldByTheFilter)
{
    for (const HandProfile& hand : device::k_hand_profiles)
        for (const double times : {4., 20.}) {
            Setting setting{.mechanism = {.delay_ticks = 3}, .hand = hand};
            const haptic::DeviceLimits limits = limits_of(setting.mechanism);
            setting.stiffness = times * haptic::check_stiffness(limits, 0).largest;
            EXPECT_FALSE(haptic::check_stiffness(limits, setting.stiffness).safe);
            // Without the filter, but within the device's limit: the loop that the tests above could not tell from a good one if
            // they measured the wrong thing.
            HeldTool tool(setting.mechanism, hand);
            const auto surface = plane(setting.stiffness);
            tool.reset({{}, {0, 0, 0.002}});
            double low = 1e9, high = 0;
            for (int i = 0; i < 3000; ++i) {
                const Wrench w = surface(tool.measured());
                tool.step(&w, {{{}, {0, 0, -1 / hand.stiffness}}, {}}, k_tick);
                if (i < 2500) continue;
                low = std::min(low, norm(tool.exerted().force));
                high = std::max(high, norm(tool.exerted().force));
            }
            const Figures f = run(setting, Action::Press, {}, surface);
            std::printf(
                "%2.0f times the bound, %-9s: unfiltered swings by %.3f N; filtered by %.3f N, energy created %.3g J, gained "
                "while held still %.3g J, passivity acted in %llu ticks\n",
                times, hand.name, high - low, f.swing, f.created, f.gained, static_cast<unsigned long long>(f.filter.passivity));
            if (times == 20) {
                EXPECT_GT(high - low, 1) << "it does swing";
            }
            EXPECT_LT(f.created, 4e-3) << hand.name;
            EXPECT_EQ(f.over, 0u);
        }
}

TEST(Stability, ASurfaceThatGivesEnergyIsNotAMotor)
{
    // A plane that pushes harder on the way out than on the way in: unfiltered it throws the hand off.
    for (const HandProfile& hand : device::k_hand_profiles) {
        Setting setting{.hand = hand, .stiffness = 300};
        double before = 0;
        const auto thrower = [&](const Pose& p) {
            const double depth = std::max(-p.translation.z, 0.), rising = before - depth;
            before = depth;
            return Wrench{{0, 0, depth > 0 ? 300 * depth + (rising > 0 ? 0.6 : 0) : 0}, {}};
        };
        const Figures f = run(setting, Action::Tap, {}, thrower);
        EXPECT_LT(f.created, 0.012) << hand.name;
        EXPECT_EQ(f.over, 0u);
    }
}

TEST(Stability, FaultsInTheMiddleOfAPressAreSilentInTimeForEveryHand)
{
    for (const HandProfile& hand : device::k_hand_profiles)
        for (const char* fault : {"nan", "stale", "unplugged", "teleport"}) {
            const Mechanism mechanism{.delay_ticks = 0};
            HeldTool tool(mechanism, hand);
            haptic::SafetyFilter filter(limits_of(mechanism), {});
            const auto surface = plane(300);
            tool.reset({{}, {0, 0, 0.01}});
            haptic::SafetyInput in;
            std::uint64_t over = 0;
            double at = -1, before = 0;
            for (int i = 0; i < 2000; ++i) {
                const bool now = i >= 1500;
                in.time = i * k_tick;
                Pose pose = tool.measured();
                if (now && *fault == 'n') pose.translation.z = std::nan("");
                if (now && *fault == 't') pose.translation.x += 0.2;
                if (!now || *fault != 's') {
                    in.sample_time = in.time;
                    ++in.sequence;
                }
                in.connected = !(now && *fault == 'u');
                const Wrench commanded = surface(pose);
                Wrench safe;
                in.poses = {&pose, 1};
                in.commanded = {&commanded, 1};
                filter.tick(in, {&safe, 1});
                over += norm(safe.force) > filter.force_limit();
                if (i == 1499) before = norm(safe.force);
                if (now && safe == Wrench{} && at < 0) at = in.time - 1.499;
                if (at >= 0) {
                    EXPECT_EQ(safe, Wrench{}) << fault << " and it stays so";
                }
                tool.step(&safe, {{{}, {0, 0, i < 800 ? 0.01 : -1 / hand.stiffness - 1. / 300}}, {}}, k_tick);
            }
            EXPECT_GT(before, 0.3) << hand.name;
            EXPECT_EQ(over, 0u);
            EXPECT_GT(at, 0);
            EXPECT_LE(at, (*fault == 's' ? 0.020 : 0.001) + 1e-9) << hand.name << ' ' << fault;
        }
}

}  // namespace
}  // namespace sqmap::test
