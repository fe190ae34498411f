// Loops on several threads whose results do not depend on how many there are.
#pragma once

#include "sqmap/math/assert.h"

#include <algorithm>
#include <cstddef>
#include <type_traits>

namespace sqmap::parallel {

/// Number of threads that a setting stands for: itself, or one per core for 0. At least 1. Thread-safe.
[[nodiscard]] unsigned thread_count(unsigned threads) noexcept;

/// The half-open range [first, first + count) of indices.
struct Slice {
    std::size_t first = 0, count = 0;
};

namespace detail {
void run(std::size_t count, unsigned threads, void (*work)(void* context, std::size_t index), void* context);
}

/// Calls work(i) once for each i in [0, count), on the calling thread and up to `threads` - 1 others (0: one thread per
/// core). The calls run in any order and at the same time, so work(i) may write only what belongs to i; then the results
/// are the same, to the bit, for every number of threads. Returns when all calls have returned.
/// @throw what work throws: the exception of the lowest i, after all calls
/// Cost: starts and joins the threads each time, some 20 us a thread: for work of milliseconds, not for a tick.
/// Thread-safe, and work may itself call for_each.
template <class Work>
void for_each(std::size_t count, unsigned threads, Work&& work)
{
    using Function = std::remove_reference_t<Work>;
    detail::run(
        count, threads, [](void* context, std::size_t i) { (*static_cast<Function*>(context))(i); },
        const_cast<void*>(static_cast<const void*>(&work)));
}

/// Calls work(slice) once for each slice of [0, count): slices of `size` indices in order, the last may be shorter. Where
/// they begin depends on count and size alone, never on the number of threads; otherwise as for_each. For functions of the
/// runtime that take spans: give each slice its part of the spans and a workspace of its own.
/// @pre size > 0
template <class Work>
void for_slices(std::size_t count, std::size_t size, unsigned threads, Work&& work)
{
    SQMAP_ASSERT(size > 0);
    for_each((count + size - 1) / size, threads, [&](std::size_t i) { work(Slice{i * size, std::min(size, count - i * size)}); });
}

}  // namespace sqmap::parallel
