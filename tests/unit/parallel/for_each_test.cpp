#include "parallel/for_each.h"

#include <gtest/gtest.h>

#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace sqmap::parallel {
namespace {

TEST(ParallelForEach, DoesEveryPieceOnceWhateverTheNumberOfThreads)
{
    for (const unsigned threads : {0u, 1u, 2u, 3u, 7u, 100u})
        for (const std::size_t count : {0u, 1u, 2u, 50u}) {
            std::vector<int> done(count, 0);
            for_each(count, threads, [&](std::size_t i) { ++done[i]; });
            EXPECT_EQ(done, std::vector<int>(count, 1)) << threads << " threads";
        }
}

TEST(ParallelForEach, UsesNoMoreThreadsThanItMay)
{
    for (const unsigned threads : {1u, 2u, 3u}) {
        std::mutex mutex;
        std::set<std::thread::id> seen;
        for_each(200, threads, [&](std::size_t) {
            const std::lock_guard lock(mutex);
            seen.insert(std::this_thread::get_id());
        });
        EXPECT_LE(seen.size(), threads);
    }
}

TEST(ParallelForEach, ThrowsTheFirstPiecesExceptionWithItsMessageOnceAllAreDone)
{
    for (const unsigned threads : {1u, 2u, 7u}) {
        std::vector<int> done(40, 0);
        try {
            for_each(done.size(), threads, [&](std::size_t i) {
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

TEST(ParallelForEach, TakesWorkThatIsAConstant)
{
    std::vector<int> done(10, 0);
    const auto work = [&](std::size_t i) { ++done[i]; };
    for_each(done.size(), 2, work);
    EXPECT_EQ(done, std::vector<int>(10, 1));
}

TEST(ParallelForSlices, SlicesDependOnTheirSizeAndNotOnTheNumberOfThreads)
{
    for (const unsigned threads : {1u, 2u, 7u})
        for (const std::size_t count : {0u, 1u, 15u, 16u, 17u, 100u}) {
            std::mutex mutex;
            std::set<std::pair<std::size_t, std::size_t>> seen;
            std::size_t calls = 0;
            for_slices(count, 16, threads, [&](Slice s) {
                const std::lock_guard lock(mutex);
                seen.insert({s.first, s.count});
                ++calls;
            });
            std::set<std::pair<std::size_t, std::size_t>> expected;
            for (std::size_t first = 0; first < count; first += 16)
                expected.insert({first, std::min<std::size_t>(16, count - first)});
            EXPECT_EQ(seen, expected) << count << " indices, " << threads << " threads";
            EXPECT_EQ(calls, expected.size());
        }
}

}  // namespace
}  // namespace sqmap::parallel
