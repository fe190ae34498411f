// The one file that includes Boost.Beast: it takes most of a minute to compile.
#include "viewer/server/http/server.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <system_error>

namespace sqmap::viewer {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

namespace {

constexpr auto k_patience = std::chrono::seconds(30);  // for a body or a further request to arrive, or an answer to be sent

std::string_view view_of(beast::string_view s) { return {s.data(), s.size()}; }

}  // namespace

struct Server::State : std::enable_shared_from_this<State> {
    State(Application& a, const ServerOptions& o) : application(a), options(o), acceptor(io), timer(io) {}

    void listen();
    void accept();
    void frame();

    class Http;
    class Socket;
    class Counted;

    [[nodiscard]] bool has_vacancy(const asio::ip::address& address) const;
    void make_vacancy(const asio::ip::address& address);

    Application& application;
    const ServerOptions options;
    Guard guard;
    asio::io_context io{1};
    tcp::acceptor acceptor;
    asio::steady_timer timer;
    std::map<ConnectionId, std::shared_ptr<Socket>> sockets;
    ConnectionId last = 0;
    std::size_t connections = 0;
    std::map<asio::ip::address, std::size_t> of_address;  ///< connections
    std::uint64_t waits = 0;
    std::map<std::uint64_t, std::weak_ptr<Http>> waiting;  ///< those whose request has not come in, oldest first
    bool stopping = false;
};

/// A connection in the counts, for as long as this lives.
class Server::State::Counted {
public:
    Counted(std::shared_ptr<State> state, const asio::ip::address& address) : state_(std::move(state)), address_(address)
    {
        ++state_->connections;
        ++state_->of_address[address_];
    }
    ~Counted()
    {
        --state_->connections;
        if (--state_->of_address[address_] == 0) state_->of_address.erase(address_);
    }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
    [[nodiscard]] const asio::ip::address& address() const { return address_; }

private:
    std::shared_ptr<State> state_;
    asio::ip::address address_;
};

/// A WebSocket after its handshake was granted.
class Server::State::Socket : public std::enable_shared_from_this<Socket> {
public:
    Socket(std::shared_ptr<State> state, beast::tcp_stream stream, std::unique_ptr<Counted> counted)
        : state_(std::move(state)), ws_(std::move(stream)), counted_(std::move(counted))
    {
    }

    void start(http::request<http::string_body> request)
    {
        request_ = std::move(request);
        beast::get_lowest_layer(ws_).expires_never();
        websocket::stream_base::timeout timeouts = websocket::stream_base::timeout::suggested(beast::role_type::server);
        timeouts.idle_timeout = std::chrono::seconds(20);
        timeouts.keep_alive_pings = true;
        ws_.set_option(timeouts);
        ws_.read_message_max(state_->options.max_message);
        ws_.auto_fragment(false);
        ws_.async_accept(request_, [self = shared_from_this()](error_code e) {
            if (e) return;
            self->request_ = {};
            self->id_ = ++self->state_->last;
            self->state_->sockets.emplace(self->id_, self);
            self->state_->application.on_open(self->id_);
            self->read();
        });
    }

    void send(std::shared_ptr<const std::string> bytes, bool text, bool droppable)
    {
        if (closing_) return;
        if (droppable && queue_.size() > 2) return;
        waiting_ += bytes->size();
        if (waiting_ > state_->options.max_waiting) return leave();
        queue_.push_back({std::move(bytes), text});
        if (queue_.size() == 1) write();
    }

    /// Without a farewell: for those that do not read, or say what no page of ours says.
    void leave()
    {
        closing_ = true;
        error_code ignored;
        beast::get_lowest_layer(ws_).socket().close(ignored);
        gone();
    }

private:
    struct Outgoing {
        std::shared_ptr<const std::string> bytes;
        bool text;
    };

    void read()
    {
        ws_.async_read(buffer_, [self = shared_from_this()](error_code e, std::size_t) {
            if (e || self->closing_) return self->gone();
            self->took();
        });
    }

    void took()
    {
        const auto now = std::chrono::steady_clock::now();
        if (now - second_ > std::chrono::seconds(1)) {
            second_ = now;
            messages_ = 0;
        }
        const std::string text = beast::buffers_to_string(buffer_.data());
        buffer_.consume(buffer_.size());
        if (++messages_ > state_->options.max_messages_a_second) return leave();
        if (!ws_.got_text()) return leave();
        if (!state_->application.on_text(id_, text)) return leave();
        read();
    }

    void write()
    {
        ws_.text(queue_.front().text);
        ws_.async_write(asio::buffer(*queue_.front().bytes), [self = shared_from_this()](error_code e, std::size_t) {
            if (e) return self->gone();
            self->waiting_ -= self->queue_.front().bytes->size();
            self->queue_.pop_front();
            if (!self->queue_.empty() && !self->closing_) self->write();
        });
    }

