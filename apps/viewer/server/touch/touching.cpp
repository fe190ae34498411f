#include "viewer/server/touch/touching.h"

#include "sqmap/device/open.h"
#include "viewer/server/touch/tool.h"

#include <algorithm>
#include <cstring>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

constexpr std::uint64_t k_feet_every = 3;  // frames: feet are for the eye

}  // namespace

Touching::Touching(Audience& audience, Scene& scene, Worker& pictures, Worker& bakes)
    : audience_(audience), scene_(scene), pictures_(pictures), bakes_(bakes), recorder_(audience, scene, pictures, bakes)
{
    recorder_.settings = [this] { return settings_; };
    recorder_.on_open = [this](const Settings& settings) {
        set(settings);
        on_status();
    };
}

// Files and values that a page fetches.

ObjectPtr Touching::held_object() const
{
    const bool mesh = settings_.tool == ToolKind::Mesh && settings_.tool_object < scene_.entries().size();
    return mesh ? scene_.entries()[settings_.tool_object].object : nullptr;
}

void Touching::add_routes(Routes& routes)
{
    routes.get("/api/tool", [this](const Call& call) {
        if (pictures_.busy()) return call.answer(busy());
        pictures_.work([answer = call.answer, held = held_object(), settings = settings_] {
            answer(bytes_reply(tool_bytes(make_tool(settings, held.get()))));
        });
    });
    recorder_.add_routes(routes);
}

void Touching::list_devices()
{
    bakes_.work([this] {
        const std::vector<device::DeviceListing> list = device::list_devices();
        ordered_json json = ordered_json::array();
        std::vector<std::string> specs;
        json.push_back({{"name", "Pointer or keys, through a simulated device"},
                        {"here", true},
                        {"state", "no hardware: force is drawn and heard"},
                        {"rate", 1000},
                        {"limit", 3.3}});
        for (const device::DeviceListing& d : list) {
            // Simulated devices need a file or a script, so the page does not offer them.
            specs.push_back(d.spec);
            json.push_back({{"name", d.capabilities.name.empty() ? d.spec : d.capabilities.name},
                            {"here", d.presence == device::Presence::Here && !d.capabilities.simulated},
                            {"state", d.state},
                            {"rate", d.capabilities.rate},
                            {"limit", d.capabilities.max_force}});
        }
        audience_.post([this, json = std::move(json), specs = std::move(specs)] {
            devices_ = json;
            device_specs_ = specs;
            on_status();
        });
    });
}

// Messages that a page sends.

void Touching::hold(ConnectionId connection, const Message& message)
{
    if (holder_ == 0 || holder_ == connection) {
        refused_.erase(connection);
        return move(connection, message);
    }
    // Said once a press.
    if (message.held && refused_.insert(connection).second) audience_.send(connection, ordered_json::object({{"say", "held"}}));
    if (!message.held) refused_.erase(connection);
}

/// A new grasp begins where the page says, off the surface: a tool that flew there might pass through something, and one that was
/// left behind something, as in a ring's hole, would hang on it.
void Touching::move(ConnectionId connection, const Message& message)
{
    constexpr double k_near = 0.03;  // m
    const bool begins = message.held && holder_ == 0;
    const bool far = norm(message.target - target_) > k_near || norm(message.target - frame_.tool) > k_near;
    holder_ = message.held ? connection : 0;
    target_ = message.target;
    if (begins && device_ == 0 && (touch_ == nullptr || far)) begin_or_restart(true);
    if (touch_ == nullptr) return;
    // To grasp anew is the user's act that ends a fault; STOP holds until it is taken back.
    if (begins && !stopped_ && frame_.faults != 0) touch_->resume();
    touch_->aim(target_);
}

void Touching::drop_tool()
{
    touch_.reset();
    holder_ = 0;
    idle_ = 0;
}

void Touching::take(ConnectionId connection)
{
    if (holder_ == 0 || holder_ == connection) return;
    audience_.send(holder_, ordered_json::object({{"say", "taken"}}));
    refused_.erase(connection);
    drop_tool();
    on_status();
}

void Touching::rest(ConnectionId connection)
{
    if (device_ == 0 && (holder_ == 0 || holder_ == connection)) drop_tool();
}

void Touching::stop()
{
    stopped_ = true;
    if (touch_ != nullptr) touch_->stop();
}

void Touching::resume()
{
    stopped_ = false;
    if (touch_ != nullptr) touch_->resume();
}

void Touching::set(const Settings& settings)
{
    settings_ = settings;
    if (settings_.tool == ToolKind::Mesh && settings_.tool_object >= scene_.entries().size()) settings_.tool = ToolKind::Ball;
    if (!has_wanted_force()) settings_.paper_force = false;
    ++tool_revision_;
    if (touch_ != nullptr && !touch_->adjust(settings_)) restart();
}

/// 0: the simulated one that the pointer moves.
void Touching::choose_device(std::uint32_t device)
{
    if (device > device_specs_.size()) return;
    device_ = device;
    touch_.reset();
    restart();
}

void Touching::leave(ConnectionId connection, bool last)
{
    refused_.erase(connection);
    if (connection == holder_ || last) drop_tool();
    if (last) record(false);
}

void Touching::remove(std::uint32_t object)
{
    if (settings_.tool != ToolKind::Mesh || settings_.tool_object < object) return;
    if (settings_.tool_object == object)
        settings_.tool = ToolKind::Ball;
    else
        --settings_.tool_object;
    ++tool_revision_;
    on_status();
}

