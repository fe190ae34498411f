// Haply's device against a service of ours that speaks its protocol: a state, then nothing until a force was asked for.
#include "device/haply_message.h"
#include "sqmap/device/open.h"
#include "support/within.h"

#include <gtest/gtest.h>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

namespace sqmap::device {
namespace {

using namespace std::chrono_literals;
using test::within;
namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using nlohmann::json;

std::string state(double x, const std::string& id = "0001")
{
    return json{{"inverse3",
                 {{{"device_id", id},
                   {"state",
                    {{"cursor_position", {{"x", x}, {"y", 0.02}, {"z", -0.03}}},
                     {"cursor_velocity", {{"x", 0.1}, {"y", 0.2}, {"z", 0.3}}}}}}}}}
        .dump();
}

/// One connection at a time, on a thread of its own.
class Service {
public:
    /// The text sent as message number n of a connection; empty: the connection is dropped.
    using Script = std::function<std::string(std::uint64_t n)>;

    explicit Service(Script script, unsigned short port = 0)
        : script_(std::move(script)), acceptor_(io_, tcp::endpoint(asio::ip::address_v4::loopback(), port))
    {
        port_ = acceptor_.local_endpoint().port();
        thread_ = std::thread([this] { run(); });
    }
    ~Service()
    {
        stopping_ = true;
        {
            // Wakes accept; a read is woken by the close of the connection.
            asio::io_context io;
            tcp::socket knock(io);
            beast::error_code ignored;
            knock.connect(tcp::endpoint(asio::ip::address_v4::loopback(), port_), ignored);
            const std::lock_guard lock(mutex_);
            if (socket_ != nullptr) ::shutdown(socket_->native_handle(), SHUT_RDWR);
        }
        thread_.join();
    }
    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    [[nodiscard]] std::string spec(const std::string& more = "") const
    {
        return "haply:127.0.0.1,port=" + std::to_string(port_) + more;
    }
    [[nodiscard]] unsigned short port() const { return port_; }
    [[nodiscard]] std::string last_command() const
    {
        const std::lock_guard lock(mutex_);
        return command_;
    }
    /// Nothing before the first command: a device may be open before its first answer is here.
    [[nodiscard]] std::optional<Vec3d> last_force() const
    {
        const std::string command = last_command();
        if (command.empty()) return {};
        const json values = json::parse(command)["inverse3"][0]["commands"]["set_cursor_force"]["values"];
        return Vec3d{values["x"], values["y"], values["z"]};
    }

    std::atomic<std::uint64_t> connections{0}, sent{0}, commands{0};
    std::atomic<bool> closed_properly{false};

private:
    void run()
    {
        while (!stopping_) {
            tcp::socket socket(io_);
            beast::error_code error;
            acceptor_.accept(socket, error);
            if (error || stopping_) continue;
            beast::websocket::stream<tcp::socket, false> ws(std::move(socket));
            {
                const std::lock_guard lock(mutex_);
                socket_ = &ws.next_layer();
            }
            ws.accept(error);
            if (!error) talk(ws);
            const std::lock_guard lock(mutex_);
            socket_ = nullptr;
        }
    }

    void talk(beast::websocket::stream<tcp::socket, false>& ws)
    {
        ++connections;
        for (std::uint64_t n = 0; !stopping_; ++n) {
            const std::string message = script_(n);
            if (message.empty()) return;
            beast::error_code error;
            ws.write(asio::buffer(message), error);
            if (error) return;
            ++sent;
            beast::flat_buffer answer;
            ws.read(answer, error);  // the next state waits for a force
            if (error) {
                closed_properly = error == beast::websocket::error::closed;
                return;
            }
            const std::lock_guard lock(mutex_);
            command_ = beast::buffers_to_string(answer.data());
            ++commands;
        }
    }

