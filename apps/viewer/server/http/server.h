// HTTP and WebSocket on the loopback interface, one thread: what comes in is checked and bounded, then handed to an Application.
#pragma once

#include "viewer/server/http/request_check.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace sqmap::viewer {

using ConnectionId = std::uint64_t;

struct HttpRequest {
    std::string method, target;
    std::string body;
};

struct HttpReply {
    int status = 200;
    std::string type = "text/plain; charset=utf-8";
    std::string body{};
    std::string file_name{};  ///< where it is to be saved as a file
};

/// May be called once, by any thread.
using Answer = std::function<void(HttpReply)>;

/// The content behind the server. All calls come on the server's thread; admission has been granted before.
class Application {
public:
    virtual ~Application() = default;
    virtual void on_http(HttpRequest request, Answer answer) = 0;
    virtual void on_open(ConnectionId connection) = 0;
    /// False closes this connection, and only this one.
    virtual bool on_text(ConnectionId connection, std::string_view text) = 0;
    virtual void on_close(ConnectionId connection) = 0;
    /// Some 60 times a second.
    virtual void on_frame() = 0;
};

struct ServerOptions {
    std::uint16_t port = 0;  ///< 0: any that is free
    std::string token;
    std::size_t max_message = 64 * 1024;        ///< bytes of a WebSocket message from the browser
    std::size_t max_upload = 64 * 1024 * 1024;  ///< bytes of a POST
    std::size_t max_connections = 64;
    /// Connections from one address. Where there are as many, the oldest one without a request is closed for a new one.
    std::size_t max_of_address = 32;
    int head_seconds = 5;                        ///< for the head of a connection's first request
    std::size_t max_waiting = 16 * 1024 * 1024;  ///< bytes that a browser may leave unread before it is let go
    int max_messages_a_second = 400;
    int frames_a_second = 60;
};

class Server {
public:
    /// Listens on 127.0.0.1 alone.
    /// @throw std::system_error where the port is taken.
    Server(Application& application, const ServerOptions& options);
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    [[nodiscard]] std::uint16_t port() const noexcept;
    /// The address to open in a browser, token included.
    [[nodiscard]] std::string url() const;
    /// Serves until stop().
    void run();

    // Any thread.
    void stop();
    void post(std::function<void()> work);  ///< runs it on the server's thread

    // The server's thread.
    void send_text(ConnectionId connection, std::string text);
    /// droppable: left out where earlier ones still wait to be sent.
    void send_binary(ConnectionId connection, std::shared_ptr<const std::string> bytes, bool droppable);

private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace sqmap::viewer
