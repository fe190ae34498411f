#include "clock.h"

#include "math/percentile.h"

#include <algorithm>
#include <ctime>
#if defined(__x86_64__)
#include <x86intrin.h>
#endif

namespace sqmap::bench {
namespace {

std::int64_t nanoseconds(clockid_t clock)
{
    timespec t{};
    clock_gettime(clock, &t);
    return std::int64_t{1'000'000'000} * t.tv_sec + t.tv_nsec;
}

std::uint64_t ticks()
{
#if defined(__x86_64__)
    // The fences keep work of the frame from moving across the reading.
    _mm_lfence();
    const std::uint64_t t = __rdtsc();
    _mm_lfence();
    return t;
#else
    return static_cast<std::uint64_t>(nanoseconds(CLOCK_MONOTONIC_RAW));
#endif
}

}  // namespace

double thread_seconds() { return 1e-9 * static_cast<double>(nanoseconds(CLOCK_THREAD_CPUTIME_ID)); }
double process_seconds() { return 1e-9 * static_cast<double>(nanoseconds(CLOCK_PROCESS_CPUTIME_ID)); }

FrameClock::FrameClock()
{
    const std::int64_t t0 = nanoseconds(CLOCK_MONOTONIC_RAW);
    const std::uint64_t c0 = ticks();
    std::int64_t t1 = t0;
    while (t1 - t0 < 60'000'000) t1 = nanoseconds(CLOCK_MONOTONIC_RAW);
    us_per_tick_ = 1e-3 * static_cast<double>(t1 - t0) / static_cast<double>(ticks() - c0);
    std::vector<double> by_counter(1001), by_cpu(1001);
    for (std::size_t i = 0; i < by_counter.size(); ++i) {
        const Mark mark = start();
        const std::uint64_t now = ticks();
        by_cpu[i] = 1e-3 * static_cast<double>(nanoseconds(CLOCK_THREAD_CPUTIME_ID) - mark.cpu_ns);
        by_counter[i] = us_per_tick_ * static_cast<double>(now - mark.ticks);
    }
    empty_us_ = percentile(by_counter, 50);
    empty_cpu_us_ = percentile(by_cpu, 50);
}

FrameClock::Mark FrameClock::start()
{
    const std::int64_t cpu = nanoseconds(CLOCK_THREAD_CPUTIME_ID);
    return {ticks(), cpu};
}

double FrameClock::stop_us(Mark mark) const
{
    const std::uint64_t now = ticks();
    const double cpu = 1e-3 * static_cast<double>(nanoseconds(CLOCK_THREAD_CPUTIME_ID) - mark.cpu_ns);
    const double counter = us_per_tick_ * static_cast<double>(now - mark.ticks);
    return std::max(0.0, counter > cpu ? cpu - empty_cpu_us_ : counter - empty_us_);
}

}  // namespace sqmap::bench
