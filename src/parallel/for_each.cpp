#include "parallel/for_each.h"

#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace sqmap::parallel {

unsigned thread_count(unsigned threads) noexcept
{
    return threads > 0 ? threads : std::max(1u, std::thread::hardware_concurrency());
}

void detail::run(std::size_t count, unsigned threads, void (*work)(void* context, std::size_t index), void* context)
{
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    std::exception_ptr error;
    std::size_t error_index = count;
    const auto loop = [&] {
        for (std::size_t i = next++; i < count; i = next++) {
            try {
                work(context, i);
            } catch (...) {
                const std::lock_guard lock(mutex);
                if (i < error_index) {
                    error_index = i;
                    error = std::current_exception();
                }
            }
        }
    };
    std::vector<std::thread> pool;
    const std::size_t wanted = std::min<std::size_t>(thread_count(threads), count);
    pool.reserve(wanted);
    try {
        for (std::size_t t = 1; t < wanted; ++t) pool.emplace_back(loop);
    } catch (const std::system_error&) {
        // As many as the system gives: a browser's page has one.
    }
    loop();
    for (std::thread& thread : pool) thread.join();
    if (error) std::rethrow_exception(error);
}

}  // namespace sqmap::parallel
