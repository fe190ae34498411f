#include "device/channel.h"

#include "device/threaded.h"

#include <gtest/gtest.h>

#include <limits>
#include <thread>

namespace sqmap::device {
namespace {

const Wrench k_push{{1, 2, 3}, {4, 5, 6}};

TEST(Channel, ReadIsFalseUntilPublishedAndAfterLoss)
{
    Channel channel;
    Sample sample;
    sample.buttons = 7;
    EXPECT_FALSE(channel.read(sample));
    EXPECT_EQ(sample.buttons, 7u) << "a failed read leaves the sample";
    Sample fresh;
    fresh.buttons = 1;
    channel.publish(fresh);
    EXPECT_TRUE(channel.read(sample));
    EXPECT_EQ(sample.buttons, 1u);
    EXPECT_EQ(sample.sequence, 1u);
    EXPECT_TRUE(channel.read(sample)) << "the newest reading stays readable";
    EXPECT_EQ(sample.sequence, 1u) << "and is known as stale by its number";
    channel.lose();
    EXPECT_FALSE(channel.read(sample));
    EXPECT_FALSE(channel.write({}));
    channel.publish(fresh);
    EXPECT_TRUE(channel.read(sample));
    EXPECT_EQ(sample.sequence, 2u);
}

TEST(Channel, OutputIsTheNewestWrenchAndNoneBeforeTheFirst)
{
    Channel channel;
    EXPECT_EQ(channel.output(now())[0], Wrench{});
    const Wrench two[] = {k_push, 2 * k_push};
    channel.write(two);
    EXPECT_EQ(channel.output(now())[0], two[0]);
    EXPECT_EQ(channel.output(now())[1], two[1]);
    EXPECT_EQ(channel.output(now())[2], Wrench{});
    channel.write({two + 1, 1});
    EXPECT_EQ(channel.output(now())[0], two[1]);
    EXPECT_EQ(channel.output(now())[1], Wrench{});
}

TEST(Channel, ZeroCancelsWhatWasWrittenAndNotWhatFollows)
{
    Channel channel;
    channel.write({&k_push, 1});
    channel.zero();
    EXPECT_EQ(channel.output(now())[0], Wrench{});
    channel.zero();
    EXPECT_EQ(channel.output(now())[0], Wrench{});
    channel.write({&k_push, 1});
    EXPECT_EQ(channel.output(now())[0], k_push);
}

TEST(Channel, AnOldWrenchIsNotExerted)
{
    Channel channel;
    channel.write({&k_push, 1});
    const double time = now();
    EXPECT_EQ(channel.output(time)[0], k_push);
    EXPECT_EQ(channel.output(time + k_wrench_timeout + 1e-6)[0], Wrench{});
}

TEST(Channel, AWrenchThatIsNotFiniteIsNotExerted)
{
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        Channel channel;
        const Wrench wrenches[] = {{{0, bad, 0}, {}}, k_push, {{1, 1, 1}, {0, 0, bad}}};
        channel.write(wrenches);
        EXPECT_EQ(channel.output(now())[0], Wrench{});
        EXPECT_EQ(channel.output(now())[1], k_push);
        EXPECT_EQ(channel.output(now())[2], Wrench{});
    }
}

TEST(Channel, MoreZonesThanThereAreAreLeftOut)
{
    Channel channel;
    const std::vector<Wrench> many(k_max_zones + 5, k_push);
    channel.write(many);
    EXPECT_EQ(channel.output(now())[k_max_zones - 1], k_push);
}

// Readings are whole and never go back, wrenches likewise, while a third thread zeroes: for the thread sanitizer too.
TEST(Channel, ThreadsSeeWholeValuesInOrder)
{
    constexpr int k_count = 20000;
    Channel channel;
    std::atomic<bool> done{false};
    std::thread hardware([&] {
        double newest = 0;
        for (int i = 1; i <= k_count; ++i) {
            Sample sample;
            sample.time = i;
            for (Pose& pose : sample.poses) pose.translation = {double(i), double(i), double(i)};
            channel.publish(sample);
            const auto& out = channel.output(now());
            EXPECT_EQ(out[0].force, out[k_max_zones - 1].force);
            if (out[0].force.x == 0) continue;  // before the first, or zeroed
            EXPECT_GE(out[0].force.x, newest);
            newest = out[0].force.x;
        }
        done = true;
    });
    std::thread watchdog([&] {
        while (!done) {
            channel.zero();
            std::this_thread::yield();
        }
    });
    Sample sample;
    double newest = 0;
    for (double value = 1; !done; ++value) {
        const std::vector<Wrench> wrenches(k_max_zones, Wrench{{value, value, value}, {}});
        channel.write(wrenches);
        if (!channel.read(sample)) continue;
        EXPECT_GE(sample.time, newest);
        newest = sample.time;
        EXPECT_EQ(sample.time, static_cast<double>(sample.sequence));
        EXPECT_EQ(sample.poses.front().translation, sample.poses.back().translation);
        EXPECT_EQ(sample.poses.front().translation.x, sample.time);
    }
    hardware.join();
    watchdog.join();
    ASSERT_TRUE(channel.read(sample));
    EXPECT_EQ(sample.time, k_count) << "the last reading arrives";
}

TEST(Quaternion, GivesTheRotationAndRefusesWhatIsNone)
{
    Mat3d r;
    const double h = std::sqrt(0.5);
    ASSERT_TRUE(unit_rotation(h, 0, 0, h, r));  // a quarter turn about z
    EXPECT_NEAR(norm(r * Vec3d{1, 0, 0} - Vec3d{0, 1, 0}), 0, 1e-15);
    EXPECT_NEAR(norm(r * Vec3d{0, 0, 1} - Vec3d{0, 0, 1}), 0, 1e-15);
    EXPECT_TRUE(unit_rotation(1.0005, 0, 0, 0, r));
    EXPECT_EQ(r, Mat3d{});
    EXPECT_FALSE(unit_rotation(1.1, 0, 0, 0, r));
    EXPECT_FALSE(unit_rotation(0, 0, 0, 0, r));
    EXPECT_FALSE(unit_rotation(std::nan(""), 0, 0, 1, r));
}

}  // namespace
}  // namespace sqmap::device
