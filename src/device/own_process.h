// A device in a small process of its own, which zeroes the device when the program that drives it is killed.
#pragma once

#include "sqmap/device/device.h"

#include <memory>

namespace sqmap::device {

/// Opens the device, in the process that is to own it. May throw: keep_in_own_process throws what() of it.
using OpenDevice = std::unique_ptr<Device> (*)(void* context);

/// Options of keep_in_own_process.
struct OwnProcessOptions {
    double timeout = 0.020;  ///< s without a wrench until the keeper zeroes the device, 1 to 100 ms
    double period = 1e-3;    ///< s between two exchanges with device and program
    double wait = 10;        ///< s for the device to open
};

/// The device as seen through its keeper: a process forked off that reads and writes it every period through shared memory, and
/// zeroes it timeout after the last wrench, and at once when the program ends in whatever way, killed included. Keyboard
/// interrupts do not reach the keeper: it leaves when the program has left. Adds up to a period to the delay, and
/// capabilities() says so. Thread safety of the device: as every Device.
/// @pre no other thread runs yet: a forked process has only the thread that forked (not checked). Linux.
/// @throw std::invalid_argument for options out of range; std::runtime_error where the device cannot be opened, with the reason;
/// std::system_error where the process cannot be made.
[[nodiscard]] std::unique_ptr<Device> keep_in_own_process(OpenDevice open, void* context, const OwnProcessOptions& options = {});

}  // namespace sqmap::device
