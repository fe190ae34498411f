#include "device/jitter.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace sqmap::device {
namespace {

TEST(Jitter, QuantilesAreObservedValues)
{
    std::vector<double> v;
    for (int i = 1; i <= 1000; ++i) v.push_back(i);
    EXPECT_EQ(quantile(v, 0.5), 500);
    EXPECT_EQ(quantile(v, 0.99), 990);
    EXPECT_EQ(quantile(v, 0.999), 999);
    EXPECT_EQ(quantile(v, 1), 1000);
    EXPECT_EQ(quantile(v, 0), 1);
    EXPECT_EQ(quantile({7}, 0.5), 7);
}

TEST(Jitter, ALoopIsNeverEarlyAndItsFiguresAreInOrder)
{
    const Jitter j = *measure_jitter({.seconds = 0.2});
    EXPECT_EQ(j.ticks, 200u);
    EXPECT_GE(j.p50, 0);
    EXPECT_LE(j.p50, j.p99);
    EXPECT_LE(j.p99, j.p999);
    EXPECT_LE(j.p999, j.max);
    EXPECT_EQ(j.late > 0, j.max > 1e-3);
    EXPECT_THROW((void)measure_jitter({.seconds = 0}), std::invalid_argument);
    EXPECT_THROW((void)measure_jitter({.period = 1}), std::invalid_argument);
    EXPECT_THROW((void)measure_jitter({.priority = 100}), std::invalid_argument);
}

TEST(Jitter, IsJudgedByLateTicksAndTail)
{
    EXPECT_EQ(judge({.ticks = 10000, .p999 = 0.2e-3, .late = 9}), Holds::Steadily);
    EXPECT_EQ(judge({.ticks = 10000, .p999 = 0.6e-3, .late = 0}), Holds::Mostly);
    EXPECT_EQ(judge({.ticks = 10000, .p999 = 2e-3, .late = 99}), Holds::Mostly);
    EXPECT_EQ(judge({.ticks = 10000, .p999 = 2e-3, .late = 100}), Holds::Not);
}

TEST(Jitter, AdviceFitsTheMachine)
{
    const Jitter good{.ticks = 10000, .p999 = 1e-4, .late = 0}, bad{.ticks = 10000, .p999 = 5e-3, .late = 500};
    const Machine rt{.kernel = "6", .preemption = "PREEMPT_RT", .governor = "performance", .processors = 1, .load = 0};
    EXPECT_TRUE(advice(rt, good, good).empty());
    ASSERT_EQ(advice(rt, bad, good).size(), 1u);
    EXPECT_NE(advice(rt, bad, good)[0].find("SCHED_FIFO"), std::string::npos);
    EXPECT_NE(advice(rt, bad, {})[0].find("limits.d"), std::string::npos);
    const Machine busy{
        .kernel = "6", .preemption = "PREEMPT", .governor = "powersave", .processors = 2, .virtual_machine = true, .load = 3};
    EXPECT_EQ(advice(busy, bad, {}).size(), 6u);
}

}  // namespace
}  // namespace sqmap::device
