#include "servo_tick.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace sqmap::device {
namespace {

void check(const ServoOptions& options)
{
    if (!(options.period >= 1e-4 && options.period <= 0.02)) throw std::invalid_argument("a tick must be between 0.1 and 20 ms");
    if (!(options.budget > 0 && options.budget <= 1)) throw std::invalid_argument("a tick's budget is a share of its period");
    if (options.priority < 0 || options.priority > 98) throw std::invalid_argument("priority must be 0 or 1 to 98");
}

}  // namespace

haptic::DeviceLimits safety_limits(const Capabilities& c, double period) noexcept
{
    return {.max_force = c.max_force,
            .max_torque = c.max_torque,
            .continuous_force = c.continuous_force,
            .damping = c.damping,
            .coulomb_friction = c.coulomb_friction,
            .resolution = c.resolution,
            .delay = c.delay,
            .period = period,
            .sample_period = c.rate > 0 ? 1 / c.rate : period};
}

TickWork::TickWork(Device& device, const ServoOptions& options, TickFunction tick, void* context)
    : device_(device),
      tick_(tick),
      context_(context),
      zones_(std::min(device.capabilities().zones, k_max_zones)),
      filter_(safety_limits(device.capabilities(), options.period), options.safety)
{
    check(options);
    if (const haptic::SetupStatus status = filter_.setup_status(); status != haptic::SetupStatus::Ok)
        throw std::invalid_argument(std::string("the safety filter refuses: ") + haptic::describe(status));
}

void TickWork::run(ServoTick& now, const TickActs& acts) noexcept
{
    now.zones = zones_;
    now.connected = device_.read(now.sample);
    const bool resumed_there = now.connected && now.sample.resumes != resumes_;
    if (now.connected) resumes_ = now.sample.resumes;
    now.commanded.fill({});
    std::array<double, k_max_zones> pushes{}, stiffened{};
    now.status = 0;
    if (now.connected && now.sample.sequence != 0)
        now.status = tick_(
            context_, {now.sample, now.time, now.dt, now.degraded, now.tick, {pushes.data(), zones_}, {stiffened.data(), zones_}},
            {now.commanded.data(), zones_});
    haptic::SafetyInput in{.time = now.time,
                           .sample_time = now.sample.time,
                           .sequence = now.sample.sequence,
                           .poses = {now.sample.poses.data(), zones_},
                           .commanded = {now.commanded.data(), zones_},
                           .pushes = {pushes.data(), zones_},
                           .stiffened = {stiffened.data(), zones_},
                           .connected = now.connected,
                           .held = acts.held,
                           .stop = acts.stop,
                           .resume = acts.resume || resumed_there,
                           .restart = acts.restart};
    if (now.sample.has_twist) in.twists = {now.sample.twists.data(), zones_};
    now.safety = filter_.tick(in, now.sent);
    now.counted = filter_.counters();
}

}  // namespace sqmap::device