void Touching::insert(std::uint32_t object)
{
    if (settings_.tool != ToolKind::Mesh || settings_.tool_object < object) return;
    ++settings_.tool_object;
    ++tool_revision_;
    on_status();
}

/// The touch begins anew, so that nothing that was felt before has a part in what is recorded.
void Touching::record(bool on)
{
    if (on) {
        recorder_.begin();
        restart();
    } else {
        recorder_.end();
        if (touch_ != nullptr) touch_->end_take();
        on_status();
    }
}

void Touching::restart() { begin_or_restart(false); }

/// False, and said to the pages, where the paper's force is wanted of objects that do not have it.
bool Touching::has_wanted_force()
{
    std::vector<ObjectPtr> objects = scene_.touchable(settings_);
    if (const ObjectPtr held = held_object()) std::replace(objects.begin(), objects.end(), held, ObjectPtr());
    if (!settings_.paper_force || has_paper_force(objects)) return true;
    audience_.send_trouble("The paper's force is that of its own maps: bake all objects with them, or remove the others.");
    return false;
}

/// Makes the touch anew where there is one, or where one is to begin.
void Touching::begin_or_restart(bool begin)
{
    const bool wanted = begin || touch_ != nullptr || device_ > 0;
    touch_.reset();
    if (!has_wanted_force()) settings_.paper_force = false;
    if (!wanted || scene_.entries().empty()) return;
    frame_ = {};
    try {
        std::unique_ptr<device::Device> device;
        if (device_ > 0) device = device::open_device(device_specs_[device_ - 1]);
        touch_ =
            std::make_unique<Touch>(scene_.touchable(settings_), settings_, std::move(device), target_, recorder_.next_take());
        if (stopped_) touch_->stop();
    } catch (const std::exception& e) {
        device_ = 0;
        audience_.send_trouble(e.what());
    }
}

// Messages that all pages get.

void Touching::stream(std::uint64_t frame_number)
{
    if (touch_ == nullptr || !touch_->frame(frame_)) return;
    clear_tool();
    end_idle();
    if (touch_ == nullptr) return;
    const bool keeps = recorder_.recording() && !frame_.cut && !recorder_.full();
    stream_floats(frame_floats(frame_, frame_number, keeps ? recorder_.ticks() : 0));
    if (frame_number % k_feet_every == 0) stream_feet();
}

/// A tool that nobody holds and that still touches is caught: between the hand, which was lifted from the last surface under the
/// pointer, and the tool there is another surface. The hand then goes to the tool, and a little off what it touches.
void Touching::clear_tool()
{
    constexpr int k_patience = 12;   // frames: time to be lifted
    constexpr double k_off = 0.002;  // m
    caught_ = holder_ == 0 && device_ == 0 && frame_.contacts > 0 ? caught_ + 1 : 0;
    if (caught_ < k_patience) return;
    target_ = frame_.tool + k_off * frame_.normal;
    touch_->aim(target_);
}

/// A tool of the pointer that nobody holds, that touches nothing and is not recorded needs no servo: the next grasp begins anew.
void Touching::end_idle()
{
    constexpr int k_patience = 90;  // frames
    const bool idle = holder_ == 0 && device_ == 0 && frame_.contacts == 0 && !recorder_.recording();
    idle_ = idle ? idle_ + 1 : 0;
    if (idle_ < k_patience) return;
    drop_tool();
    on_status();
}

void Touching::stream_floats(const std::vector<float>& values)
{
    auto bytes = std::make_shared<std::string>(4 * values.size(), '\0');
    std::memcpy(bytes->data(), values.data(), bytes->size());
    audience_.stream(bytes);
}

/// Sends the feet of the contacts; an empty list once after the last contact, so that the pages clear theirs.
void Touching::stream_feet()
{
    const std::vector<Foot> feet = touch_->feet(frame_);
    if (feet.empty() && !feet_shown_) return;
    feet_shown_ = !feet.empty();
    std::vector<float> out{3, static_cast<float>(frame_.object), static_cast<float>(feet.size())};
    for (const Foot& f : feet) out.insert(out.end(), {static_cast<float>(f.part), f.x, f.y, f.depth});
    stream_floats(out);
}

void Touching::add_status(ordered_json& out) const
{
    out["touching"] = on();
    out["stopped"] = stopped_;
    out["device"] = device_;
    out["devices"] = devices_;
    out["settings"] = settings_json(settings_);
    const OptionRange steps = option_named(paper::k_query_numbers, "nearest_steps").range;
    out["nearestSteps"] = {steps.least, steps.max};
    out["toolRevision"] = tool_revision_;
    out["recorded"] = recorder_.recording() ? 0 : recorder_.ticks();
    if (touch_ != nullptr) {
        const device::ServoCounters c = touch_->counters();
        out["counters"] = {
            {"ticks", c.ticks},       {"late", c.late},         {"missed", c.missed},   {"overruns", c.overruns},
            {"degraded", c.degraded}, {"watchdog", c.watchdog}, {"dropped", c.dropped}, {"worstLate", 1e3 * c.worst_late}};
        out["limit"] = touch_->force_limit();
        out["safeStiffness"] = touch_->safe_stiffness();
        out["deviceName"] = touch_->capabilities().name;
    }
}

}  // namespace sqmap::viewer
