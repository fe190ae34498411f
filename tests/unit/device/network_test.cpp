// The network device against a client written from docs/devices.md, byte by byte, with nothing of the device's own code.
#include "device/network.h"

#include "sqmap/haptic/safety.h"
#include "support/within.h"

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <future>
#include <limits>
#include <optional>
#include <random>
#include <thread>

namespace sqmap::device {
namespace {

using namespace std::chrono_literals;
using test::within;
using Bytes = std::vector<unsigned char>;

template <class T>
void put(Bytes& bytes, T value)
{
    const auto* const raw = reinterpret_cast<const unsigned char*>(&value);
    bytes.insert(bytes.end(), raw, raw + sizeof value);
}
template <class T>
T at(const Bytes& bytes, std::size_t offset)
{
    T value{};
    if (offset + sizeof value <= bytes.size()) std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

sockaddr_in loopback(std::uint16_t port)
{
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

std::uint16_t free_port()
{
    const int fd = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in address = loopback(0);
    socklen_t size = sizeof address;
    ::bind(fd, reinterpret_cast<sockaddr*>(&address), size);
    ::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
    ::close(fd);
    return ntohs(address.sin_port);
}

struct Reported {
    std::uint32_t zones = 1, flags = 1 | 2 | 4;
    double rate = 1000, max_force = 3, max_torque = 0.1, continuous = 1, damping = 0.5, friction = 0.1, resolution = 1e-5,
           delay = 0;
};

class Client {
public:
    explicit Client(std::uint16_t port)
    {
        fd_ = ::socket(AF_INET, SOCK_DGRAM, 0);
        const timeval wait{0, 200000};
        ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
        const sockaddr_in address = loopback(port);
        ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    }
    ~Client() { ::close(fd_); }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    void send(const Bytes& bytes) const { (void)!::send(fd_, bytes.data(), bytes.size(), 0); }
    /// Empty where nothing came in 200 ms.
    [[nodiscard]] Bytes receive() const
    {
        Bytes bytes(2048);
        const ssize_t n = ::recv(fd_, bytes.data(), bytes.size(), 0);
        bytes.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
        return bytes;
    }

    static Bytes header(std::uint16_t kind, std::uint64_t sequence, std::uint16_t version = 1)
    {
        Bytes bytes{'S', 'Q', 'M', 'N'};
        put(bytes, version);
        put(bytes, kind);
        put(bytes, sequence);
        return bytes;
    }
    static Bytes hello(const Reported& reported, std::uint16_t version = 1)
    {
        Bytes bytes = header(1, 1, version);
        put(bytes, reported.zones);
        put(bytes, reported.flags);
        for (const double x : {reported.rate, reported.max_force, reported.max_torque, reported.continuous, reported.damping,
                               reported.friction, reported.resolution, reported.delay})
            put(bytes, x);
        Bytes name{'t', 'e', 's', 't', 7};
        name.resize(32);
        bytes.insert(bytes.end(), name.begin(), name.end());
        return bytes;
    }
    Bytes pose(std::uint64_t sequence, double x, std::uint32_t zones = 1) const
    {
        Bytes bytes = header(4, sequence);
        put(bytes, token);
        put(bytes, 0.25);              // its clock
        put(bytes, std::uint32_t{5});  // buttons
        put(bytes, std::uint32_t{0});  // no twist
        for (std::uint32_t z = 0; z < zones; ++z)
            for (const double v : {x, 2 * x, 3.0 + z, std::sqrt(0.5), 0.0, 0.0, std::sqrt(0.5)}) put(bytes, v);
        return bytes;
    }

    /// Until welcomed, or refused: then with the reason.
    std::uint32_t greet(const Reported& reported = {})
    {
        const auto end = std::chrono::steady_clock::now() + 10s;
        while (std::chrono::steady_clock::now() < end) {
            send(hello(reported));
            const Bytes answer = receive();
            if (answer.empty()) std::this_thread::sleep_for(5ms);  // nobody listens yet: that is said at once
            if (at<std::uint16_t>(answer, 6) == 3) return at<std::uint32_t>(answer, 16);
            if (at<std::uint16_t>(answer, 6) != 2) continue;
            EXPECT_EQ(answer.size(), 24u);
            token = at<std::uint64_t>(answer, 16);
            return 0;
        }
        ADD_FAILURE() << "no answer";
        return 99;
    }

    std::uint64_t token = 0;

private:
    int fd_;
};

/// A device with its client, greeted and with one pose sent.
struct Pair {
    explicit Pair(const Reported& reported = {}) : port(free_port()), client(port)
    {
        auto opening = std::async(std::launch::async, [this] { return open_network({.port = port, .wait = 20}); });
        EXPECT_EQ(client.greet(reported), 0u);
        client.send(client.pose(1, 1, reported.zones));
        device = opening.get();
        EXPECT_FALSE(client.receive().empty());
    }
    std::uint16_t port;
    Client client;
    std::unique_ptr<Device> device;
};

Vec3d force_in(const Bytes& wrench, std::size_t zone = 0)
{
    const std::size_t first = 32 + 48 * zone;
    return {at<double>(wrench, first), at<double>(wrench, first + 8), at<double>(wrench, first + 16)};
}

TEST(NetworkDevice, ReportsWhatTheClientSaysOfItself)
{
    Pair pair({.zones = 6, .flags = 2 | 1, .rate = 500, .max_force = 7.5, .delay = 0.002});
    const Capabilities& c = pair.device->capabilities();
    EXPECT_EQ(c.name, "network client 'test?'") << "what does not print is replaced";
    EXPECT_EQ(c.zones, 6u);
    EXPECT_TRUE(c.rotates_in && c.force_out && !c.torque_out && !c.rumble_out && !c.simulated);
    EXPECT_EQ(c.rate, 500);
    EXPECT_EQ(c.max_force, 7.5);
    EXPECT_EQ(c.damping, 0.5);
    EXPECT_DOUBLE_EQ(c.delay, 0.002 + 1.0 / 500) << "a force goes out with the answer to the next pose";
}

TEST(NetworkDevice, PosesComeInAndTheNewestWrenchGoesOut)
{
    Pair pair({.zones = 2});
    Sample sample;
    ASSERT_TRUE(pair.device->read(sample));
    EXPECT_EQ(sample.poses[0].translation, (Vec3d{1, 2, 3}));
    EXPECT_EQ(sample.poses[1].translation, (Vec3d{1, 2, 4}));
    EXPECT_EQ(sample.buttons, 5u);
    EXPECT_NEAR(norm(sample.poses[1].rotation * Vec3d{1, 0, 0} - Vec3d{0, 1, 0}), 0, 1e-15) << "a quarter turn about z";
    const std::uint64_t before = sample.sequence;
    const Wrench wrenches[] = {{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {10, 11, 12}}};
    EXPECT_TRUE(pair.device->write(wrenches));
    pair.client.send(pair.client.pose(2, 5, 2));
    const Bytes answer = pair.client.receive();
    ASSERT_EQ(answer.size(), 32u + 2 * 48);
    EXPECT_EQ(at<std::uint64_t>(answer, 16), 2u) << "names the pose that it came for";
    EXPECT_EQ(at<std::uint32_t>(answer, 24), 2u);
    EXPECT_EQ(force_in(answer, 0), (Vec3d{1, 2, 3}));
    EXPECT_EQ(force_in(answer, 1), (Vec3d{7, 8, 9}));
    EXPECT_EQ(at<double>(answer, 32 + 48 + 40), 12);
    ASSERT_TRUE(pair.device->read(sample));
    EXPECT_EQ(sample.sequence, before + 1);
    EXPECT_EQ(sample.poses[0].translation, (Vec3d{5, 10, 3}));
}

TEST(NetworkDevice, ASilentServoIsAnsweredByNoForce)
{
    Pair pair;
    const Wrench push{{1, 0, 0}, {}};
    pair.device->write({&push, 1});
    std::this_thread::sleep_for(40ms);  // twice the time-out
    pair.client.send(pair.client.pose(2, 1));
    EXPECT_EQ(force_in(pair.client.receive()), Vec3d{});
}

TEST(NetworkDevice, ZeroIsWhatTheClientHearsNext)
{
    Pair pair;
    const Wrench push{{1, 0, 0}, {}};
    pair.device->write({&push, 1});
    pair.device->zero();
    pair.client.send(pair.client.pose(2, 1));
    EXPECT_EQ(force_in(pair.client.receive()), Vec3d{});
}

TEST(NetworkDevice, LateAndRepeatedPosesAreLeftOut)
{
    Pair pair;
    pair.client.send(pair.client.pose(10, 1));
    EXPECT_FALSE(pair.client.receive().empty());
    for (const std::uint64_t sequence : {10, 9, 1}) {
        pair.client.send(pair.client.pose(sequence, 77));
        EXPECT_TRUE(pair.client.receive().empty());
    }
    Sample sample;
    ASSERT_TRUE(pair.device->read(sample));
    EXPECT_EQ(sample.poses[0].translation.x, 1);
}

TEST(NetworkDevice, MalformedMessagesChangeNothing)
{
    Pair pair;
    Sample before, after;
    ASSERT_TRUE(pair.device->read(before));
    const Bytes good = pair.client.pose(100, 9);
    const auto with = [&](std::size_t offset, auto value) {
        Bytes bytes = good;
        std::memcpy(bytes.data() + offset, &value, sizeof value);
        return bytes;
    };
    std::vector<Bytes> bad{with(0, 'X'),
                           with(4, std::uint16_t{2}),
                           with(6, std::uint16_t{9}),
                           with(16, pair.client.token ^ 1),
                           with(36, std::uint32_t{1}),
                           {},
                           {'S', 'Q'},
                           pair.client.pose(100, 9, 2)};
    for (std::size_t size = 0; size < good.size(); size += 5)
        bad.emplace_back(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
    bad.push_back(Bytes(60000, 'S'));
    for (const Bytes& bytes : bad) pair.client.send(bytes);
    std::mt19937 random(1);
    for (int i = 0; i < 500; ++i) {
        Bytes noise = good;
        for (int n = 0; n < 3; ++n)
            noise[random() % 8 + (random() % 2 == 0 ? 0 : 16)] = static_cast<unsigned char>(random());  // all but the sequence
        if (noise != good) pair.client.send(noise);
        if (i % 32 == 0) std::this_thread::sleep_for(2ms);  // room in the socket
    }
    std::this_thread::sleep_for(30ms);
    ASSERT_TRUE(pair.device->read(after));
    EXPECT_EQ(after.sequence, before.sequence);
    while (!pair.client.receive().empty()) {
    }
    pair.client.send(good);
    EXPECT_FALSE(pair.client.receive().empty()) << "and the good one is heard";
}

TEST(NetworkDevice, APoseThatCannotBeIsNoForceAtOnceAndReachesTheFilter)
{
    Pair pair;
    const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
    const std::pair<std::size_t, double> bad[] = {{40, nan}, {48, infinity}, {64, nan}, {64, 2}, {64, 0}, {88, -infinity}};
    const Wrench push[] = {{{1, 0, 0}, {}}};
    haptic::SafetyFilter filter({.max_force = 3, .continuous_force = 3}, {});
    std::vector<Wrench> safe(1);
    haptic::SafetyInput in{.commanded = push};
    Sample sample;
    std::uint64_t sequence = 100;
    const auto filtered = [&] {
        EXPECT_TRUE(pair.device->read(sample));
        in.time += 1e-3;
        in.sample_time = in.time;
        in.sequence = ++sequence;
        in.poses = {sample.poses.data(), 1};
        return filter.tick(in, safe);
    };
    const Wrench none[] = {{}};
    in.commanded = none;
    for (int i = 0; i < 600; ++i) filtered();
    in.commanded = push;
    for (int i = 0; i < 200; ++i) filtered();
    ASSERT_EQ(safe[0].force.x, 1);
    std::uint64_t n = 10;
    for (const auto& [offset, value] : bad) {
        ASSERT_TRUE(pair.device->write(push));
        pair.client.send(pair.client.pose(n++, 1));
        EXPECT_EQ(force_in(pair.client.receive()), (Vec3d{1, 0, 0}));
        Bytes bytes = pair.client.pose(n++, 1);
        std::memcpy(bytes.data() + offset, &value, sizeof value);
        pair.client.send(bytes);
        const Bytes answer = pair.client.receive();
        ASSERT_FALSE(answer.empty()) << offset;
        EXPECT_EQ(force_in(answer), (Vec3d{})) << offset;
        EXPECT_TRUE(filtered().acted & haptic::k_acted_finite) << offset;
        EXPECT_EQ(safe[0], (Wrench{})) << offset;
        pair.client.send(pair.client.pose(n++, 1));
        EXPECT_FALSE(pair.client.receive().empty());
        for (int i = 0; i < 100; ++i) filtered();
        EXPECT_EQ(safe[0].force.x, 1) << "and a good one is felt again";
    }
}

TEST(NetworkDevice, APoseThatCannotBeIsReadOnceWhereAGoodOneHasFollowed)
{
    Pair pair;
    Sample sample;
    ASSERT_TRUE(pair.device->read(sample));
    Bytes bytes = pair.client.pose(2, 1);
    const double nan = std::nan("");
    std::memcpy(bytes.data() + 40, &nan, sizeof nan);
    pair.client.send(bytes);
    EXPECT_FALSE(pair.client.receive().empty());
    pair.client.send(pair.client.pose(3, 4));
    EXPECT_FALSE(pair.client.receive().empty());
    ASSERT_TRUE(pair.device->read(sample));
    EXPECT_TRUE(std::isnan(sample.poses[0].translation.x)) << "or force would set in again at once";
    ASSERT_TRUE(pair.device->read(sample));
    EXPECT_EQ(sample.poses[0].translation.x, 4);
}

TEST(NetworkDevice, ReportsToItsClientWhatTheSafetyFilterDid)
{
    Pair pair;
    EXPECT_TRUE(pair.device->write({}));
    const auto reported = [&](std::uint64_t sequence) {
        pair.client.send(pair.client.pose(sequence, 1));
        return at<std::uint32_t>(pair.client.receive(), 28);
    };
    EXPECT_EQ(reported(2), 0u);
    const std::uint32_t stale = haptic::k_fault_stale << 16 | haptic::k_acted_off;
    pair.device->report(stale);
    EXPECT_EQ(reported(3), 0u) << "of the wrench that goes out, not of the one that will";
    EXPECT_TRUE(pair.device->write({}));
    EXPECT_EQ(reported(4), stale);
    pair.device->report(0);
    EXPECT_TRUE(pair.device->write({}));
    EXPECT_EQ(reported(5), 0u);
    pair.device->zero();
    EXPECT_EQ(reported(6), haptic::k_acted_off) << "cut by a watchdog";
}

TEST(NetworkDevice, AResumeOfItsClientComesWithTheNextPose)
{
    Pair pair;
    const auto resume = [&](std::uint64_t token, bool longer) {
        Bytes bytes = Client::header(7, 0);
        put(bytes, token);
        if (longer) bytes.push_back(0);
        pair.client.send(bytes);
    };
    Sample sample;
    const auto resumes = [&](std::uint64_t sequence) {
        pair.client.send(pair.client.pose(sequence, 1));
        EXPECT_FALSE(pair.client.receive().empty());
        EXPECT_TRUE(pair.device->read(sample));
        return sample.resumes;
    };
    EXPECT_EQ(resumes(2), 0u);
    resume(pair.client.token, false);
    EXPECT_EQ(resumes(3), 1u);
    EXPECT_EQ(resumes(4), 1u);
    resume(pair.client.token + 1, false);
    resume(pair.client.token, true);
    EXPECT_EQ(resumes(5), 1u) << "of somebody else, or malformed";
    resume(pair.client.token, false);
    EXPECT_EQ(resumes(6), 2u);
}

TEST(NetworkDevice, ASecondClientIsRefusedUntilTheFirstSaysGoodbye)
{
    Pair pair;
    Client other(pair.port);
    EXPECT_EQ(other.greet(), 1u);
    Bytes bye = Client::header(6, 2);
    put(bye, pair.client.token);
    pair.client.send(bye);
    Sample sample;
    EXPECT_TRUE(within(1s, [&] { return !pair.device->read(sample); }));
    EXPECT_FALSE(pair.device->write({}));
    EXPECT_EQ(other.greet({.max_force = 99}), 4u) << "another device than the one that was opened";
    EXPECT_EQ(other.greet(), 0u);
    other.send(other.pose(1, 4));
    EXPECT_TRUE(within(1s, [&] { return pair.device->read(sample) && sample.poses[0].translation.x == 4; }));
}

TEST(NetworkDevice, ASilentClientIsGoneAfterASecondAndMayComeBack)
{
    Pair pair;
    Sample sample;
    EXPECT_TRUE(pair.device->read(sample));
    EXPECT_TRUE(within(10s, [&] { return !pair.device->read(sample); }));
    EXPECT_EQ(pair.client.greet(), 0u);
    pair.client.send(pair.client.pose(1, 8));
    EXPECT_TRUE(within(10s, [&] { return pair.device->read(sample) && sample.poses[0].translation.x == 8; }));
}

TEST(NetworkDevice, BadHellosAreRefusedWithTheirReason)
{
    Pair pair;
    Client other(pair.port);
    other.send(Client::hello({}, 2));
    const Bytes version = other.receive();
    EXPECT_EQ(at<std::uint16_t>(version, 6), 3);
    EXPECT_EQ(at<std::uint32_t>(version, 16), 2u);
    EXPECT_EQ(at<std::uint32_t>(version, 20), 1u) << "the version that is spoken";
    for (const Reported& reported : std::vector<Reported>{
             {.zones = 0}, {.zones = 17}, {.rate = 0.5}, {.rate = std::nan("")}, {.max_force = -1}, {.delay = INFINITY}}) {
        EXPECT_EQ(other.greet(reported), 3u);
    }
}

TEST(NetworkDevice, LeavesWithoutForceAndSaysGoodbye)
{
    Pair pair;
    const Wrench push{{1, 0, 0}, {}};
    pair.device->write({&push, 1});
    pair.client.send(pair.client.pose(2, 1));
    EXPECT_EQ(force_in(pair.client.receive()).x, 1);
    pair.device.reset();
    int zeros = 0;
    bool bye = false;
    for (Bytes bytes = pair.client.receive(); !bytes.empty(); bytes = pair.client.receive()) {
        if (at<std::uint16_t>(bytes, 6) == 5) {
            EXPECT_EQ(force_in(bytes), Vec3d{});
            ++zeros;
        }
        bye = at<std::uint16_t>(bytes, 6) == 6;
    }
    EXPECT_EQ(zeros, 3);
    EXPECT_TRUE(bye);
}

TEST(NetworkDevice, NobodyThereIsSaidInTime)
{
    EXPECT_THROW((void)open_network({.port = free_port(), .wait = 0.05}), DeviceError);
    const std::uint16_t port = free_port();
    Client client(port);
    auto opening = std::async(std::launch::async, [&] { return open_network({.port = port, .wait = 20}); });
    EXPECT_EQ(client.greet(), 0u);
    client.send(client.pose(1, 1));
    const auto device = opening.get();
    EXPECT_THROW((void)open_network({.port = port, .wait = 0.05}), DeviceError) << "the port is taken";
}

}  // namespace
}  // namespace sqmap::device
