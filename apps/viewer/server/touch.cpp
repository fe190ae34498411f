#include "touch.h"

#include "sqmap/device/handover.h"
#include "sqmap/device/simulated.h"
#include "sqmap/haptic/step.h"
#include "sqmap/query/query.h"
#include "tool.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <system_error>

namespace sqmap::viewer {
namespace {

constexpr int k_priority = 40;

/// Settings that the next tick can take.
struct Live {
    query::Layer layer = query::Layer::Auto;
    double stiffness = 400, damping = 0.3, friction = 0.3;
};

query::Layer layer_of(query::Layer layer, haptic::Averaging averaging)
{
    if (layer != query::Layer::Auto) return layer;
    return averaging == haptic::Averaging::Patch ? query::Layer::Three : query::Layer::Exact;
}

Live live_of(const Settings& s) { return {s.layer, s.stiffness, s.damping, s.friction}; }

bool same_tool(const Settings& a, const Settings& b)
{
    return a.texture == b.texture && a.smoothing == b.smoothing && a.tool_radius == b.tool_radius && a.zone == b.zone &&
           a.force_limit == b.force_limit && a.tool == b.tool && a.tool_object == b.tool_object && a.tool_size == b.tool_size &&
           a.tool_turn == b.tool_turn && a.tool_tilt == b.tool_tilt;
}

/// What a tick felt, beside the servo's own record of it.
struct Felt {
    std::uint64_t tick = 0;
    double depth = 0;
    std::uint32_t contacts = 0;
    Vec3d point{}, normal{};
};

/// The hand: goes to where it is told, at a hand's speed.
struct Hand {
    mutable device::Newest<Vec3d> told;
    Vec3d start{};
    mutable Vec3d place{}, velocity{};
    mutable double time = 0;

    static device::HandTarget at(const void* context, double time, std::size_t) noexcept
    {
        const Hand& hand = *static_cast<const Hand*>(context);
        if (time <= 0) hand.place = hand.start;
        if (time > hand.time) {
            const double dt = std::min(time - hand.time, 0.02);
            hand.time = time;
            (void)hand.told.take();
            // A critically damped approach, so that neither place nor speed jumps.
            constexpr double k_quickness = 60;  // 1/s
            Vec3d wish = k_quickness * (hand.told.value() - hand.place);
            if (const double speed = norm(wish); speed > Touch::k_hand_speed) wish = Touch::k_hand_speed / speed * wish;
            hand.velocity += std::min(1.0, 2 * k_quickness * dt) * (wish - hand.velocity);
            hand.place += dt * hand.velocity;
        }
        return {{{}, hand.place}, {hand.velocity, {}}};
    }
};

}  // namespace

struct Touch::Work {
    std::vector<ObjectPtr> objects;
    Settings settings;
    std::vector<haptic::Solid> solids;
    std::vector<float> weights, texture_values;
    haptic::Texture texture{};
    std::unique_ptr<query::Probe> probe;
    std::unique_ptr<haptic::State> state;
    Hand hand;
    device::Newest<Live> live;
    device::Ring<Felt, 1024> felt;
    Felt now{};  ///< the servo's thread
    std::unique_ptr<device::Device> device;
    std::unique_ptr<device::Servo> servo;  // last: it ends first
    device::ServoTick tick{};
    Felt last{};
    double depth = 0;

