// Totals of a touch over all its ticks, and how they are printed.
#pragma once

#include "sqmap/device/servo.h"
#include "sqmap/device/trace.h"
#include "sqmap/haptic/safety.h"
#include "sqmap/haptic/step.h"

#include <array>
#include <cstdint>
#include <string>

namespace sqmap::app {

/// While a zone had no force because it was inside when forces were to begin.
struct Inside {
    std::uint64_t ticks = 0;
    double first = 0, last = 0;  ///< s
    bool now = false;
};

struct Totals {
    std::uint64_t ticks = 0, contact = 0, faulty = 0;  ///< faulty: the filter let nothing through
    double first_fault = 0;                            ///< s
    std::uint32_t faults = 0;                          ///< bits of SafetyFault
    std::uint64_t hot = 0, braked = 0;                 ///< ticks in which the filter's duty and passivity steps acted
    std::uint64_t changed = 0;                         ///< ticks in which it sent anything but what was asked for
    double largest_force = 0, largest_sent = 0, deepest = 0, cpu = 0, max_cpu = 0;
    std::array<Inside, device::k_max_zones> inside{};
    std::uint64_t unknown = 0;  ///< ticks that were too many at once to learn what they felt
    bool gone = false;
    haptic::SafetyCounters counted{};
    device::ServoCounters servo{};

    void add(const device::TraceRow& row, std::size_t zones, double depth);
};

/// The touch that totals are about.
struct TouchFacts {
    std::size_t zones = 1;
    bool glove = false, by_the_clock = false, has_impact_zone = false;
    double force_limit = 0;  ///< N
};

/// Prints the totals; warnings go to standard error.
void print(const Totals& totals, const TouchFacts& facts);

/// Why the safety filter has let nothing through, in words. faults: bits of SafetyFault.
[[nodiscard]] std::string reasons(std::uint32_t faults);

/// The name of a zone: a glove's by its finger.
[[nodiscard]] std::string zone_name(std::size_t zone, std::size_t zones, bool glove);

}  // namespace sqmap::app
