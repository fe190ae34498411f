// A filter with a clock and a device, as the tests of its steps use it.
#pragma once

#include "sqmap/haptic/safety.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace sqmap::haptic {

inline constexpr double k_nan = std::numeric_limits<double>::quiet_NaN(), k_inf = std::numeric_limits<double>::infinity();
inline constexpr double k_tick = 1e-3;

/// A strong device: only the user's limits bind.
inline DeviceLimits strong()
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

}  // namespace sqmap::haptic
