// The 1 kHz loop: reads a device, runs a tick, passes the result through the safety filter, writes; and its watchdog.
#pragma once

#include "sqmap/device/device.h"
#include "sqmap/haptic/safety.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace sqmap::device {

/// Input of a tick. References hold during the call only.
struct TickInput {
    const Sample& sample;
    double time = 0;        ///< s, steady clock
    double dt = 0;          ///< s since the last tick, measured
    bool degraded = false;  ///< the last tick overran or this one is late: answer cheaply, from the last contacts
    std::uint64_t tick = 0;
    std::span<double> pushes{};     ///< zero at first; filled in if known, see haptic::SafetyInput::pushes
    std::span<double> stiffened{};  ///< zero at first; filled in where settings change, see haptic::SafetyInput::stiffened
};
/// wrenches: one per zone, zero at first. Runs on the servo's thread: must not wait, allocate or throw. Its result becomes
/// ServoTick::status. A plain function and a context: no indirection that could allocate.
using TickFunction = std::uint32_t (*)(void* context, const TickInput& input, std::span<Wrench> wrenches) noexcept;

/// Options of a Servo.
struct ServoOptions {
    double period = 1e-3;      ///< s, 0.1 to 20 ms
    double budget = 0.8;       ///< share of the period that a tick may work; more makes the next one degraded
    int priority = 0;          ///< SCHED_FIFO 1 to 98, its watchdog one more; 0: as other threads. Needs the right: sqmap rtcheck
    bool lock_memory = false;  ///< mlockall, so that no tick waits for a page
    bool signals = true;       ///< zero on SIGINT and SIGTERM, then their earlier handlers
    haptic::SafetyOptions safety{};
};

/// One tick as it happened.
struct ServoTick {
    std::uint64_t tick = 0;
    double time = 0, dt = 0;  ///< s
    double late = 0;          ///< s after its deadline
    double cpu = 0;           ///< s of CPU time of reading, tick, filter and writing
    bool connected = false, degraded = false;
    std::uint32_t status = 0;  ///< what TickFunction returned
    haptic::SafetyReport safety{};
    haptic::SafetyCounters counted{};  ///< by the filter, since the start
    std::size_t zones = 0;
    Sample sample{};
    std::array<Wrench, k_max_zones> commanded{}, sent{};
};

/// Counts since the servo's start.
struct ServoCounters {
    std::uint64_t ticks = 0;
    std::uint64_t late = 0;      ///< more than a period after their deadline
    std::uint64_t missed = 0;    ///< deadlines without a tick of their own
    std::uint64_t overruns = 0;  ///< ticks that worked longer than their budget
    std::uint64_t degraded = 0;
    std::uint64_t watchdog = 0;  ///< times the watchdog found no heartbeat for 20 ms
    std::uint64_t dropped = 0;   ///< ticks lost to next(), because its caller fell too far behind
    double worst_late = 0;       ///< s
};

/// Limits of the filter from a device's capabilities; period: s. Any thread.
[[nodiscard]] haptic::DeviceLimits safety_limits(const Capabilities& capabilities, double period) noexcept;

/// Runs from construction to destruction. The device exerts nothing: before the filter engages, after stop(), when the heartbeat
/// is more than 20 ms old (a thread of its own watches, with its own timer), in the destructor, on SIGINT, SIGTERM, std::exit and
/// std::terminate. If the process is killed, the device's own time-out acts, or keep_in_own_process.
/// docs/realtime.md describes the loop. At most 8 servos at a time.
/// Without threads (WebAssembly), next() runs one due tick a call; time advances by one period a tick, and ticks missed while
/// nobody called are counted, not made up. Thread safety: stop, resume, hold, restart and counters may be called by any thread at
/// once; newest by one thread at a time and next by one thread at a time; construction and destruction by the owner alone. None
/// of them waits for the loop.
class Servo {
public:
    /// @throw std::invalid_argument for limits that the filter refuses, with its reason, or a period or priority out of range;
    /// std::system_error where a thread cannot be made or the priority is not granted.
    /// @pre device and context outlive the servo (not checked)
    Servo(Device& device, const ServoOptions& options, TickFunction tick, void* context);
    ~Servo();
    Servo(const Servo&) = delete;
    Servo& operator=(const Servo&) = delete;

    // Any thread.
    void stop() noexcept;           ///< STOP: zero from the next tick, and at the device at once, until resume()
    void resume() noexcept;         ///< the user's act that clears STOP and FAULT
    void hold(bool held) noexcept;  ///< the dead-man switch, where SafetyOptions::dead_man
    void restart() noexcept;        ///< the scene has changed: engage anew
    [[nodiscard]] ServoCounters counters() const noexcept;  ///< each value is exact; two of them may belong to different ticks

    // One thread each.
    bool newest(ServoTick& tick) noexcept;  ///< the last tick; false if none came since the last call
    bool next(ServoTick& tick) noexcept;    ///< every tick in order, up to 1024 behind; false if none waits

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace sqmap::device
