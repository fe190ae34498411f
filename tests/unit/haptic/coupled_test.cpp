#include "sqmap/haptic/stiffness.h"

#include "haptic/stencil.h"
#include "sqmap/haptic/step.h"
#include "touching.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::haptic::test {
namespace {

TEST(Step, ACoupledBodyComesToRestOnTheSurfaceAndPullsTheHand)
{
    ZoneOptions o = with(Averaging::Patch);
    o.mode = Mode::Coupled;
    o.stiffness = 3000;
    Tool tool(square(8), o);
    // 5 mm into the box: springs in series.
    Wrench w;
    for (int i = 0; i < 50; ++i) w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.03 + 0.001 * (50 - i) / 50});
    for (int i = 0; i < 50; ++i) w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.03 - 0.005 * i / 50});
    std::vector<double> last;
    for (int i = 0; i < 2000; ++i) {
        w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.025});
        if (i >= 1900) last.push_back(w.force.z);
    }
    const double series = o.coupling_stiffness * 3000 / (o.coupling_stiffness + 3000) * 0.005;
    EXPECT_NEAR(w.force.z, series, 0.05 * series);
    EXPECT_LT(0.03 - tool.report().body.translation.z, 0.002);
    const auto [lo, hi] = std::minmax_element(last.begin(), last.end());
    EXPECT_LT(*hi - *lo, 1e-4);
    // Free: nothing but the body's own inertia.
    for (int i = 0; i < 300; ++i) w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.06});
    EXPECT_LT(norm(w.force), 1e-3);
    EXPECT_LT(norm(w.torque), 1e-5);
}

TEST(Step, ACoupledBodyThatLeapsIsBlended)
{
    // A ball through the middle of a box, as above, through a coupling: the body leaps to the other side.
    for (const double blend : {0.0, 0.01}) {
        const Smoothing smoothing = ball_of(0.005);
        ZoneOptions o = with(Averaging::Ball);
        o.smoothing = smoothing;
        o.mode = Mode::Coupled;
        o.coupling_stiffness = 2000;
        o.blend_time = blend;
        Tool tool(stencil_points(smoothing), o);
        Wrench before = tool.touch(frictionless(box()), Vec3d{0, 0, 0.036});
        double largest = 0, strongest = 0;
        for (int i = 0; i < 800; ++i) {
            const Wrench w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.036 - 1e-4 * i});
            largest = std::max(largest, norm(w.force - before.force));
            strongest = std::max(strongest, norm(w.force));
            before = w;
        }
        EXPECT_GT(strongest, 8);
        if (blend > 0)
            EXPECT_LT(largest, 250 * 0.001 + 3 * 2000 * 1e-4);
        else
            EXPECT_GT(largest, 1.5);
    }
}

TEST(Step, ACoupledBodyTurnsOffAnEdge)
{
    ZoneOptions o = with(Averaging::Patch);
    o.mode = Mode::Coupled;
    Tool tool(square(12), o);
    // Pressed down half off the box's flat top: the box pushes one side up.
    Wrench w;
    for (int i = 0; i < 500; ++i) w = tool.touch(frictionless(box()), Vec3d{0.05, 0, 0.030 - std::min(i, 50) * 4e-5});
    EXPECT_GT(w.force.z, 0.3);
    EXPECT_GT(w.torque.y, 1e-3);
}

TEST(Step, CouplingDampingLeavesTheDevicePassive)
{
    const double largest = coupling_damping({.stiffness = 800, .mass = 0.05, .period = 0.001, .device_damping = 2});
    EXPECT_DOUBLE_EQ(largest, 2 - 0.5 * 800 * 0.001);  // b - K T / 2
    EXPECT_DOUBLE_EQ(coupling_damping({.stiffness = 800, .mass = 0.05, .period = 0.001, .device_damping = 100}),
                     2 * std::sqrt(800 * 0.05));
    EXPECT_DOUBLE_EQ(coupling_damping({.stiffness = 8000, .mass = 0.05, .period = 0.001, .device_damping = 2}), 0);
}

TEST(Step, CouplingDampingCountsDelayAndEncoder)
{
    const CouplingPhysics p{.stiffness = 200, .mass = 0.05, .period = 0.001, .device_damping = 1, .delay = 0.003};
    EXPECT_DOUBLE_EQ(coupling_damping(p), 1 - 200 * 0.0035);
    CouplingPhysics coarse = p;
    coarse.friction = 0.02;
    coarse.resolution = 1e-4;
    EXPECT_DOUBLE_EQ(coupling_damping(coarse), 0.02 * 0.001 / 1e-4);  // a step in a tick: 0.1 m/s and 0.02 N
}

TEST(Step, AChosenCouplingIsWithinWhatTheDeviceCanShow)
{
    for (const double b : {0.0, 0.1, 1.0, 5.0})
        for (const double delay : {0.0, 0.001, 0.003})
            for (const double resolution : {0.0, 10e-6, 100e-6})
                for (const double period : {0.00025, 0.001, 0.01}) {
                    const DeviceLimits device{
                        .damping = b, .coulomb_friction = 0.05, .resolution = resolution, .delay = delay, .period = period};
                    ZoneOptions o;
                    o.coupling_stiffness = 5000;
                    choose_coupling(o, device);
                    EXPECT_GT(o.coupling_stiffness, 0);
                    EXPECT_GT(o.coupling_damping, 0);
                    EXPECT_TRUE(check_stiffness(device, o.coupling_stiffness, o.coupling_damping).safe)
                        << b << ' ' << delay << ' ' << resolution << ' ' << period;
                    EXPECT_EQ(o.resolution, resolution);
                    ZoneOptions softer;
                    softer.coupling_stiffness = 5;
                    choose_coupling(softer, device);
                    EXPECT_EQ(softer.coupling_stiffness, 5) << "never stiffer than asked";
                }
}

TEST(Step, ATorqueShareKeepsTheTurningSpringWithinWhatTheDeviceShows)
{
    const DeviceLimits device{.damping = 1, .coulomb_friction = 0.05, .resolution = 25e-6, .delay = 0.001, .period = 0.001};
    EXPECT_EQ(largest_torque_share(device, 500, 0.01), 1);
    const double reach = 0.1, share = largest_torque_share(device, 500, reach);
    EXPECT_NEAR(share * 500 * reach * reach * 0.0015, 1 * 0.02 * 0.02, 1e-9);  // K (T/2 + delay) = b, turning
    EXPECT_EQ(largest_torque_share(device, 0, reach), 1);
}

TEST(Step, ACouplingHidesAnEncodersSteps)
{
    // In free air at 5 mm/s an encoder of 25 um gives one step in 5 ticks: 25 mm/s for one tick, 0 for four.
    double worst[2] = {};
    for (const bool reported : {false, true}) {
        ZoneOptions o = with(Averaging::Patch);
        o.mode = Mode::Coupled;
        o.coupling_damping = 5;
        o.resolution = reported ? 25e-6 : 0;
        o.blend_time = 0;  // or the steps would be taken for jumps
        Tool tool(square(4), o);
        for (int i = 0; i < 400; ++i) {
            const double x = 25e-6 * std::round(5e-6 * i / 25e-6);
            const Wrench w = tool.touch(frictionless(box()), Vec3d{x, 0, 0.06});
            if (i > 100) worst[reported] = std::max(worst[reported], norm(w.force));
        }
    }
    EXPECT_GT(worst[0], 0.04);
    EXPECT_LT(worst[1], 0.25 * worst[0]);
}

}  // namespace
}  // namespace sqmap::haptic::test
