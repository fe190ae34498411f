// Haply Inverse3 through the service that its maker ships: JSON over a WebSocket on this machine. The service sends a state,
// we answer with a force, which may be zero; only then does it send the next state.
#include "device/families.h"
#include "device/haply_message.h"
#include "device/threaded.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <optional>

namespace sqmap::device {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::system::error_code;
using nlohmann::json;

constexpr std::size_t k_max_message = 64 * 1024;
constexpr const char* k_default_port = "10001";

/// The value of a key, or null if there is none or the value is no object.
const json* find(const json* value, const char* key)
{
    if (value == nullptr || !value->is_object()) return nullptr;
    const auto at = value->find(key);
    return at == value->end() ? nullptr : &*at;
}

bool number(const json* value, const char* key, double& out)
{
    const json* const found = find(value, key);
    if (found == nullptr || !found->is_number()) return false;
    out = found->get<double>();
    return std::isfinite(out);
}

bool vector(const json* value, Vec3d& out)
{
    Vec3d v;
    if (!number(value, "x", v.x) || !number(value, "y", v.y) || !number(value, "z", v.z)) return false;
    out = v;
    return true;
}

const json* first_of(const json* list)
{
    return list != nullptr && list->is_array() && !list->empty() ? &list->front() : nullptr;
}

/// Orientation and buttons of a grip, where one is connected. True with an orientation.
bool read_grip(const json& root, Sample& sample)
{
    for (const char* const kind : {"wireless_verse_grip", "verse_grip"}) {
        const json* const state = find(first_of(find(&root, kind)), "state");
        if (state == nullptr) continue;
        if (const json* const buttons = find(state, "buttons"); buttons != nullptr && buttons->is_object()) {
            std::uint32_t bit = 1;
            for (const char* const name : {"a", "b", "c"}) {
                const json* const pressed = find(buttons, name);
                if (pressed != nullptr && pressed->is_boolean() && pressed->get<bool>()) sample.buttons |= bit;
                bit <<= 1;
            }
        }
        const json* const q = find(state, "orientation");
        double w = 0, x = 0, y = 0, z = 0;
        return number(q, "w", w) && number(q, "x", x) && number(q, "y", y) && number(q, "z", z) &&
               unit_rotation(w, x, y, z, sample.poses[0].rotation);
    }
    return false;
}

}  // namespace

HaplyMessage read_haply(std::string_view text, const std::string& wanted)
{
    HaplyMessage out;
    const json root = json::parse(text, nullptr, false);
    if (root.is_discarded() || !root.is_object()) return out;
    out.valid = true;
    const json* const devices = find(&root, "inverse3");
    if (devices == nullptr || !devices->is_array()) return out;
    for (const json& device : *devices) {
        const json* const id = find(&device, "device_id");
        if (id == nullptr || !id->is_string() || (!wanted.empty() && id->get_ref<const std::string&>() != wanted)) continue;
        out.device_id = id->get_ref<const std::string&>();
        const json* const state = find(&device, "state");
        out.has_state = vector(find(state, "cursor_position"), out.sample.poses[0].translation);
        if (!out.has_state) return out;
        const bool turns = read_grip(root, out.sample);
        // The service reports no angular velocity, so with a grip the twists come from differences of poses.
        out.sample.has_twist = vector(find(state, "cursor_velocity"), out.sample.twists[0].linear) && !turns;
        return out;
    }
    return out;
}

std::string haply_force(const std::string& device_id, Vec3d force)
{
    const json values{{"x", force.x}, {"y", force.y}, {"z", force.z}};
    const json command{
        {"inverse3", json::array({{{"device_id", device_id}, {"commands", {{"set_cursor_force", {{"values", values}}}}}}})}};
    return command.dump(-1, ' ', true, json::error_handler_t::replace);
}

namespace {

struct Settings {
    std::string host = "localhost", port = k_default_port, device_id;
    double max_force = 0, wait = 5;
};

class Haply final : public ThreadedDevice {
public:
    explicit Haply(const Settings& settings) : settings_(settings), device_id_(settings.device_id)
    {
        capabilities_ = {.name = "Haply Inverse3 (service on " + settings.host + ":" + settings.port + ")",
                         .rotates_in = true,
                         .force_out = true,
                         .max_force = settings.max_force,
                         // The force that answers a state goes out with the answer to the next.
                         .delay = 1e-3};
        start([this] {
            connect();
            io_.run();
        });
        if (wait_for_sample(settings.wait)) return;
        finish();
        throw DeviceError("haply: no Inverse3 reports its state through the service on " + settings.host + ":" + settings.port +
                          "\n  cure: start Haply's service, switch the device on; haply:HOST,port=N,device=ID for another one");
    }
    ~Haply() override { finish(); }

private:
    void finish()
    {
        asio::post(io_, [this] { say_goodbye(); });
        stop();
    }

    // Everything below runs on the thread.

