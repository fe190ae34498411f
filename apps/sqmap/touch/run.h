// The loop of a touch: a path tick by tick, or a device by the clock.
#pragma once

#include "sqmap/device/device.h"
#include "sqmap/device/servo.h"
#include "sqmap/device/trace.h"
#include "touch/setup.h"
#include "touch/totals.h"

namespace sqmap::app {

/// Ctrl-C ends the loops from now on, so that what is recorded is finished.
void catch_interrupts();

struct RunOptions {
    double seconds = 10;
    device::TraceWriter* writer = nullptr;  ///< null: nothing is recorded
    bool glove = false;                     ///< zones are called by their fingers
};

/// A path: every pose once, no clock, so that the same path gives the same trace.
/// @throw BadTouch for limits that the safety filter refuses
[[nodiscard]] Totals play(device::Device& path, TouchSetup& setup, const haptic::SafetyOptions& safety,
                          const RunOptions& options);

/// A device, by the clock: the servo's thread ticks, this one records.
/// @throw std::invalid_argument, std::system_error as Servo does
[[nodiscard]] Totals run_servo(device::Device& device, TouchSetup& setup, const device::ServoOptions& servo,
                               const RunOptions& options);

}  // namespace sqmap::app