    void gone()
    {
        if (id_ == 0) return;
        const ConnectionId id = std::exchange(id_, 0);
        state_->sockets.erase(id);
        state_->application.on_close(id);
    }

    std::shared_ptr<State> state_;
    websocket::stream<beast::tcp_stream, false> ws_;  ///< without compression, which costs seconds to compile
    http::request<http::string_body> request_;
    beast::flat_buffer buffer_;
    std::deque<Outgoing> queue_;
    std::size_t waiting_ = 0;
    std::unique_ptr<Counted> counted_;
    ConnectionId id_ = 0;
    bool closing_ = false;
    int messages_ = 0;
    std::chrono::steady_clock::time_point second_{};
};

/// One connection that speaks HTTP, request after request.
class Server::State::Http : public std::enable_shared_from_this<Http> {
public:
    Http(std::shared_ptr<State> state, tcp::socket socket, std::unique_ptr<Counted> counted)
        : state_(std::move(state)), stream_(std::move(socket)), counted_(std::move(counted))
    {
    }

    /// patience: for the head of the next request.
    void read(std::chrono::seconds patience)
    {
        waits_ = ++state_->waits;
        state_->waiting.emplace(waits_, weak_from_this());
        parser_.emplace();
        parser_->body_limit(state_->options.max_upload);
        parser_->header_limit(8 * 1024);
        stream_.expires_after(patience);
        // The head is judged before a body is taken in.
        http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](error_code e, std::size_t) {
            self->state_->waiting.erase(self->waits_);
            if (e == http::error::end_of_stream || e == beast::error::timeout || self->counted_ == nullptr) return self->finish();
            if (e == http::error::body_limit) return self->refuse(413, self->too_large());
            if (e) return self->refuse(400, "not a request that this server understands");
            self->judge();
        });
    }

    /// A connection whose request has not come in gives way to another.
    void give_up()
    {
        state_->waiting.erase(waits_);
        counted_.reset();
        finish();
    }
    [[nodiscard]] const Counted* counted() const { return counted_.get(); }

private:
    void judge()
    {
        stream_.expires_after(k_patience);
        const auto& request = parser_->get();
        const auto method = view_of(request.method_string());
        const auto origin = request.find(http::field::origin);
        const bool upgrade = websocket::is_upgrade(request);
        const RequestHead head{.method = method,
                               .target = view_of(request.target()),
                               .host = view_of(request[http::field::host]),
                               .origin = origin == request.end() ? std::string_view() : view_of(origin->value()),
                               .has_origin = origin != request.end(),
                               .upgrade = upgrade};
        const bool doubled = request.count(http::field::host) != 1 || request.count(http::field::origin) > 1;
        if (const Admission admission = doubled ? Admission::BadHost : admit(head, state_->guard);
            admission != Admission::Granted)
            return refuse(admission == Admission::BadTarget ? 404 : 403, describe(admission));
        if (method != "GET" && method != "POST" && method != "HEAD") return refuse(405, "GET, HEAD and POST are what there is");
        if (upgrade) {
            if (path_of(head.target) != "/ws") return refuse(404, "no such address");
            auto socket = std::make_shared<Socket>(state_, std::move(stream_), std::move(counted_));
            socket->start(http::request<http::string_body>(parser_->release()));
            return;
        }
        http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](error_code e, std::size_t) {
            if (e == http::error::body_limit) return self->refuse(413, self->too_large());
            if (e) return self->refuse(400, "the request ended too early");
            self->handle();
        });
    }

    void handle()
    {
        auto request = parser_->release();
        keep_alive_ = request.keep_alive();
        head_only_ = request.method() == http::verb::head;
        // Another thread answers later where the answer takes long.
        stream_.expires_never();
        state_->application.on_http(
            {std::string(view_of(request.method_string())), std::string(view_of(request.target())), std::move(request.body())},
            [self = shared_from_this()](HttpReply reply) {
                asio::post(self->state_->io, [self, reply = std::move(reply)]() mutable { self->answer(std::move(reply)); });
            });
    }

    [[nodiscard]] std::string too_large() const
    {
        return "larger than this server takes: " + std::to_string(state_->options.max_upload >> 20) + " MB";
    }

    void refuse(int status, std::string why)
    {
        keep_alive_ = false;
        answer({.status = status, .body = std::move(why) + "\n"});
    }

    void answer(HttpReply reply)
    {
        auto response = std::make_shared<http::response<http::string_body>>();
        response->version(11);
        response->result(static_cast<unsigned>(reply.status));
        response->set(http::field::content_type, reply.type);
        response->set(http::field::cache_control, "no-store");
        response->set("X-Content-Type-Options", "nosniff");
        response->set("X-Frame-Options", "DENY");
        response->set("Referrer-Policy", "no-referrer");
        response->set("Cross-Origin-Resource-Policy", "same-origin");
        response->set("Content-Security-Policy",
                      "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
                      "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
        if (!reply.file_name.empty())
            response->set(http::field::content_disposition, "attachment; filename=\"" + reply.file_name + "\"");
        response->keep_alive(keep_alive_);
        const std::size_t size = reply.body.size();
        if (!head_only_) response->body() = std::move(reply.body);
        response->content_length(size);
        stream_.expires_after(k_patience);
        http::async_write(stream_, *response, [self = shared_from_this(), response](error_code e, std::size_t) {
            if (e || !self->keep_alive_) return self->finish();
            self->read(k_patience);
        });
    }

    void finish()
    {
        error_code ignored;
        stream_.socket().shutdown(tcp::socket::shutdown_both, ignored);
        stream_.close();
    }

    std::shared_ptr<State> state_;
    beast::tcp_stream stream_;
    beast::flat_buffer buffer_{64 * 1024};
    std::optional<http::request_parser<http::string_body>> parser_;
    std::unique_ptr<Counted> counted_;
    std::uint64_t waits_ = 0;  ///< its number among those that wait for a request
    bool keep_alive_ = false, head_only_ = false;
};

