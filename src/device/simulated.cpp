#include "sqmap/device/simulated.h"

#include "device/channel.h"
#include "sqmap/math/rotation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace sqmap::device {

namespace {

constexpr double k_substep = 50e-6;   // s
constexpr double k_tick = 1e-3;       // s, of the device's own controller
constexpr double k_never_hot = 1000;  // N, more than any limit
constexpr double k_max_passed = 1;    // s that one read() simulates: a program that was stopped does not replay an hour

Vec3d saturated(const Vec3d& v, double max_length)
{
    const double length = norm(v);
    return length > max_length ? max_length / length * v : v;
}

}  // namespace

void HeldTool::reset(const Pose& pose) noexcept
{
    pose_ = pose;
    twist_ = {};
    zero();
    work_ = dissipated_ = 0;
}

void HeldTool::zero() noexcept
{
    queue_ = {};
    written_ = false;
    exerted_ = {};
}

void HeldTool::step(const Wrench* written, const HandTarget& target, double dt) noexcept
{
    for (std::size_t i = queue_.size() - 1; i > 0; --i) queue_[i] = queue_[i - 1];
    if (written != nullptr) {
        queue_[0] = *written;
        written_ = true;
        since_write_ = 0;
    }
    const int count = std::max(1, static_cast<int>(std::ceil(dt / k_substep - 1e-9)));
    const double h = dt / count;
    const std::size_t delay = static_cast<std::size_t>(std::clamp(mechanism_.delay_ticks, 0, 8));
    const double mass = mechanism_.mass + hand_.mass, drag = mechanism_.damping + hand_.damping;
    const double inertia = mechanism_.inertia + hand_.inertia, turn_drag = mechanism_.turn_damping + hand_.turn_damping;
    for (int i = 0; i < count; ++i) {
        if (since_write_ > mechanism_.timeout) zero();
        since_write_ += h;
        exerted_ = written_ ? Wrench{saturated(queue_[delay].force, mechanism_.max_force),
                                     saturated(queue_[delay].torque, mechanism_.max_torque)}
                            : Wrench{};
        const Vec3d wanted = target.pose.translation + (i * h) * target.twist.linear;
        const Vec3d pull = hand_.stiffness * (wanted - pose_.translation) + hand_.damping * target.twist.linear;
        // Dampers are implicit, so that no damping, however strong, can make the simulation itself swing.
        Vec3d& v = twist_.linear;
        v = (v + h / mass * (exerted_.force + pull)) / (1 + h * drag / mass);
        const double stop = h * mechanism_.coulomb_friction / mass, speed = norm(v);
        v = speed > stop ? (1 - stop / speed) * v : Vec3d{};
        pose_.translation += h * v;

        const Vec3d twist = hand_.turn_stiffness * rotation_vector(target.pose.rotation * transpose(pose_.rotation)) +
                            hand_.turn_damping * target.twist.angular;
        Vec3d& w = twist_.angular;
        w = (w + h / inertia * (exerted_.torque + twist)) / (1 + h * turn_drag / inertia);
        pose_.rotation = rotation_by(h * w) * pose_.rotation;

        work_ += h * (dot(exerted_.force, v) + dot(exerted_.torque, w));
        dissipated_ +=
            h * (mechanism_.damping * norm_sq(v) + mechanism_.coulomb_friction * norm(v) + mechanism_.turn_damping * norm_sq(w));
    }
    pose_.rotation = orthonormal(pose_.rotation);
}

Pose HeldTool::measured() const noexcept
{
    Pose p = pose_;
    if (mechanism_.resolution > 0)
        for (int k = 0; k < 3; ++k)
            p.translation[k] = mechanism_.resolution * std::round(p.translation[k] / mechanism_.resolution);
    return p;
}

Capabilities capabilities_of(const Mechanism& m, std::size_t zones)
{
    Capabilities c;
    c.name = "simulated device in a simulated hand (no hardware)";
    c.simulated = true;
    c.zones = zones;
    c.rotates_in = c.force_out = c.torque_out = true;
    c.max_force = m.max_force;
    c.max_torque = m.max_torque;
    c.continuous_force = m.continuous_force > 0 ? m.continuous_force : k_never_hot;
    c.damping = m.damping;
    c.coulomb_friction = m.coulomb_friction;
    c.resolution = m.resolution;
    c.delay = m.delay_ticks * k_tick;
    return c;
}

const HandProfile& hand_profile(std::string_view name)
{
    std::string all;
    for (const HandProfile& p : k_hand_profiles) {
        if (name == p.name) return p;
        all += (all.empty() ? "" : ", ") + std::string(p.name);
    }
    throw DeviceError("simulated: a hand is one of " + all + ", not '" + std::string(name) + "'");
}

SimulatedDevice::SimulatedDevice(const SimulatedOptions& options)
    : options_(options),
      capabilities_(capabilities_of(options.mechanism, options.zones)),
      written_(options.zones),
      motors_(options.motors != nullptr ? *options.motors : own_motors_)
{
    if (options.zones < 1 || options.zones > k_max_zones) throw std::invalid_argument("a simulated device has 1 to 16 zones");
    tools_.assign(options.zones, HeldTool(options.mechanism, options.hand));
    for (std::size_t z = 0; z < tools_.size(); ++z)
        tools_[z].reset(options.script != nullptr ? options.script(options.script_context, 0, z).pose : Pose{});
}

SimulatedDevice::~SimulatedDevice() { SimulatedDevice::zero(); }

void SimulatedDevice::pass(double until) noexcept
{
    time_ = std::max(time_, until - k_max_passed);
    while (time_ + k_tick <= until) {
        if (cancelled_.exchange(false)) {
            fresh_write_ = false;
            for (HeldTool& tool : tools_) tool.zero();
        }
        double largest = 0;
        for (std::size_t z = 0; z < tools_.size(); ++z) {
            const HandTarget target =
                options_.script != nullptr ? options_.script(options_.script_context, time_, z) : HandTarget{};
            tools_[z].step(fresh_write_ ? &written_[z] : nullptr, target, k_tick);
            largest = std::max(largest, norm(tools_[z].exerted().force));
        }
        fresh_write_ = false;
        time_ += k_tick;
        const double before = motors_.force.exchange(largest);
        if (before > 0 && largest == 0) motors_.let_go = begin_ + time_;
        if (largest > motors_.max_force) motors_.max_force = largest;
    }
}

bool SimulatedDevice::read(Sample& sample) noexcept
{
    // The script starts with the first read: a loop that a busy machine starts late feels all of it.
    if (begin_ == 0) begin_ = now();
    pass(options_.step > 0 ? time_ + options_.step + 0.5 * k_tick : now() - begin_);
    if (!plugged_) return false;
    if (frozen_) return true;
    sample.time = begin_ + time_;
    sample.sequence = ++sequence_;
    for (std::size_t z = 0; z < tools_.size(); ++z) {
        sample.poses[z] = tools_[z].measured();
        if (poisoned_) sample.poses[z].translation.x = std::numeric_limits<double>::quiet_NaN();
    }
    return true;
}

bool SimulatedDevice::write(std::span<const Wrench> wrenches) noexcept
{
    if (!plugged_) return false;
    for (std::size_t z = 0; z < written_.size(); ++z) written_[z] = z < wrenches.size() ? wrenches[z] : Wrench{};
    fresh_write_ = true;
    motors_.last_write = now();
    ++motors_.writes;
    return true;
}

void SimulatedDevice::zero() noexcept
{
    cancelled_ = true;
    ++motors_.zeros;
    if (motors_.force.exchange(0) > 0) motors_.let_go = now();
}

}  // namespace sqmap::device
