// A haptic loop in simulated time: surface -> safety filter -> device -> hand -> device -> surface, and what must hold of it.
#pragma once

#include "sqmap/device/servo.h"
#include "sqmap/device/simulated.h"
#include "sqmap/haptic/safety.h"

#include <algorithm>
#include <cmath>
#include <span>
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

/// Runs one action. surface(poses, wrenches): what is commanded at measured poses; called once a tick.
template <class Surface>
Figures run_zones(const Setting& setting, Action action, const Visit& visit, const Course& course, Surface&& surface)
{
    const HandProfile& hand = setting.hand;
    const std::size_t zones = course.zones.size();
    std::vector<HeldTool> tools(zones, HeldTool(setting.mechanism, hand));
    haptic::DeviceLimits limits = limits_of(setting.mechanism);
    limits.continuous_force = limits.max_force;  // seconds of pressing at the limit are no matter for the duty step here
    haptic::SafetyFilter filter(limits, {.softest = setting.stiffness});
    Figures f;
    double time = 0;
    std::uint64_t sequence = 0;
    std::vector<double> forces, torques, energies;
    std::vector<Pose> poses(zones);
    std::vector<Wrench> commanded(zones), safe(zones);
    bool touching = false;
    double begun = 0;
    const auto target_of = [&](const HandTarget& at, std::size_t z) {
        const Pose& zone = course.zones[z];
        return HandTarget{{at.pose.rotation * zone.rotation, at.pose.rotation * zone.translation + at.pose.translation},
                          at.twist};
    };
    const auto tick = [&](const HandTarget& target) {
        for (std::size_t z = 0; z < zones; ++z) poses[z] = tools[z].measured();
        surface(std::span<const Pose>(poses), std::span(commanded));
        time += k_tick;
        filter.tick({.time = time, .sample_time = time, .sequence = ++sequence, .poses = poses, .commanded = commanded}, safe);
        double energy = 0, force = 0, torque = 0;
        bool touches = false;
        for (std::size_t z = 0; z < zones; ++z) {
            const Wrench& w = safe[z];
            f.over += norm(w.force) > filter.force_limit() * (1 + 1e-12) || norm(w.torque) > filter.torque_limit() * (1 + 1e-12);
            tools[z].step(&w, target_of(target, z), k_tick);
            const Wrench& exerted = tools[z].exerted();
            f.largest = std::max(f.largest, norm(exerted.force));
            energy += tools[z].work() - tools[z].dissipated();
            force += norm(exerted.force);
            torque += norm(exerted.torque);
            touches = touches || !(commanded[z] == Wrench{}) || !(exerted == Wrench{});
        }
        energies.push_back(energy);
        if (touches && !touching) {
            begun = energies.size() > 1 ? energies[energies.size() - 2] : 0;
            ++f.contacts;
        }
        if (touches) f.created = std::max(f.created, energy - begun);
        if (!touches && touching) f.left = std::max(f.left, energy - begun);
        touching = touches;
        forces.push_back(force);
        torques.push_back(torque);
    };
    HandTarget at;
    const auto wait = [&](double seconds) {
        at.twist = {};
        for (double t = 0; t < seconds; t += k_tick) tick(at);
    };
    // A straight move that starts and ends at rest, with the greatest speed commanded in the middle.
    const auto move = [&](const Vec3d& to, double speed) {
        const Vec3d from = at.pose.translation;
        const double length = norm(to - from), seconds = 0.5 * 3.14159265358979 * length / speed;
        for (double t = 0; t < seconds; t += k_tick) {
            const double s = 0.5 * (1 - std::cos(3.14159265358979 * t / seconds));
            at.pose.translation = from + s * (to - from);
            at.twist.linear = 0.5 * 3.14159265358979 / seconds * std::sin(3.14159265358979 * t / seconds) * (to - from);
            tick(at);
        }
        at.pose.translation = to;
        at.twist = {};
        tick(at);
    };
    // Deep enough that the hand's spring holds the push against the surface's.
    const double depth = visit.push / hand.stiffness + visit.push / setting.stiffness;
    const Vec3d above = visit.position + 0.02 * visit.out, pressed = visit.position - depth * visit.out;
    at.pose = {visit.rotation, above};
    for (std::size_t z = 0; z < zones; ++z) tools[z].reset(target_of(at, z).pose);
    wait(course.wait);
    if (action == Action::Tap)
        for (int i = 0; i < 5; ++i) {
            move(visit.position - std::min(depth, 0.01) * visit.out, visit.speed);
            move(visit.position + 0.01 * visit.out, visit.speed);
        }
    move(pressed, visit.speed);
    if (action == Action::Slide) {
        move(pressed + 0.02 * visit.along, visit.speed);
        move(pressed - 0.02 * visit.along, visit.speed);
        move(pressed, visit.speed);
    }
    wait(course.hold);
    const auto spread = [](const std::vector<double>& v) {
        const auto [low, high] = std::minmax_element(v.end() - 500, v.end());
        return *high - *low;
    };
    f.swing = spread(forces);
    f.turn_swing = spread(torques);
    f.reversals = reversals({forces.data() + forces.size() - 500, 500}, still(setting));
    for (auto it = forces.end() - 500; it != forces.end(); ++it) f.step = std::max(f.step, std::fabs(*it - *(it - 1)));
    for (auto it = forces.end() - 500; it != forces.end(); ++it) f.mean += *it / 500;
    f.gained = energies.back() - energies[energies.size() - 500];
    move(above, visit.speed);
    wait(0.3);
    f.filter = filter.counters();
    return f;
}

/// The same for one zone. surface: wrench for a measured pose.
template <class Surface>
Figures run(const Setting& setting, Action action, const Visit& visit, Surface&& surface, const Course& course = {})
{
    return run_zones(setting, action, visit, course,
                     [&](std::span<const Pose> poses, std::span<Wrench> wrenches) { wrenches[0] = surface(poses[0]); });
}

}  // namespace sqmap::test
