// Clocks of the system in whole nanoseconds: for loops that hold a rate.
#pragma once

#include <cerrno>
#include <cstdint>
#include <ctime>

namespace sqmap::device {

inline constexpr std::int64_t k_second = 1'000'000'000;  ///< ns

[[nodiscard]] inline std::int64_t clock_ns(clockid_t clock = CLOCK_MONOTONIC) noexcept
{
    timespec t{};
    clock_gettime(clock, &t);
    return t.tv_sec * k_second + t.tv_nsec;
}

/// Sleeps until a time of CLOCK_MONOTONIC; signals do not end the sleep.
inline void sleep_until(std::int64_t ns) noexcept
{
    const timespec t{ns / k_second, ns % k_second};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
    }
}

}  // namespace sqmap::device
