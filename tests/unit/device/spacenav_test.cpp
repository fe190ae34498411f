// SpaceNavigator through the real libspnav, against a daemon of ours that speaks its protocol of eight integers a message.
#include "sqmap/device/open.h"
#include "support/within.h"

#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>

namespace sqmap::device {
namespace {

using namespace std::chrono_literals;
using test::within;

class Daemon {
public:
    explicit Daemon(const std::string& path) : path_(path)
    {
        ::unlink(path.c_str());
        listening_ = ::socket(AF_UNIX, SOCK_STREAM, 0);
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
        EXPECT_EQ(::bind(listening_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << path;
        ::listen(listening_, 1);
    }
    ~Daemon()
    {
        hang_up();
        ::close(listening_);
        ::unlink(path_.c_str());
    }
    void accept() { client_ = ::accept(listening_, nullptr, nullptr); }
    void hang_up()
    {
        if (client_ >= 0) ::close(client_);
        client_ = -1;
    }
    void say(const std::array<int, 8>& message) const
    {
        EXPECT_EQ(::send(client_, message.data(), sizeof message, MSG_NOSIGNAL), 32);
    }
    void move(int x, int y, int z, int rx = 0, int ry = 0, int rz = 0) const { say({0, x, y, z, rx, ry, rz, 16}); }
    void button(int number, bool press) const { say({press ? 1 : 2, number}); }

private:
    std::string path_;
    int listening_ = -1, client_ = -1;
};

class Spacenav : public ::testing::Test {
protected:
    void SetUp() override
    {
        path_ = (std::filesystem::temp_directory_path() / ("sqmap-spnav-" + std::to_string(::getpid()))).string();
        ::setenv("SPNAV_SOCKET", path_.c_str(), 1);
    }
    void TearDown() override { ::unlink(path_.c_str()); }
    std::unique_ptr<Device> open(Daemon& daemon, const char* spec = "spacenav:speed=0.1,turn=2")
    {
        std::thread accepting([&] { daemon.accept(); });
        auto device = open_device(spec);
        accepting.join();
        return device;
    }
    std::string path_;
};

TEST_F(Spacenav, DeflectionIsSpeed)
{
    Daemon daemon(path_);
    const auto device = open(daemon);
    EXPECT_TRUE(device->capabilities().rotates_in);
    EXPECT_FALSE(device->capabilities().force_out || device->capabilities().rumble_out || device->capabilities().simulated);
    Sample sample;
    ASSERT_TRUE(device->read(sample));
    EXPECT_EQ(sample.poses[0].translation, Vec3d{});
    daemon.move(350, 0, -175);
    ASSERT_TRUE(within(5s, [&] { return device->read(sample) && sample.twists[0].linear.x > 0; }));
    EXPECT_TRUE(sample.has_twist);
    EXPECT_DOUBLE_EQ(sample.twists[0].linear.x, 0.1);
    EXPECT_DOUBLE_EQ(sample.twists[0].linear.z, 0.05) << "the daemon's z points away from the user";
    const Sample first = sample;
    ASSERT_TRUE(within(5s, [&] { return device->read(sample) && sample.time > first.time + 0.1; }));
    const Vec3d direction = sample.poses[0].translation - first.poses[0].translation;
    const double time = sample.time - first.time;
    // Time that the thread did not get is not made up for beyond 50 ms, so never farther.
    EXPECT_LE(direction.x, 0.1 * time + 1e-9);
    EXPECT_GT(direction.x, 0.02 * time);
    EXPECT_NEAR(direction.z, 0.5 * direction.x, 1e-12);
    daemon.move(0, 0, 0);
    ASSERT_TRUE(within(5s, [&] { return device->read(sample) && sample.twists[0].linear == Vec3d{}; }));
    const Vec3d rest = sample.poses[0].translation;
    std::this_thread::sleep_for(20ms);
    ASSERT_TRUE(device->read(sample));
    EXPECT_EQ(sample.poses[0].translation, rest) << "the knob springs back, the tool stays";
}

TEST_F(Spacenav, TwistingTurnsTheToolAndKeepsItARotation)
{
    Daemon daemon(path_);
    const auto device = open(daemon);
    daemon.move(0, 0, 0, 0, 350, 0);
    Sample sample;
    ASSERT_TRUE(within(10s, [&] { return device->read(sample) && sample.poses[0].rotation.row[0].x < 0.5; }));
    const Mat3d& r = sample.poses[0].rotation;
    EXPECT_NEAR(norm(r * Vec3d{0, 1, 0} - Vec3d{0, 1, 0}), 0, 1e-9) << "about y";
    EXPECT_GT((r * Vec3d{0, 0, 1}).x, 0) << "right-handed: z goes to x";
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(norm(cross(r.row[i], r.row[(i + 1) % 3]) - r.row[(i + 2) % 3]), 0, 1e-12);
}

TEST_F(Spacenav, ButtonsAreBits)
{
    Daemon daemon(path_);
    const auto device = open(daemon);
    Sample sample;
    daemon.button(1, true);
    daemon.button(0, true);
    daemon.button(99, true);
    EXPECT_TRUE(within(5s, [&] { return device->read(sample) && sample.buttons == 3; }));
    daemon.button(0, false);
    EXPECT_TRUE(within(5s, [&] { return device->read(sample) && sample.buttons == 2; }));
}

TEST_F(Spacenav, ALostDaemonTakesTheDeviceAwayUntilItIsBack)
{
    auto daemon = std::make_unique<Daemon>(path_);
    const auto device = open(*daemon);
    daemon->move(350, 350, 350);
    Sample sample;
    ASSERT_TRUE(within(5s, [&] { return device->read(sample) && sample.twists[0].linear.x > 0; }));
    daemon.reset();
    EXPECT_TRUE(within(5s, [&] { return !device->read(sample); }));
    EXPECT_FALSE(device->write({}));
    Daemon again(path_);
    again.accept();
    EXPECT_TRUE(within(5s, [&] { return device->read(sample); }));
    EXPECT_EQ(sample.twists[0].linear, Vec3d{}) << "what was pressed then is not pressed now";
}

TEST_F(Spacenav, SaysWhereNoDaemonAnswersAndOpensOnce)
{
    EXPECT_THROW((void)open_device("spacenav"), DeviceError);
    Daemon daemon(path_);
    const auto device = open(daemon);
    EXPECT_THROW((void)open_device("spacenav"), DeviceError);
}

}  // namespace
}  // namespace sqmap::device
