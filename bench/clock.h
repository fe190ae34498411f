// Clocks of measurements, and the time of one frame: the time-stamp counter, corrected by the thread's CPU clock.
#pragma once

#include <cstdint>

namespace sqmap::bench {

[[nodiscard]] double thread_seconds();   ///< CPU time of this thread
[[nodiscard]] double process_seconds();  ///< CPU time of all threads

/// Times intervals from a fraction of a microsecond upwards. The time-stamp counter is read next to the work, so that the
/// clocks cost nothing of what they measure; the thread's CPU time is read around it and replaces the counter's interval
/// where that is longer, that is, where the thread was off its core.
class FrameClock {
public:
    struct Mark {
        std::uint64_t ticks;
        std::int64_t cpu_ns;
    };

    /// Calibrates the counter against the monotonic clock and measures what an empty interval reads. Cost: 60 ms.
    FrameClock();

    [[nodiscard]] static Mark start();
    /// Microseconds of CPU time since the mark, less the reading of an empty interval.
    [[nodiscard]] double stop_us(Mark mark) const;

private:
    double us_per_tick_ = 0, empty_us_ = 0, empty_cpu_us_ = 0;
};

}  // namespace sqmap::bench