bool Server::State::has_vacancy(const asio::ip::address& address) const
{
    const auto own = of_address.find(address);
    return connections < options.max_connections && (own == of_address.end() || own->second < options.max_of_address);
}

/// The oldest connection that has sent no request yet gives way, so that those that never send one keep nobody out. It is one of
/// the same address where that has as many as it may.
void Server::State::make_vacancy(const asio::ip::address& address)
{
    const auto own = of_address.find(address);
    const bool of_same = own != of_address.end() && own->second >= options.max_of_address;
    for (const auto& [number, held] : waiting) {
        const std::shared_ptr<Http> http = held.lock();
        if (http == nullptr || http->counted() == nullptr || (of_same && http->counted()->address() != address)) continue;
        return http->give_up();
    }
}

void Server::State::listen()
{
    const tcp::endpoint here(asio::ip::address_v4::loopback(), options.port);
    acceptor.open(here.protocol());
    acceptor.set_option(asio::socket_base::reuse_address(true));
    acceptor.bind(here);
    acceptor.listen();
    guard = {options.token, acceptor.local_endpoint().port()};
    accept();
}

void Server::State::accept()
{
    acceptor.async_accept([self = shared_from_this()](error_code e, tcp::socket socket) {
        if (self->stopping) return;
        const tcp::endpoint from = e ? tcp::endpoint() : socket.remote_endpoint(e);
        if (!e && !self->has_vacancy(from.address())) self->make_vacancy(from.address());
        if (!e && self->has_vacancy(from.address())) {
            socket.set_option(tcp::no_delay(true), e);
            std::make_shared<Http>(self, std::move(socket), std::make_unique<Counted>(self, from.address()))
                ->read(std::chrono::seconds(self->options.head_seconds));
        }
        self->accept();
    });
}

void Server::State::frame()
{
    timer.expires_after(std::chrono::microseconds(1'000'000 / options.frames_a_second));
    timer.async_wait([self = shared_from_this()](error_code e) {
        if (e || self->stopping) return;
        self->application.on_frame();
        self->frame();
    });
}

Server::Server(Application& application, const ServerOptions& options) : state_(std::make_shared<State>(application, options))
{
    try {
        state_->listen();
    } catch (const boost::system::system_error& e) {
        throw std::system_error(e.code().value(), std::generic_category(), "127.0.0.1:" + std::to_string(options.port));
    }
}

Server::~Server()
{
    // Handlers hold the state, and the state the context that holds them.
    state_->stopping = true;
    for (auto& [id, socket] : std::exchange(state_->sockets, {})) socket->leave();
    error_code ignored;
    state_->acceptor.close(ignored);
    state_->timer.cancel();
    state_->io.restart();
    state_->io.poll();
}

std::uint16_t Server::port() const noexcept { return state_->guard.port; }

std::string Server::url() const { return "http://127.0.0.1:" + std::to_string(port()) + "/?token=" + state_->options.token; }

void Server::run()
{
    state_->frame();
    state_->io.run();
}

void Server::stop() { state_->io.stop(); }

void Server::post(std::function<void()> work) { asio::post(state_->io, std::move(work)); }

void Server::send_text(ConnectionId connection, std::string text)
{
    const auto at = state_->sockets.find(connection);
    if (at == state_->sockets.end()) return;
    const std::shared_ptr<State::Socket> socket = at->second;  // leaving takes it off the list
    socket->send(std::make_shared<const std::string>(std::move(text)), true, false);
}

void Server::send_binary(ConnectionId connection, std::shared_ptr<const std::string> bytes, bool droppable)
{
    const auto at = state_->sockets.find(connection);
    if (at == state_->sockets.end()) return;
    const std::shared_ptr<State::Socket> socket = at->second;
    socket->send(std::move(bytes), false, droppable);
}

}  // namespace sqmap::viewer