    void make_tool();
    static std::uint32_t feel(void* context, const device::TickInput& input, std::span<haptic::Wrench> wrenches) noexcept;
};

void Touch::Work::make_tool()
{
    haptic::ZoneOptions zone{
        .stiffness = settings.stiffness, .damping = settings.damping, .tangential_stiffness = settings.stiffness};
    const bool held = settings.tool == ToolKind::Mesh && settings.tool_object < objects.size();
    if (settings.tool == ToolKind::Ball || (settings.tool == ToolKind::Mesh && !held)) {
        zone.averaging = settings.smoothing > 0 ? haptic::Averaging::Stencil : haptic::Averaging::Ball;
        zone.smoothing = haptic::ball_of(settings.tool_radius);
        if (settings.smoothing > 0) {
            zone.smoothing = {};
            zone.smoothing.radius = settings.smoothing;
        }
        probe = std::make_unique<query::Probe>(haptic::stencil_points(zone.smoothing));
    } else {
        Tool tool = viewer::make_tool(settings, held ? objects[settings.tool_object].get() : nullptr);
        weights = std::move(tool.weights);
        probe = std::make_unique<query::Probe>(tool.mesh.vertices);
    }
    zone.layer = layer_of(settings.layer, zone.averaging);
    const haptic::Zone whole{.probe = probe.get(),
                             .weights = weights,
                             .radius = settings.zone > 0 ? settings.zone : std::numeric_limits<double>::infinity(),
                             .options = zone};
    if (settings.texture > 0)
        texture = haptic::gaussian_texture({.amplitude = settings.texture, .wavelength = 0.003}, texture_values);
    haptic::Material material{.mu_static = 1.33 * settings.friction, .mu_dynamic = settings.friction};
    if (settings.texture > 0) material.texture = &texture;
    for (ObjectPtr& object : objects) {
        if (held && object == objects[settings.tool_object]) continue;
        solids.push_back({.model = &object->metres, .pose = object->pose(), .material = material});
    }
    if (held) objects[settings.tool_object] = nullptr;
    state = std::make_unique<haptic::State>(
        std::span(&whole, 1),
        haptic::StateOptions{.most_contacts = probe->size(), .most_solids = std::max<std::size_t>(1, solids.size())});
}

std::uint32_t Touch::Work::feel(void* context, const device::TickInput& input, std::span<haptic::Wrench> wrenches) noexcept
{
    Work& w = *static_cast<Work*>(context);
    if (w.live.take()) {
        const Live& now = w.live.value();
        haptic::ZoneOptions& zone = w.state->options(0);
        zone.layer = layer_of(now.layer, zone.averaging);
        zone.stiffness = zone.tangential_stiffness = now.stiffness;
        zone.damping = now.damping;
        for (haptic::Solid& solid : w.solids) {
            solid.material.mu_dynamic = now.friction;
            solid.material.mu_static = 1.33 * now.friction;
        }
    }
    haptic::StepInput step{.solids = w.solids, .poses = {input.sample.poses.data(), 1}, .twists = {}, .dt = input.dt};
    if (input.sample.has_twist) step.twists = {input.sample.twists.data(), 1};
    step.degraded = input.degraded;
    const haptic::StepResult result = haptic::step(*w.state, step, wrenches.first(1));
    const haptic::ZoneReport& report = w.state->report(0);
    // Old planes answer for a force, not for what is touched: that stays.
    if (!input.degraded) w.now = {0, result.deepest, result.contacts, report.point, report.normal};
    w.now.tick = input.tick;
    (void)w.felt.push(w.now);
    return result.status;
}

Touch::Touch(std::vector<ObjectPtr> objects, const Settings& settings, std::unique_ptr<device::Device> device, Vec3d start)
    : work_(std::make_unique<Work>())
{
    Work& w = *work_;
    w.objects = std::move(objects);
    w.settings = settings;
    w.make_tool();
    w.hand.start = start;
    w.hand.told.put(start);
    w.device =
        device != nullptr
            ? std::move(device)
            : std::make_unique<device::SimulatedDevice>(device::SimulatedOptions{.script = Hand::at, .script_context = &w.hand});
    device::ServoOptions options;
    const double most = w.device->capabilities().max_force;
    options.safety.force_limit = most > 0 ? std::min(settings.force_limit, most) : std::min(settings.force_limit, 1.0);
    options.signals = false;  // the program ends by itself, and the servo with it
    // Before the page and everything else where the machine lets us.
    options.priority = k_priority;
    try {
        w.servo = std::make_unique<device::Servo>(*w.device, options, Work::feel, &w);
    } catch (const std::system_error&) {
        options.priority = 0;
        w.servo = std::make_unique<device::Servo>(*w.device, options, Work::feel, &w);
    }
}

Touch::~Touch() = default;

void Touch::aim(Vec3d target) { work_->hand.told.put(target); }

bool Touch::adjust(const Settings& settings)
{
    if (!same_tool(work_->settings, settings)) return false;
    work_->settings = settings;
    work_->live.put(live_of(settings));
    return true;
}

void Touch::stop() { work_->servo->stop(); }
void Touch::resume() { work_->servo->resume(); }
const device::Capabilities& Touch::capabilities() const { return work_->device->capabilities(); }
device::ServoCounters Touch::counters() const { return work_->servo->counters(); }

double Touch::force_limit() const
{
    const double most = capabilities().max_force;
    return most > 0 ? std::min(work_->settings.force_limit, most) : std::min(work_->settings.force_limit, 1.0);
}

double Touch::safe_stiffness() const
{
    return haptic::check_stiffness(device::safety_limits(capabilities(), 1e-3), work_->settings.stiffness,
                                   work_->settings.damping)
        .largest;
}

bool Touch::frame(TouchFrame& out)
{
    Work& w = *work_;
    out = {};
    bool any = false;
    while (w.servo->next(w.tick)) {
        any = true;
        // Both come in order; one that only one of them holds was dropped by the other.
        while (w.last.tick < w.tick.tick && w.felt.pop(w.last)) {
        }
        const bool known = w.last.tick == w.tick.tick;
        out.late = std::max(out.late, w.tick.late);
        out.degraded = out.degraded || w.tick.degraded;
        if (known) w.depth = w.last.depth;
        if (out.ticks.size() < 256)
            out.ticks.push_back({static_cast<float>(norm(w.tick.sent[0].force)), static_cast<float>(norm(w.tick.sent[0].torque)),
                                 static_cast<float>(w.depth), static_cast<float>(1e6 * w.tick.cpu)});
    }
    if (!any) return false;
    const device::ServoTick& t = w.tick;
    out.tick = t.tick;
    out.tool = t.sample.poses[0].translation;
    out.turn = t.sample.poses[0].rotation;
    out.force = t.sent[0].force;
    out.torque = t.sent[0].torque;
    out.acted = t.safety.acted;
    out.faults = t.safety.faults;
    out.engaged = t.safety.engaged;
    out.connected = t.connected;
    if (w.last.contacts == 0) return true;
    out.contacts = w.last.contacts;
    out.depth = w.last.depth;
    out.point = w.last.point;
    out.normal = w.last.normal;
    // Whose surface it is: asked below it. In a crease the middle of the contacts may lie off the surface.
    for (const double below : {2e-4, 1e-3, 2e-3, 4e-3})
        for (std::size_t i = 0; i < w.objects.size() && out.object < 0; ++i) {
            if (w.objects[i] == nullptr) continue;
            const Object& object = *w.objects[i];
            const Vec3d in_metres = out.point - below * out.normal - object.pose().translation;
            const query::Contact contact =
                query::query_point(object.metres, model::to_model_space(object.metres.header, in_metres), query::Layer::Three);
            if (!contact.contact) continue;
            out.object = static_cast<int>(i);
            out.part = contact.part;
        }
    return true;
}

}  // namespace sqmap::viewer
