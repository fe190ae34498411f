#include "bake/parallel.h"

#include <gtest/gtest.h>

#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>

namespace sqmap::bake {
namespace {

TEST(ParallelFor, DoesEveryPieceOnceWhateverTheNumberOfThreads)
{
    for (const unsigned threads : {0u, 1u, 2u, 3u, 7u, 100u})
        for (const std::size_t count : {0u, 1u, 2u, 50u}) {
            std::vector<int> done(count, 0);
            parallel_for(count, threads, [&](std::size_t i) { ++done[i]; });
            EXPECT_EQ(done, std::vector<int>(count, 1)) << threads << " threads";
        }
}

TEST(ParallelFor, UsesNoMoreThreadsThanAskedFor)
{
    for (const unsigned threads : {1u, 2u, 3u}) {
        std::mutex mutex;
        std::set<std::thread::id> seen;
        parallel_for(200, threads, [&](std::size_t) {
            const std::lock_guard lock(mutex);
            seen.insert(std::this_thread::get_id());
        });
        EXPECT_LE(seen.size(), threads);
    }
}

TEST(ParallelFor, ThrowsTheFirstPiecesExceptionWithItsMessageOnceAllAreDone)
{
    for (const unsigned threads : {1u, 2u, 7u}) {
        std::vector<int> done(40, 0);
        try {
            parallel_for(done.size(), threads, [&](std::size_t i) {
                done[i] = 1;
                if (i % 7 == 5) throw std::runtime_error("piece " + std::to_string(i));
            });
            FAIL() << "nothing was thrown";
        } catch (const std::runtime_error& e) {
            EXPECT_STREQ(e.what(), "piece 5");
        }
        EXPECT_EQ(std::accumulate(done.begin(), done.end(), 0), 40);
    }
}

}  // namespace
}  // namespace sqmap::bake
