#include "viewer/server/touch/touch.h"

#include "device/handover.h"
#include "sqmap/device/simulated.h"
#include "viewer/server/touch/hand.h"

#include <algorithm>
#include <system_error>

namespace sqmap::viewer {
namespace {

constexpr int k_priority = 40;

bool same_tool(const Settings& a, const Settings& b)
{
    return a.texture == b.texture && a.smoothing == b.smoothing && a.tool_radius == b.tool_radius && a.zone == b.zone &&
           a.force_limit == b.force_limit && a.tool == b.tool && a.tool_object == b.tool_object && a.tool_size == b.tool_size &&
           a.tool_turn == b.tool_turn && a.tool_tilt == b.tool_tilt && a.paper_force == b.paper_force && a.proxy == b.proxy &&
           a.paper == b.paper && a.gate == b.gate && a.offset == b.offset && a.edges == b.edges;
}

/// Findings of a tick that the servo's own record of it lacks.
struct TickForces {
    std::uint64_t tick = 0;
    std::uint32_t number = 0;  ///< of the settings
    Forces::Found found{};
};

ForceInput force_input(const device::Sample& sample, double dt, bool degraded)
{
    return {sample.poses[0], sample.twists[0], dt, sample.has_twist, degraded};
}

}  // namespace

struct Touch::Work {
    explicit Work(Vec3d start) : hand(start) {}

    Settings settings;
    std::unique_ptr<Forces> forces;
    Hand hand;
    device::Newest<Live> live;
    device::Ring<TickForces, 1024> queue;
    TickForces now{};  ///< the servo's thread
    std::unique_ptr<device::Device> device;
    std::unique_ptr<device::Servo> servo;  // last but for what frame() reads: it ends first
    device::ServoTick tick{};
    TickForces last{};
    double depth = 0, first_time = 0;
    std::uint32_t number = 0;  ///< of the newest settings
    std::shared_ptr<Take> take;
    std::uint64_t heard = 0;  ///< the newest tick of the take

