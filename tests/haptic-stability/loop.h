// A haptic loop in simulated time: surface -> safety filter -> device -> hand -> device -> surface, and what must hold of it.
#pragma once

#include "sqmap/device/servo.h"
#include "sqmap/device/simulated.h"
#include "sqmap/haptic/safety.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <type_traits>
#include <vector>

namespace sqmap::test {

using device::HandProfile;
using device::HandTarget;
using device::HeldTool;
using device::Mechanism;
using haptic::Wrench;

inline constexpr double k_tick = 1e-3;

/// The path of a hand: from free air onto a place of a surface, along it, back.
struct Visit {
    Vec3d position{};      ///< on the surface
    Vec3d out{0, 0, 1};    ///< unit, away from the solid
    Vec3d along{1, 0, 0};  ///< unit, tangential
    double speed = 0.3;    ///< m/s, the hand's greatest
    double push = 1.0;     ///< N, what the hand presses with in the end
    Mat3d rotation{};      ///< how it holds the tool
};

enum class Action { Press, Slide, Tap };
inline const char* name(Action action) { return action == Action::Press ? "press" : action == Action::Slide ? "slide" : "tap"; }

struct Figures {
    double largest = 0;     ///< N, that the motors exerted
    double swing = 0;       ///< N, peak to peak of the force in the last 0.5 s of holding still
    double turn_swing = 0;  ///< N m, of the torque
    double mean = 0;        ///< N, of the force then
    double created = 0;     ///< J, most that the motors had given since a contact began, less what the device's friction took
    double left = -1;       ///< J, the same when a contact ended: the greatest of all contacts
    double gained = 0;      ///< J, the same over the last 0.5 s of holding still
    double step = 0;        ///< N, of the force from tick to tick then
    int contacts = 0;
    int reversals = 0;       ///< of the force in that time, by more than still()
    std::uint64_t over = 0;  ///< ticks with more than the limit sent
    haptic::SafetyCounters filter;
};

struct Setting {
    Mechanism mechanism{};
    HandProfile hand{};
    double stiffness = 0;  ///< N/m, of the surface
};

/// The limits that a filter is given for a mechanism.
inline haptic::DeviceLimits limits_of(const Mechanism& m) { return device::safety_limits(device::capabilities_of(m, 1), k_tick); }

/// A force that swings by less than this with the hand at rest does not swing: two steps of the encoder, and a hundredth of a
/// newton for what has not quite died away.
inline double still(const Setting& setting) { return 2 * setting.stiffness * setting.mechanism.resolution + 0.01; }

/// How often a signal turns round by more than a step: twice a period where it swings, at most once where it only changes.
inline int reversals(std::span<const double> signal, double step)
{
    int count = 0, direction = 0;
    double extreme = signal.front();
    for (const double x : signal) {
        if (direction == 0 ? std::fabs(x - extreme) > step : direction * (extreme - x) > step) {
            count += direction != 0;
            direction = x > extreme ? 1 : -1;
            extreme = x;
        } else if (direction * (x - extreme) > 0) {
            extreme = x;
        }
    }
    return count;
}

/// How a run differs from the ordinary.
struct Course {
    double wait = 0.7;                                        ///< s in free air before it goes down; the filter's ramp takes 0.5
    double hold = 3;                                          ///< s
    std::span<const Pose> zones = std::span(&k_one_zone, 1);  ///< where each zone is, from where the hand is
    static constexpr Pose k_one_zone{};
};

/// The closed loop: a surface, the filter, mechanisms and hands that follow one target.
template <class Surface>
class Loop {
public:
    Loop(const Setting& setting, std::span<const Pose> zones, Surface& surface)
        : zones_(zones),
          surface_(surface),
          tools_(zones.size(), HeldTool(setting.mechanism, setting.hand)),
          filter_(unheated(setting.mechanism), {.softest = setting.stiffness}),
          poses_(zones.size()),
          commanded_(zones.size()),
          safe_(zones.size())
    {
    }
    void begin(const Pose& pose)
    {
        at_.pose = pose;
        for (std::size_t z = 0; z < tools_.size(); ++z) tools_[z].reset(target(z).pose);
    }
    void wait(double seconds)
    {
        at_.twist = {};
        for (double t = 0; t < seconds; t += k_tick) tick();
    }
    /// A straight move that starts and ends at rest, with the greatest speed commanded in the middle.
    void move(const Vec3d& to, double speed)
    {
        constexpr double pi = 3.14159265358979;
        const Vec3d from = at_.pose.translation;
        const double length = norm(to - from), seconds = 0.5 * pi * length / speed;
        for (double t = 0; t < seconds; t += k_tick) {
            const double s = 0.5 * (1 - std::cos(pi * t / seconds));
            at_.pose.translation = from + s * (to - from);
            at_.twist.linear = 0.5 * pi / seconds * std::sin(pi * t / seconds) * (to - from);
            tick();
        }
        at_.pose.translation = to;
        at_.twist = {};
        tick();
    }
    /// Takes the figures of the last half second, at rest.
    void look_back(double still)
    {
        const auto spread = [](const std::vector<double>& v) {
            const auto [low, high] = std::minmax_element(v.end() - 500, v.end());
            return *high - *low;
        };
        f_.swing = spread(forces_);
        f_.turn_swing = spread(torques_);
        f_.reversals = reversals({forces_.data() + forces_.size() - 500, 500}, still);
        for (auto it = forces_.end() - 500; it != forces_.end(); ++it) f_.step = std::max(f_.step, std::fabs(*it - *(it - 1)));
        for (auto it = forces_.end() - 500; it != forces_.end(); ++it) f_.mean += *it / 500;
        f_.gained = energies_.back() - energies_[energies_.size() - 500];
    }
    [[nodiscard]] Figures figures()
    {
        f_.filter = filter_.counters();
        return f_;
    }

private:
    /// Seconds of pressing at the limit are no matter for the duty step here.
    static haptic::DeviceLimits unheated(const Mechanism& mechanism)
    {
        haptic::DeviceLimits limits = limits_of(mechanism);
        limits.continuous_force = limits.max_force;
        return limits;
    }
    [[nodiscard]] HandTarget target(std::size_t z) const
    {
        const Pose& zone = zones_[z];
        return {{at_.pose.rotation * zone.rotation, at_.pose.rotation * zone.translation + at_.pose.translation}, at_.twist};
    }
    void tick()
    {
        for (std::size_t z = 0; z < tools_.size(); ++z) poses_[z] = tools_[z].measured();
        surface_(std::span<const Pose>(poses_), std::span(commanded_));
        time_ += k_tick;
        filter_.tick({.time = time_, .sample_time = time_, .sequence = ++sequence_, .poses = poses_, .commanded = commanded_},
                     safe_);
        double energy = 0, force = 0, torque = 0;
        bool touches = false;
        for (std::size_t z = 0; z < tools_.size(); ++z) {
            const Wrench& w = safe_[z];
            f_.over +=
                norm(w.force) > filter_.force_limit() * (1 + 1e-12) || norm(w.torque) > filter_.torque_limit() * (1 + 1e-12);
            tools_[z].step(&w, target(z), k_tick);
            const Wrench& exerted = tools_[z].exerted();
            f_.largest = std::max(f_.largest, norm(exerted.force));
            energy += tools_[z].work() - tools_[z].dissipated();
            force += norm(exerted.force);
            torque += norm(exerted.torque);
            touches = touches || !(commanded_[z] == Wrench{}) || !(exerted == Wrench{});
        }
        energies_.push_back(energy);
        if (touches && !touching_) {
            begun_ = energies_.size() > 1 ? energies_[energies_.size() - 2] : 0;
            ++f_.contacts;
        }
        if (touches) f_.created = std::max(f_.created, energy - begun_);
        if (!touches && touching_) f_.left = std::max(f_.left, energy - begun_);
        touching_ = touches;
        forces_.push_back(force);
        torques_.push_back(torque);
    }