    void connect()
    {
        if (closing_) return io_.stop();
        ws_.emplace(io_);
        buffer_.clear();
        resolver_.async_resolve(settings_.host, settings_.port, [this](error_code error, const auto& decimals) {
            if (error) return fail();
            beast::get_lowest_layer(*ws_).expires_after(std::chrono::seconds(1));
            beast::get_lowest_layer(*ws_).async_connect(decimals, [this](error_code failed, const auto&) {
                if (failed) return fail();
                beast::get_lowest_layer(*ws_).expires_never();
                // A service that says nothing for a second is gone.
                ws_->set_option(websocket::stream_base::timeout{std::chrono::seconds(1), std::chrono::seconds(1), false});
                ws_->read_message_max(k_max_message);
                error_code ignored;
                beast::get_lowest_layer(*ws_).socket().set_option(asio::ip::tcp::no_delay(true), ignored);
                ws_->async_handshake(settings_.host + ":" + settings_.port, "/", [this](error_code refused) {
                    if (refused) return fail();
                    connected_ = true;
                    read_next();
                });
            });
        });
    }

    /// Handles a lost or refused connection: connects again after 200 ms.
    void fail()
    {
        connected_ = false;
        channel_.lose();
        if (closing_) return io_.stop();
        timer_.expires_after(std::chrono::milliseconds(200));
        timer_.async_wait([this](error_code error) {
            if (!error) connect();
        });
    }

    void read_next()
    {
        ws_->async_read(buffer_, [this](error_code error, std::size_t) {
            if (error) return fail();
            if (closing_) return;
            receive();
        });
    }

    void receive()
    {
        const auto bytes = buffer_.cdata();
        HaplyMessage message = read_haply({static_cast<const char*>(bytes.data()), bytes.size()}, settings_.device_id);
        buffer_.consume(buffer_.size());
        if (!message.device_id.empty()) device_id_ = message.device_id;
        const double time = now();
        if (message.has_state) {
            message.sample.time = time;
            channel_.publish(message.sample);
        }
        // Without a device there is nothing to command; the service's next message may name one.
        if (device_id_.empty()) return read_next();
        // A message without a state gets no force.
        answer(message.has_state ? channel_.output(time)[0].force : Vec3d{});
    }

    void answer(Vec3d force)
    {
        out_ = haply_force(device_id_, force);
        writing_ = true;
        ws_->async_write(asio::buffer(out_), [this](error_code error, std::size_t) {
            writing_ = false;
            if (error) return fail();
            if (closing_) return say_goodbye();
            read_next();
        });
    }

    /// Sends a last zero force and closes the connection; gives up after a second.
    void say_goodbye()
    {
        closing_ = true;
        timer_.expires_after(std::chrono::seconds(1));
        timer_.async_wait([this](error_code error) {
            if (!error) io_.stop();
        });
        if (writing_) return;  // answer() calls this again
        if (!connected_ || device_id_.empty()) return io_.stop();
        out_ = haply_force(device_id_, {});
        ws_->async_write(asio::buffer(out_), [this](error_code error, std::size_t) {
            if (error) return io_.stop();
            ws_->async_close(websocket::close_code::going_away, [this](error_code) { io_.stop(); });
        });
    }

    Settings settings_;
    asio::io_context io_{1};
    asio::ip::tcp::resolver resolver_{io_};
    asio::steady_timer timer_{io_};
    std::optional<websocket::stream<beast::tcp_stream, false>> ws_{};  ///< without compression, which costs seconds to compile
    beast::flat_buffer buffer_{k_max_message};
    std::string out_, device_id_;
    bool connected_ = false, writing_ = false, closing_ = false;
};

/// True if something listens on host and port; takes the limit at most.
bool answers(const std::string& host, const std::string& port, std::chrono::milliseconds limit)
{
    asio::io_context io{1};
    asio::ip::tcp::resolver resolver(io);
    beast::tcp_stream stream(io);
    bool open = false;
    resolver.async_resolve(host, port, [&](error_code error, const auto& decimals) {
        if (error) return;
        stream.expires_after(limit);
        stream.async_connect(decimals, [&](error_code failed, const auto&) { open = !failed; });
    });
    io.run_for(limit);
    return open;
}

}  // namespace

void list_haply(std::vector<DeviceListing>& list)
{
    DeviceListing entry{"haply",
                        Presence::Absent,
                        std::string("Haply's service does not answer on localhost:") + k_default_port,
                        {.name = "Haply Inverse3", .rotates_in = true, .force_out = true}};
    if (answers("localhost", k_default_port, std::chrono::milliseconds(200))) {
        entry.presence = Presence::Here;
        entry.state = std::string("a service answers on localhost:") + k_default_port;
    }
    list.push_back(std::move(entry));
}

std::unique_ptr<Device> open_haply(const DeviceSpec& spec)
{
    spec.allow({"port", "device", "max-force", "wait"});
    Settings settings;
    if (!spec.first.empty()) settings.host = spec.first;
    settings.port = std::to_string(spec.whole("port", std::stoi(k_default_port), 1, 65535));
    settings.device_id = spec.text("device", "");
    settings.max_force = spec.number("max-force", 0, 0.01, 50);
    settings.wait = spec.number("wait", settings.wait, 0.1, 3600);
    return std::make_unique<Haply>(settings);
}

}  // namespace sqmap::device