    static std::uint32_t tick_forces(void* context, const device::TickInput& input, std::span<haptic::Wrench> wrenches) noexcept;
    void keep(bool known);
};

std::uint32_t Touch::Work::tick_forces(void* context, const device::TickInput& input, std::span<haptic::Wrench> wrenches) noexcept
{
    Work& w = *static_cast<Work*>(context);
    if (w.live.take()) {
        w.forces->adjust(w.live.value());
        w.now.number = w.live.value().number;
    }
    const haptic::StepResult result = w.forces->step(force_input(input.sample, input.dt, input.degraded), wrenches[0]);
    if (!input.pushes.empty()) input.pushes[0] = w.forces->report().push;
    if (!input.stiffened.empty()) input.stiffened[0] = w.forces->stiffened();
    w.now.found = w.forces->found();
    w.now.tick = input.tick;
    (void)w.queue.push(w.now);
    return result.status;
}

/// known: the servo computed this tick and reported it.
void Touch::Work::keep(bool known)
{
    if (take == nullptr || take->ticks.size() >= k_max_recorded) return;
    const bool has_ticks = !take->ticks.empty();
    if (has_ticks && tick.tick > heard + 1) take->lost += tick.tick - heard - 1;
    heard = tick.tick;
    if (known)
        take->ticks.push_back({.input = force_input(tick.sample, tick.dt, tick.degraded),
                               .commanded = tick.commanded[0],
                               .sent = tick.sent[0],
                               .depth = last.found.depth,
                               .time = tick.time - first_time,
                               .cpu = tick.cpu,
                               .sequence = tick.sample.sequence,
                               .number = last.number,
                               .contacts = last.found.contacts,
                               .status = tick.status,
                               .buttons = tick.sample.buttons,
                               .filter = haptic::bits(tick.safety)});
    else if (has_ticks && tick.connected && tick.sample.sequence != 0)
        ++take->lost;
}

Touch::Touch(std::vector<ObjectPtr> objects, const Settings& settings, std::unique_ptr<device::Device> device, Vec3d start,
             std::shared_ptr<Take> take)
    : work_(std::make_unique<Work>(start))
{
    Work& w = *work_;
    w.settings = settings;
    if (take != nullptr) *take = {.objects = objects, .settings = {settings}, .ticks = {}, .lost = 0};
    w.take = std::move(take);
    w.forces = std::make_unique<Forces>(std::move(objects), settings);
    w.device = device != nullptr ? std::move(device) : std::make_unique<device::SimulatedDevice>(held_by(w.hand));
    device::ServoOptions options;
    const double max = w.device->capabilities().max_force;
    options.safety.force_limit = max > 0 ? std::min(settings.force_limit, max) : std::min(settings.force_limit, 1.0);
    options.signals = false;  // the program ends by itself, and the servo with it
    // Before the page and everything else where the machine lets us.
    options.priority = k_priority;
    try {
        w.servo = std::make_unique<device::Servo>(*w.device, options, Work::tick_forces, &w);
    } catch (const std::system_error&) {
        options.priority = 0;
        w.servo = std::make_unique<device::Servo>(*w.device, options, Work::tick_forces, &w);
    }
}

Touch::~Touch() = default;

void Touch::aim(Vec3d target) { work_->hand.aim(target); }

bool Touch::adjust(const Settings& settings)
{
    if (!same_tool(work_->settings, settings)) return false;
    work_->settings = settings;
    work_->live.put(live_of(settings, ++work_->number));
    if (work_->take != nullptr) work_->take->settings.push_back(settings);
    return true;
}

void Touch::stop() { work_->servo->stop(); }
void Touch::resume() { work_->servo->resume(); }
const device::Capabilities& Touch::capabilities() const { return work_->device->capabilities(); }
device::ServoCounters Touch::counters() const { return work_->servo->counters(); }

double Touch::force_limit() const
{
    const double max = capabilities().max_force;
    return max > 0 ? std::min(work_->settings.force_limit, max) : std::min(work_->settings.force_limit, 1.0);
}

double Touch::safe_stiffness() const
{
    return haptic::check_stiffness(device::safety_limits(capabilities(), 1e-3), work_->settings.stiffness,
                                   work_->settings.damping)
        .largest;
}

void Touch::end_take() { work_->take = nullptr; }

bool Touch::frame(TouchFrame& out)
{
    Work& w = *work_;
    out = {};
    bool any = false;
    while (w.servo->next(w.tick)) {
        any = true;
        // Both come in order; one that only one of them holds was dropped by the other.
        while (w.last.tick < w.tick.tick && w.queue.pop(w.last)) {
        }
        const bool known = w.last.tick == w.tick.tick;
        if (w.first_time == 0) w.first_time = w.tick.time;
        w.keep(known);
        out.late = std::max(out.late, w.tick.late);
        out.degraded = out.degraded || w.tick.degraded;
        if (known) w.depth = w.last.found.depth;
        out.cut = out.ticks.size() == 256;
        if (out.ticks.empty()) out.time = w.tick.time - w.first_time;
        if (!out.cut)
            out.ticks.push_back({static_cast<float>(norm(w.tick.sent[0].force)), static_cast<float>(norm(w.tick.sent[0].torque)),
                                 static_cast<float>(w.depth), static_cast<float>(1e6 * w.tick.cpu),
                                 static_cast<float>(w.tick.time - w.first_time - out.time)});
    }
    if (!any) return false;
    const device::ServoTick& t = w.tick;
    out.tick = t.tick;
    out.force = t.sent[0].force;
    out.torque = t.sent[0].torque;
    out.acted = t.safety.acted;
    out.faults = t.safety.faults;
    out.engaged = t.safety.engaged;
    out.connected = t.connected;
    set_contact(out, t.sample.poses[0], w.last.found, w.forces->objects());
    return true;
}

std::vector<Foot> Touch::feet(const TouchFrame& frame) const
{
    if (frame.contacts == 0 || frame.object < 0) return {};
    const query::Layer layer = work_->forces->layer_of(live_of(work_->settings, 0));
    return feet_of(*work_->forces, {frame.turn, frame.tool}, static_cast<std::size_t>(frame.object), layer);
}

}  // namespace sqmap::viewer
