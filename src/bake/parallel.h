// Work on several threads whose result does not depend on how many.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace sqmap::bake {

/// 0: one a core.
[[nodiscard]] inline unsigned thread_count(unsigned threads)
{
    return threads > 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
}

/// Calls work(i) for i in [0, count); results go where i says, so order does not matter.
/// The exception of the lowest i is thrown on.
template <class Work>
void parallel_for(std::size_t count, unsigned threads, Work&& work)
{
    std::atomic<std::size_t> next{0};
    std::vector<std::exception_ptr> errors(count);
    const auto run = [&] {
        for (std::size_t i = next++; i < count; i = next++) {
            try {
                work(i);
            } catch (...) {
                errors[i] = std::current_exception();
            }
        }
    };
    {
        std::vector<std::jthread> pool;
        for (unsigned t = 1; t < std::min<std::size_t>(thread_count(threads), count); ++t) pool.emplace_back(run);
        run();
    }
    for (const std::exception_ptr& e : errors)
        if (e) std::rethrow_exception(e);
}

}  // namespace sqmap::bake
