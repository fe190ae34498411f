// The one interface to every haptic device: poses in, wrenches out, and the device's capabilities.
#pragma once

#include "sqmap/haptic/wrench.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

namespace sqmap::device {

using haptic::Twist;
using haptic::Wrench;

/// One zone is a stylus' tip or a tool; a glove has five fingers and a palm.
inline constexpr std::size_t k_max_zones = 16;

/// Capabilities of a device; the safety filter takes its limits from here. Zero means unknown: the careful default holds.
struct Capabilities {
    std::string name;         ///< for people: "Haply Inverse3 (service on localhost)"
    bool simulated = false;   ///< no hardware: never shown as though it were
    std::size_t zones = 1;    ///< poses in and wrenches out
    bool rotates_in = false;  ///< reports orientation
    bool force_out = false;   ///< directional force
    bool torque_out = false;
    bool rumble_out = false;      ///< only the force's magnitude is shown
    double max_force = 0;         ///< N
    double max_torque = 0;        ///< N m
    double continuous_force = 0;  ///< N, root mean square over 10 s
    double damping = 0;           ///< b, N s/m, of the mechanism
    double coulomb_friction = 0;  ///< f_c, N
    double resolution = 0;        ///< Delta, m, of the encoder at the tip
    double delay = 0;             ///< s from a pose to the force that answers it, besides the tick itself
    double rate = 1000;           ///< Hz at which poses come
    friend bool operator==(const Capabilities&, const Capabilities&) = default;
};

/// One reading.
struct Sample {
    double time = 0;                          ///< s, monotonic, when the device measured it
    std::uint64_t sequence = 0;               ///< grows by one with every fresh reading: an unchanged number marks a stale one
    std::array<Pose, k_max_zones> poses{};    ///< of the zones; the world, metres
    std::array<Twist, k_max_zones> twists{};  ///< measured by the device; zero while has_twist is false
    bool has_twist = false;
    std::uint32_t buttons = 0;  ///< a bit each
    std::uint32_t resumes = 0;  ///< how often the user has chosen, at the device, to resume after a FAULT or STOP of the filter
};

/// A device that cannot be opened: no such kind, not there, or wrong arguments; what() gives the reason and the remedy.
/// Thread safety: a value.
class DeviceError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Implementations: one file per family in src/device.
/// Thread safety: one thread at a time, the servo's; zero() may be called by any thread at any time. read, write, report and zero
/// never wait, allocate or throw: a thread of the device's own waits for the hardware. That thread exerts nothing once the last
/// write is older than 20 ms, and the destructor leaves the hardware without force.
class Device {
public:
    virtual ~Device() = default;
    /// Does not change during the device's life.
    [[nodiscard]] virtual const Capabilities& capabilities() const noexcept = 0;
    /// The newest reading. False when the device is gone; sample is then unchanged.
    virtual bool read(Sample& sample) noexcept = 0;
    /// One wrench per zone, N and N m, world axes. False when the device is gone.
    virtual bool write(std::span<const Wrench> wrenches) noexcept = 0;
    /// The safety filter's report on the wrenches of the next write (haptic::bits): for devices that can show it.
    virtual void report(std::uint32_t /*filter*/) noexcept {}
    /// Removes all force at once. Any thread may call it, at any time and more than once; watchdogs do. It cancels every wrench
    /// written before it. A later write() counts again, so whoever stops for good must also keep the servo from writing.
    virtual void zero() noexcept = 0;
};

}  // namespace sqmap::device
