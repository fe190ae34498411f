// The server as a hostile browser meets it: bytes on a socket, nothing of Beast in between.
#include "viewer/server/http/server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace sqmap::viewer {
namespace {

/// Echoes; "bad" is a message that it refuses.
class Echo final : public Application {
public:
    Server* server = nullptr;
    std::atomic<int> opened{0}, closed{0}, texts{0}, requests{0};
    std::set<ConnectionId> open;

    void on_http(HttpRequest request, Answer answer) override
    {
        ++requests;
        answer({.body = request.method + " " + std::string(path_of(request.target)) + " " + std::to_string(request.body.size())});
    }
    void on_open(ConnectionId c) override { ++opened, open.insert(c); }
    bool on_text(ConnectionId c, std::string_view text) override
    {
        ++texts;
        if (text == "bad") return false;
        if (text == "flood") {
            const auto bytes = std::make_shared<const std::string>(1 << 20, 'x');
            for (int i = 0; i < 64; ++i) server->send_binary(c, bytes, false);
            return true;
        }
        server->send_text(c, std::string(text));
        return true;
    }
    void on_close(ConnectionId c) override { ++closed, open.erase(c); }
    void on_frame() override {}
};

class Wire {
public:
    explicit Wire(std::uint16_t port) : fd_(::socket(AF_INET, SOCK_STREAM, 0))
    {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        const timeval patience{10, 0};
        ::setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        ::setsockopt(fd_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
        connected_ = ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    }
    ~Wire() { ::close(fd_); }
    Wire(const Wire&) = delete;
    Wire& operator=(const Wire&) = delete;
    [[nodiscard]] bool connected() const { return connected_; }

    void send(const std::string& bytes) { (void)!::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
    /// Reads until `end` has come, or the other side has closed.
    std::string read_until(const std::string& end)
    {
        char c[4096];
        while (end.empty() || got_.find(end) == std::string::npos) {
            const ssize_t n = ::recv(fd_, c, sizeof c, 0);
            if (n <= 0) break;
            got_.append(c, static_cast<std::size_t>(n));
        }
        return got_;
    }
    /// True where the other side closes within the patience.
    bool closes()
    {
        char c[4096];
        for (;;) {
            const ssize_t n = ::recv(fd_, c, sizeof c, 0);
            if (n == 0) return true;
            if (n < 0) return errno == ECONNRESET;
        }
    }

private:
    int fd_;
    bool connected_ = false;
    std::string got_;
};

class ServerTest : public testing::Test {
protected:
    ServerTest()
    {
        options.token = "00112233445566778899aabbccddeeff";
        options.max_upload = 1 << 20;
        options.max_waiting = 8 << 20;
    }
    void serve()
    {
        server = std::make_unique<Server>(echo, options);
        echo.server = server.get();
        thread = std::thread([this] { server->run(); });
    }
    ~ServerTest() override
    {
        if (server) server->stop();
        if (thread.joinable()) thread.join();
        server.reset();
    }
    [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(server->port()); }
    [[nodiscard]] std::string head(const std::string& line, const std::string& more = "") const
    {
        return line + " HTTP/1.1\r\nHost: " + host() + "\r\n" + more + "\r\n";
    }
    [[nodiscard]] std::string upgrade(const std::string& origin, const std::string& token) const
    {
        return head("GET /ws?token=" + token, "Origin: " + origin +
                                                  "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                                                  "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n");
    }
    std::string status_of(const std::string& bytes)
    {
        Wire wire(server->port());
        wire.send(bytes);
        return wire.read_until("\r\n\r\n").substr(0, 12);
    }
    /// A wire with its handshake done.
    std::unique_ptr<Wire> socket()
    {
        auto wire = std::make_unique<Wire>(server->port());
        wire->send(upgrade("http://" + host(), options.token));
        EXPECT_NE(wire->read_until("\r\n\r\n").find("101"), std::string::npos);
        return wire;
    }
    /// A masked frame as browsers send it.
    static std::string frame(unsigned char first, const std::string& payload, bool masked = true)
    {
        std::string out(1, static_cast<char>(first));
        const auto bit = static_cast<unsigned char>(masked ? 0x80 : 0);
        if (payload.size() < 126) {
            out += static_cast<char>(bit | payload.size());
        } else if (payload.size() < 65536) {
            out += static_cast<char>(bit | 126);
            out += static_cast<char>(payload.size() >> 8);
            out += static_cast<char>(payload.size() & 255);
        } else {
            out += static_cast<char>(bit | 127);
            for (int i = 7; i >= 0; --i) out += static_cast<char>((payload.size() >> (8 * i)) & 255);
        }
        const char mask[4] = {1, 2, 3, 4};
        if (masked) out.append(mask, 4);
        for (std::size_t i = 0; i < payload.size(); ++i) out += masked ? static_cast<char>(payload[i] ^ mask[i % 4]) : payload[i];
        return out;
    }
    static constexpr unsigned char k_text = 0x81, k_binary = 0x82;
    /// The application hears of a closed connection a little after the browser does.
    void wait_for_closed(int count)
    {
        for (int i = 0; i < 2000 && echo.closed < count; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
        EXPECT_EQ(echo.closed, count);
    }
    /// The others are served as before.
    void expect_alive(Wire& other)
    {
        other.send(frame(k_text, "still-here"));
        EXPECT_NE(other.read_until("still-here").find("still-here"), std::string::npos);
    }

    Echo echo;
    ServerOptions options;
    std::unique_ptr<Server> server;
    std::thread thread;
};

TEST_F(ServerTest, AnswersThePrintedAddress)
{
    serve();
    EXPECT_EQ(server->url(), "http://" + host() + "/?token=" + options.token);
    EXPECT_EQ(status_of(head("GET /?token=" + options.token)), "HTTP/1.1 200");
}

TEST_F(ServerTest, RefusesWrongHostOriginAndToken)
{
    serve();
    EXPECT_EQ(status_of("GET /?token=" + options.token + " HTTP/1.1\r\nHost: evil.example\r\n\r\n"), "HTTP/1.1 403");
    EXPECT_EQ(status_of("GET /?token=" + options.token + " HTTP/1.1\r\n\r\n"), "HTTP/1.1 403");
    EXPECT_EQ(status_of("GET /?token=" + options.token + " HTTP/1.1\r\nHost: " + host() + "\r\nHost: evil.example\r\n\r\n"),
              "HTTP/1.1 403");
    EXPECT_EQ(status_of(head("GET /?token=" + options.token, "Origin: http://evil.example\r\n")), "HTTP/1.1 403");
    EXPECT_EQ(status_of(head("GET /?token=wrong")), "HTTP/1.1 403");
    EXPECT_EQ(status_of(head("GET /")), "HTTP/1.1 403");
    EXPECT_EQ(status_of(upgrade("http://evil.example", options.token)), "HTTP/1.1 403");
    EXPECT_EQ(status_of(upgrade("http://" + host(), "wrong")), "HTTP/1.1 403");
    EXPECT_EQ(status_of(head("POST /api/upload?token=" + options.token, "Content-Length: 0\r\n")), "HTTP/1.1 403");
    EXPECT_EQ(echo.requests, 0);
    EXPECT_EQ(echo.opened, 0);
}

TEST_F(ServerTest, ListensOnTheLoopbackInterfaceAlone)
{
    serve();
    // Another address of the loopback network reaches a socket bound to every interface, not one bound to 127.0.0.1.
    const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(server->port());
    ASSERT_EQ(::inet_pton(AF_INET, "127.0.0.2", &address.sin_addr), 1);
    EXPECT_NE(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(fd);
}

TEST_F(ServerTest, RefusesAnUploadThatIsTooLargeBeforeItComes)
{
    serve();
    EXPECT_EQ(status_of(head("POST /api/upload?token=" + options.token,
                             "Origin: http://" + host() + "\r\nContent-Length: 99999999999\r\n")),
              "HTTP/1.1 413");
    const std::string chunked =
        head("POST /api/upload?token=" + options.token, "Origin: http://" + host() + "\r\nTransfer-Encoding: chunked\r\n");
    EXPECT_EQ(status_of(chunked + "200000\r\n" + std::string(0x200000, 'x') + "\r\n0\r\n\r\n"), "HTTP/1.1 413");
    EXPECT_EQ(echo.requests, 0);
}

TEST_F(ServerTest, TakesAnUploadWithinTheLimit)
{
    serve();
    Wire wire(server->port());
    wire.send(head("POST /api/upload?token=" + options.token, "Origin: http://" + host() + "\r\nContent-Length: 1000\r\n") +
              std::string(1000, 'x'));
    EXPECT_NE(wire.read_until("POST /api/upload 1000").find("POST /api/upload 1000"), std::string::npos);
}

TEST_F(ServerTest, SurvivesWhatIsNoRequest)
{
    serve();
    const auto other = socket();
    for (const std::string& bytes :
         {std::string("\r\n\r\n\r\n"), std::string("GET\r\n\r\n"), std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc", 9),
          std::string(200000, 'A') + "\r\n\r\n", std::string("GET / HTTP/9.9\r\n\r\n"),
          head("GET /?token=" + options.token, "X: " + std::string(100000, 'x') + "\r\n"),
          head("BREW /?token=" + options.token, "Origin: http://" + host() + "\r\n")}) {
        Wire wire(server->port());
        wire.send(bytes);
        wire.read_until("\r\n\r\n");
    }
    expect_alive(*other);
}

TEST_F(ServerTest, EchoesOnASocketThatItGranted)
{
    serve();
    const auto wire = socket();
    wire->send(frame(k_text, "hello"));
    EXPECT_NE(wire->read_until("hello").find("hello"), std::string::npos);
}

TEST_F(ServerTest, HostileFramesCloseTheirOwnConnectionOnly)
{
    options.max_messages_a_second = 50;
    serve();
    const auto other = socket();
    std::string many;
    for (int i = 0; i < 60; ++i) many += frame(k_text, "x");
    const std::vector<std::pair<const char*, std::string>> hostile{
        {"too long", frame(k_text, std::string(64 * 1024 + 1, 'x'))},
        {"a length of 2^63", std::string("\x81\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01\x02\x03\x04", 14)},
        {"not masked", frame(k_text, "hello", false)},
        {"binary", frame(k_binary, "hello")},
        {"no UTF-8", frame(k_text, "\xff\xfe\xfd")},
        {"reserved bits", frame(0xf1, "hello")},
        {"reserved opcode", frame(0x83, "hello")},
        {"a continuation of nothing", frame(0x80, "hello")},
        {"a ping that is too long", frame(0x89, std::string(126, 'x'))},
        {"a close of one byte", frame(0x88, "x")},
        {"refused by the application", frame(k_text, "bad")},
        {"too many", many},
        {"pieces without end", frame(0x01, std::string(40000, 'x')) + frame(0x00, std::string(40000, 'x'))},
    };
    for (const auto& [what, bytes] : hostile) {
        const auto wire = socket();
        wire->send(bytes);
        EXPECT_TRUE(wire->closes()) << what;
        expect_alive(*other);
    }
    wait_for_closed(static_cast<int>(hostile.size()));
}

TEST_F(ServerTest, LetsGoOfABrowserThatDoesNotRead)
{
    serve();
    const auto other = socket();
    const auto wire = socket();
    wire->send(frame(k_text, "flood"));
    EXPECT_TRUE(wire->closes());
    expect_alive(*other);
    wait_for_closed(1);
}

TEST_F(ServerTest, HoldsNoMoreConnectionsThanAllowedAndGetsThemBack)
{
    options.max_connections = 4;
    serve();
    for (int round = 0; round < 25; ++round) {
        std::vector<std::unique_ptr<Wire>> wires;
        for (int i = 0; i < 4; ++i) wires.push_back(socket());
        Wire fifth(server->port());
        EXPECT_TRUE(fifth.closes());
        for (const auto& wire : wires) wire->send(frame(0x88, ""));
        for (const auto& wire : wires) EXPECT_TRUE(wire->closes());
        wires.clear();
        wait_for_closed(4 * (round + 1));
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
}

TEST_F(ServerTest, ConnectionsThatSendNoRequestKeepNobodyOut)
{
    serve();
    std::vector<std::unique_ptr<Wire>> idle;
    for (int i = 0; i < 200; ++i) {
        idle.push_back(std::make_unique<Wire>(server->port()));
        if (i % 2 == 0) idle.back()->send("GET / HTTP/1.1\r\nHost:");
    }
    const auto began = std::chrono::steady_clock::now();
    EXPECT_EQ(status_of(head("GET /?token=" + options.token)), "HTTP/1.1 200");
    EXPECT_NO_THROW((void)socket());
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(2));
    // The oldest had to go; the newest still may send.
    EXPECT_TRUE(idle.front()->closes());
}

TEST_F(ServerTest, AConnectionWithoutARequestIsClosedAfterItsTime)
{
    options.head_seconds = 1;
    serve();
    Wire slow(server->port());
    slow.send("GET /?tok");
    const auto began = std::chrono::steady_clock::now();
    EXPECT_TRUE(slow.closes());
    EXPECT_GE(std::chrono::steady_clock::now() - began, std::chrono::milliseconds(900));
}

TEST_F(ServerTest, SaysThatAPortIsTaken)
{
    serve();
    ServerOptions same = options;
    same.port = server->port();
    Echo second;
    EXPECT_THROW(Server(second, same), std::system_error);
}

}  // namespace
}  // namespace sqmap::viewer