    Script script_;
    asio::io_context io_;
    tcp::acceptor acceptor_;
    unsigned short port_ = 0;
    mutable std::mutex mutex_;
    tcp::socket* socket_ = nullptr;
    std::string command_;
    std::atomic<bool> stopping_{false};
    std::thread thread_;
};

template <class Condition>
bool writing(Device& device, const Wrench& wrench, Condition condition)
{
    return within(5s, [&] {
        device.write({&wrench, 1});
        return condition();
    });
}

TEST(HaplyMessage, ReadsStateGripAndButtons)
{
    json message = json::parse(state(0.01));
    message["wireless_verse_grip"] =
        json::array({{{"device_id", "g"},
                      {"state",
                       {{"orientation", {{"w", std::sqrt(0.5)}, {"x", 0}, {"y", 0}, {"z", std::sqrt(0.5)}}},
                        {"buttons", {{"a", true}, {"b", false}, {"c", true}}}}}}});
    const HaplyMessage out = read_haply(message.dump(), "");
    EXPECT_TRUE(out.valid && out.has_state);
    EXPECT_EQ(out.device_id, "0001");
    EXPECT_EQ(out.sample.poses[0].translation, (Vec3d{0.01, 0.02, -0.03}));
    EXPECT_NEAR(norm(out.sample.poses[0].rotation * Vec3d{1, 0, 0} - Vec3d{0, 1, 0}), 0, 1e-15);
    EXPECT_EQ(out.sample.buttons, 5u);
    EXPECT_FALSE(out.sample.has_twist) << "no angular velocity is told";
    const HaplyMessage bare = read_haply(state(0.01), "");
    EXPECT_TRUE(bare.sample.has_twist);
    EXPECT_EQ(bare.sample.twists[0].linear, (Vec3d{0.1, 0.2, 0.3}));
}

TEST(HaplyMessage, PicksTheDeviceThatIsWanted)
{
    json message = json::parse(state(1, "a"));
    message["inverse3"].push_back(json::parse(state(2, "b"))["inverse3"][0]);
    EXPECT_EQ(read_haply(message.dump(), "").device_id, "a");
    EXPECT_EQ(read_haply(message.dump(), "b").sample.poses[0].translation.x, 2);
    EXPECT_EQ(read_haply(message.dump(), "c").device_id, "");
    EXPECT_FALSE(read_haply(message.dump(), "c").has_state);
}

TEST(HaplyMessage, WhatDoesNotReadHasNoState)
{
    for (const char* const text :
         {"", "{", "[]", "7", "null", "{}", R"({"inverse3":7})", R"({"inverse3":[]})", R"({"inverse3":[7]})",
          R"({"inverse3":[{"device_id":7}]})", R"({"inverse3":[{"device_id":"a"}]})",
          R"({"inverse3":[{"device_id":"a","state":[]}]})",
          R"({"inverse3":[{"device_id":"a","state":{"cursor_position":{"x":1,"y":2}}}]})",
          R"({"inverse3":[{"device_id":"a","state":{"cursor_position":{"x":1,"y":2,"z":"3"}}}]})",
          R"({"inverse3":[{"device_id":"a","state":{"cursor_position":{"x":1,"y":2,"z":1e999}}}]})", "\xff\xfe{}"})
        EXPECT_FALSE(read_haply(text, "").has_state) << text;
    EXPECT_FALSE(read_haply(std::string(60000, '['), "").valid) << "nesting does not overflow the stack";
    // A prefix of a good message never has a state.
    const std::string good = state(1);
    for (std::size_t n = 0; n < good.size(); ++n) EXPECT_FALSE(read_haply(good.substr(0, n), "").valid);
}

TEST(HaplyMessage, ForceIsTheDocumentedCommand)
{
    const json command = json::parse(haply_force("0001", {1, -2.5, 0}));
    EXPECT_EQ(
        command,
        json::parse(
            R"({"inverse3":[{"device_id":"0001","commands":{"set_cursor_force":{"values":{"x":1.0,"y":-2.5,"z":0.0}}}}]})"));
    EXPECT_NO_THROW((void)haply_force("\xff", {})) << "an id that is no UTF-8";
}

TEST(Haply, EveryStateIsAnsweredSoThatTheNextOneComes)
{
    Service service([](std::uint64_t n) { return state(1e-4 * static_cast<double>(n)); });
    const auto device = open_device(service.spec(",max-force=3.5"));
    EXPECT_TRUE(device->capabilities().force_out && device->capabilities().rotates_in && !device->capabilities().torque_out);
    EXPECT_EQ(device->capabilities().max_force, 3.5);
    // Nobody writes a wrench: states flow all the same, against no force.
    EXPECT_TRUE(within(10s, [&] { return service.sent > 200; }));
    EXPECT_EQ(service.last_force(), Vec3d{});
    Sample sample;
    ASSERT_TRUE(device->read(sample));
    EXPECT_GT(sample.sequence, 1u);
}

TEST(Haply, ForceGoesOutAndEndsWithZeroAndSilence)
{
    Service service([](std::uint64_t) { return state(0); });
    const auto device = open_device(service.spec());
    const Wrench push{{1, 2, -3}, {}};
    EXPECT_TRUE(writing(*device, push, [&] { return service.last_force() == push.force; }));
    EXPECT_TRUE(within(5s, [&] { return service.last_force() == Vec3d{}; })) << "a servo that writes no more";
    EXPECT_TRUE(writing(*device, push, [&] { return service.last_force() == push.force; }));
    device->zero();
    EXPECT_TRUE(within(5s, [&] { return service.last_force() == Vec3d{}; }));
}

TEST(Haply, TheLastWordIsNoForce)
{
    Service service([](std::uint64_t) { return state(0); });
    auto device = open_device(service.spec());
    const Wrench push{{1, 0, 0}, {}};
    EXPECT_TRUE(writing(*device, push, [&] { return service.last_force() == push.force; }));
    for (int i = 0; i < 5; ++i) device->write({&push, 1});
    device.reset();
    EXPECT_TRUE(within(5s, [&] { return service.closed_properly.load(); }));
    EXPECT_EQ(service.last_force(), Vec3d{});
}

TEST(Haply, ABrokenConnectionIsMadeAgain)
{
    Service service([](std::uint64_t n) { return n < 20 ? state(0.5) : std::string(); });
    const auto device = open_device(service.spec());
    Sample sample;
    bool lost = false;
    EXPECT_TRUE(within(10s, [&] {
        lost = lost || !device->read(sample);
        return lost && service.connections >= 3;
    }));
    EXPECT_TRUE(within(5s, [&] { return device->read(sample); }));
}

TEST(Haply, ServiceThatIsStartedAgainIsFoundAgain)
{
    auto service = std::make_unique<Service>([](std::uint64_t) { return state(1); });
    const unsigned short port = service->port();
    const auto device = open_device(service->spec());
    service.reset();
    Sample sample;
    EXPECT_TRUE(within(5s, [&] { return !device->read(sample); }));
    EXPECT_FALSE(device->write({}));
    Service again([](std::uint64_t) { return state(2); }, port);
    EXPECT_TRUE(within(10s, [&] { return device->read(sample) && sample.poses[0].translation.x == 2; }));
}

TEST(Haply, MalformedMessagesAreAnsweredWithNoForceAndPass)
{
    const std::vector<std::string> bad{"{", "[1,2", "7",
                                       R"({"inverse3":[{"device_id":"0001","state":{"cursor_position":{"x":null}}}]})", "\x01"};
    Service service([&](std::uint64_t n) { return n % 2 == 0 ? state(static_cast<double>(n)) : bad[n / 2 % bad.size()]; });
    const auto device = open_device(service.spec());
    Sample sample;
    EXPECT_TRUE(within(10s, [&] { return device->read(sample) && sample.poses[0].translation.x >= 50; }));
    EXPECT_EQ(service.connections, 1u);
}

TEST(Haply, AMessageBeyondTheBoundEndsTheConnectionOnly)
{
    Service service([](std::uint64_t n) { return n == 3 ? "{\"x\":\"" + std::string(70000, 'a') + "\"}" : state(4); });
    const auto device = open_device(service.spec());
    EXPECT_TRUE(within(10s, [&] { return service.connections >= 2; }));
    Sample sample;
    EXPECT_TRUE(within(5s, [&] { return device->read(sample); }));
}

TEST(Haply, ASilentServiceIsGone)
{
    std::atomic<bool> silent{false};
    Service service([&](std::uint64_t) {
        while (silent) std::this_thread::sleep_for(5ms);
        return state(0);
    });
    const auto device = open_device(service.spec());
    Sample sample;
    ASSERT_TRUE(device->read(sample));
    silent = true;
    EXPECT_TRUE(within(20s, [&] { return !device->read(sample); }));
    silent = false;
    EXPECT_TRUE(within(20s, [&] { return device->read(sample); }));
}

TEST(Haply, SaysWhereNoServiceOrNoDeviceIs)
{
    unsigned short port = 0;
    {
        Service service([](std::uint64_t) { return R"({"inverse3":[]})"; });
        port = service.port();
        EXPECT_THROW((void)open_device(service.spec(",wait=0.3")), DeviceError);
        EXPECT_THROW((void)open_device(service.spec(",wait=0.3,device=absent")), DeviceError);
    }
    EXPECT_THROW((void)open_device("haply:127.0.0.1,wait=0.3,port=" + std::to_string(port)), DeviceError);
}

}  // namespace
}  // namespace sqmap::device
