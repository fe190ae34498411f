// The work of a servo's tick between reading its device and writing to it: the same with threads and without.
#pragma once

#include "sqmap/device/servo.h"

namespace sqmap::device {

/// The user's acts since the last tick.
struct TickActs {
    bool held = false, stop = false, resume = false, restart = false;
};

/// Thread safety: one thread at a time, the servo's.
class TickWork {
public:
    /// @throw std::invalid_argument as Servo does
    TickWork(Device& device, const ServoOptions& options, TickFunction tick, void* context);

    /// now: with its number, times and `degraded`; gets all the rest but `late` and `cpu`. Nothing is written to the device.
    void run(ServoTick& now, const TickActs& acts) noexcept;
    [[nodiscard]] std::size_t zones() const noexcept { return zones_; }

private:
    Device& device_;
    TickFunction tick_;
    void* context_;
    std::size_t zones_;
    haptic::SafetyFilter filter_;
    std::uint32_t resumes_ = 0;  ///< Sample::resumes of the last reading
};

}  // namespace sqmap::device
