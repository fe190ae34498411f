// CPU time of the calling thread.
#pragma once

#include <ctime>

namespace sqmap::sim {

inline double cpu_seconds() noexcept
{
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace sqmap::sim