    std::span<const Pose> zones_;
    Surface& surface_;
    std::vector<HeldTool> tools_;
    haptic::SafetyFilter filter_;
    std::vector<Pose> poses_;
    std::vector<Wrench> commanded_, safe_;
    Figures f_;
    HandTarget at_;
    std::vector<double> forces_, torques_, energies_;
    double time_ = 0, begun_ = 0;
    std::uint64_t sequence_ = 0;
    bool touching_ = false;
};

/// Runs one action. surface(poses, wrenches): what is commanded at measured poses; called once a tick.
template <class Surface>
Figures run_zones(const Setting& setting, Action action, const Visit& visit, const Course& course, Surface&& surface)
{
    Loop<std::remove_reference_t<Surface>> loop(setting, course.zones, surface);
    // Deep enough that the hand's spring holds the push against the surface's.
    const double depth = visit.push / setting.hand.stiffness + visit.push / setting.stiffness;
    const Vec3d above = visit.position + 0.02 * visit.out, pressed = visit.position - depth * visit.out;
    loop.begin({visit.rotation, above});
    loop.wait(course.wait);
    if (action == Action::Tap)
        for (int i = 0; i < 5; ++i) {
            loop.move(visit.position - std::min(depth, 0.01) * visit.out, visit.speed);
            loop.move(visit.position + 0.01 * visit.out, visit.speed);
        }
    loop.move(pressed, visit.speed);
    if (action == Action::Slide) {
        loop.move(pressed + 0.02 * visit.along, visit.speed);
        loop.move(pressed - 0.02 * visit.along, visit.speed);
        loop.move(pressed, visit.speed);
    }
    loop.wait(course.hold);
    loop.look_back(still(setting));
    loop.move(above, visit.speed);
    loop.wait(0.3);
    return loop.figures();
}

/// The same for one zone. surface: wrench for a measured pose.
template <class Surface>
Figures run(const Setting& setting, Action action, const Visit& visit, Surface&& surface, const Course& course = {})
{
    return run_zones(setting, action, visit, course,
                     [&](std::span<const Pose> poses, std::span<Wrench> wrenches) { wrenches[0] = surface(poses[0]); });
}

}  // namespace sqmap::test
