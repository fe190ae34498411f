// The page's touch in steps of a tick, without a clock: the simulated hand and device, the forces and the safety filter that
// the servo joins.
#pragma once

#include "sqmap/device/servo.h"
#include "viewer/server/touch/forces.h"
#include "viewer/server/touch/hand.h"

#include <optional>
#include <vector>

namespace sqmap::viewer::test {

class Rehearsal {
public:
    static constexpr double k_tick = 1e-3;  // s

    struct Tick {
        Vec3d tool{}, hand{};       ///< m: as drawn, and of the device
        haptic::Wrench computed{};  ///< before the filter
        haptic::Wrench sent{};      ///< by the filter
        double depth = 0;           ///< m
        std::uint32_t acted = 0;    ///< bits of haptic::SafetyStep
        std::uint32_t faults = 0;   ///< bits of haptic::SafetyFault
        bool touching = false;
    };

    Rehearsal(std::vector<ObjectPtr> objects, const Settings& settings, Vec3d start)
        : hand_(start),
          options_(held_by(hand_)),
          tool_(options_.mechanism, options_.hand),
          forces_(std::move(objects), settings),
          filter_(device::safety_limits(device::capabilities_of(options_.mechanism, 1), k_tick),
                  {.force_limit = settings.force_limit})
    {
        tool_.reset({{}, start});
    }
    Rehearsal(const Rehearsal&) = delete;
    Rehearsal& operator=(const Rehearsal&) = delete;

    void aim(Vec3d target) { hand_.aim(target); }
    void adjust(const Settings& settings) { forces_.adjust(live_of(settings, 1)); }

    /// degraded: the servo has no time to query.
    const Tick& tick(bool degraded = false)
    {
        time_ += k_tick;
        tool_.step(written_ ? &safe_ : nullptr, hand_.at(time_), k_tick);
        const sqmap::Pose pose = tool_.measured();
        haptic::Wrench wrench{};
        (void)forces_.step({.pose = pose, .dt = k_tick, .degraded = degraded}, wrench);
        const haptic::ZoneReport& report = forces_.report();
        const double push = report.push, stiffened = forces_.stiffened();
        const haptic::SafetyReport safety = filter_.tick({.time = time_,
                                                          .sample_time = time_,
                                                          .sequence = ++sequence_,
                                                          .poses = {&pose, 1},
                                                          .commanded = {&wrench, 1},
                                                          .pushes = {&push, 1},
                                                          .stiffened = {&stiffened, 1}},
                                                         {&safe_, 1});
        written_ = true;
        last_ = {report.body.translation, pose.translation, wrench,        safe_,
                 forces_.found().depth,   safety.acted,     safety.faults, report.contacts > 0};
        return last_;
    }
    /// seconds of ticks, each handed to see.
    template <class See>
    void run(double seconds, See&& see)
    {
        for (double t = 0; t < seconds; t += k_tick) see(tick());
    }
    void run(double seconds)
    {
        run(seconds, [](const Tick&) {});
    }
    [[nodiscard]] const Tick& last() const { return last_; }
    [[nodiscard]] double limit() const { return filter_.force_limit(); }

private:
    Hand hand_;
    device::SimulatedOptions options_;
    device::HeldTool tool_;
    Forces forces_;
    haptic::SafetyFilter filter_;
    haptic::Wrench safe_{};
    bool written_ = false;
    double time_ = 0;
    std::uint64_t sequence_ = 0;
    Tick last_{};
};

}  // namespace sqmap::viewer::test
