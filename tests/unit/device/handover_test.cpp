#include "device/handover.h"

#include <gtest/gtest.h>

#include <thread>

namespace sqmap::device {
namespace {

/// Torn when its halves differ.
struct Wide {
    std::array<std::uint64_t, 64> word{};
    static Wide of(std::uint64_t x)
    {
        Wide w;
        w.word.fill(x);
        return w;
    }
    [[nodiscard]] bool whole() const
    {
        for (const std::uint64_t x : word)
            if (x != word[0]) return false;
        return true;
    }
};

constexpr std::uint64_t k_values = 100000;

TEST(Newest, GivesWholeValuesInOrderAndTheLastOneToo)
{
    static Newest<Wide> newest;
    EXPECT_FALSE(newest.take());
    std::thread writer([] {
        for (std::uint64_t i = 1; i <= k_values; ++i) newest.put(Wide::of(i));
    });
    std::uint64_t last = 0, torn = 0, back = 0;
    while (last < k_values) {
        if (!newest.take()) continue;
        torn += !newest.value().whole();
        back += newest.value().word[0] <= last;
        last = newest.value().word[0];
    }
    writer.join();
    EXPECT_EQ(torn, 0u);
    EXPECT_EQ(back, 0u);
    EXPECT_FALSE(newest.take()) << "taken already";
}

TEST(Ring, GivesEveryValueOnceInOrderAndRefusesWhenFull)
{
    static Ring<Wide, 64> ring;
    std::thread writer([] {
        for (std::uint64_t i = 1; i <= k_values;) {
            if (ring.push(Wide::of(i)))
                ++i;
            else
                std::this_thread::yield();
        }
    });
    std::uint64_t expected = 1, wrong = 0;
    while (expected <= k_values) {
        Wide w;
        if (!ring.pop(w)) {
            std::this_thread::yield();
            continue;
        }
        wrong += !w.whole() || w.word[0] != expected;
        ++expected;
    }
    writer.join();
    EXPECT_EQ(wrong, 0u);
    for (std::uint64_t i = 0; i < 64; ++i) EXPECT_TRUE(ring.push(Wide::of(i)));
    EXPECT_FALSE(ring.push(Wide::of(64)));
}

}  // namespace
}  // namespace sqmap::device
