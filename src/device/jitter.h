// The lateness of a thread that wakes every millisecond: whether a machine can hold the rate, and what hinders it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sqmap::device {

/// Options of measure_jitter.
struct JitterOptions {
    double seconds = 10;   ///< 0.1 to 3600
    double period = 1e-3;  ///< s, 0.1 to 20 ms
    int priority = 0;      ///< SCHED_FIFO 1 to 99; 0: as other threads
};

/// Lateness in seconds after the deadline that the thread slept for.
struct Jitter {
    std::uint64_t ticks = 0;
    double p50 = 0, p99 = 0, p999 = 0, max = 0;
    std::uint64_t late = 0;  ///< more than a period
};

/// Runs the servo's own sleep for a while, without work, in a thread of its own; returns when that has ended. Returns nothing if
/// the system does not grant the priority. Any thread.
/// @throw std::invalid_argument for options out of range
[[nodiscard]] std::optional<Jitter> measure_jitter(const JitterOptions& options);

/// The p-quantile (0 to 1) of sorted values, by the nearest rank: an observed value, no interpolation. Any thread.
/// @pre not empty
[[nodiscard]] double quantile(const std::vector<double>& sorted, double p);

/// Properties of the machine; empty or -1 where unknown.
struct Machine {
    std::string kernel;      ///< release
    std::string preemption;  ///< "PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT" or ""
    std::string governor;    ///< of the first processor's clock
    int processors = 0;
    bool virtual_machine = false;
    long long rt_priority = -1;  ///< highest that the user may take (ulimit -r), -1: unlimited
    long long memory_lock = -1;  ///< bytes that this user may lock (ulimit -l), -1: unlimited
    double load = -1;            ///< average of the last minute
};
/// Reads them from the system. Any thread.
[[nodiscard]] Machine machine();

/// How well a machine holds the servo's rate.
enum class Holds : std::uint8_t {
    Steadily,  ///< under 0.1 % of the ticks late, 99.9 % within half a millisecond
    Mostly,    ///< under 1 % late: works, with ticks that the servo answers from the last contacts
    Not,
};
/// Any thread.
[[nodiscard]] Holds judge(const Jitter& jitter);

/// Remedies, most useful first; empty where there is nothing to gain. priority: how the caller's reader sets it. Any thread.
[[nodiscard]] std::vector<std::string> advice(const Machine& machine, const Jitter& plain, const std::optional<Jitter>& fifo,
                                              const char* priority = "ServoOptions::priority");

}  // namespace sqmap::device
