// The tick: checks the input, runs each zone's mode, keeps the memory for the next tick.
#include "sqmap/haptic/step.h"

#include "contact_query.h"
#include "push.h"
#include "sqmap/math/assert.h"

namespace sqmap::haptic {

model::ModelView in_metres(const model::ModelView& model, double metres_per_unit) noexcept
{
    SQMAP_ASSERT(metres_per_unit > 0);
    // Everything in a model but these four numbers and the caller's coordinates is in model space.
    model::ModelView view = model;
    view.header.unit *= metres_per_unit;
    for (double& x : view.header.origin) x *= metres_per_unit;
    if (metres_per_unit != 1) model::forget_coordinates(view);
    return view;
}

std::size_t State::zones() const noexcept { return data_->zones.size(); }
ZoneOptions& State::options(std::size_t zone) noexcept
{
    SQMAP_ASSERT(zone < zones());
    return data_->zones[zone].options;
}
const ZoneReport& State::report(std::size_t zone) const noexcept
{
    SQMAP_ASSERT(zone < zones());
    return data_->reports[zone];
}
std::uint64_t State::degraded_steps() const noexcept { return data_->degraded_steps; }

void State::reset() noexcept
{
    for (ZoneMemory& m : data_->memory) m = {};
    for (TouchMemory& t : data_->touches) t = {};
    for (ZoneReport& r : data_->reports) r = {};
    for (Trail& t : data_->trails) t = {};
}

void ZoneTick::clear() const
{
    memory = {};
    for (TouchMemory& t : std::span(state.touches).subspan(index * state.max_touched, state.max_touched)) t = {};
    const std::size_t size = state.max_touched * state.samples.size();
    for (Trail& t : std::span(state.trails).subspan(index * size, size)) t = {};
}

namespace {

bool sound(const StepInput& in)
{
    bool sound = std::isfinite(in.dt) && in.dt > 0;
    for (const TouchedBody& body : in.touched)
        sound = sound && body.model != nullptr && is_finite(body.pose) && is_finite(body.twist);
    return sound;
}

/// Mode::Direct: the zone's points are at the device's pose.
Wrench direct(ZoneTick& tick)
{
    const Push p = push(tick, {tick.device(), tick.memory.device_twist});
    const bool touching = (tick.report.status & k_step_contact) != 0;
    const Wrench w = blended(tick, {touching, p.springs, p.springs + p.rest, p.explained});
    add_blend_reaction(tick, tick.device().translation);
    return tick.with_torque_share(w);
}

Wrench follow(ZoneTick& tick)
{
    switch (tick.options.mode) {
        case Mode::Direct: {
            const Wrench w = direct(tick);
            tick.memory.points_before = tick.device();
            tick.memory.has_body = false;
            return w;
        }
        case Mode::Proxy:
            return proxy(tick);
        case Mode::Coupled:
            return coupled(tick);
    }
    return {};
}

/// The wrench on the hand. @pre pose and twist of the zone are finite
Wrench step_zone(ZoneTick& tick)
{
    const StepInput& in = tick.in;
    const ZoneOptions& o = tick.options;
    ZoneMemory& m = tick.memory;
    ZoneReport& report = tick.report;
    const Pose& device = tick.device();
    SQMAP_ASSERT(is_finite(device));
    // After a jump the zone's memory, such as friction's stretch or a proxy behind a wall, means nothing here.
    if (m.track.jumps(device, in.dt)) {
        tick.clear();
        report.status |= k_step_teleport;
    }
    m.track.add(device, in.dt);
    m.device_twist = tick.index < in.twists.size() ? in.twists[tick.index] : m.track.twist(o.resolution);
    report.body = device;
    report.points = m.points;
    const Wrench w = follow(tick);
    report.push = o.stiffness * report.depth;
    if (o.mode == Mode::Coupled)
        report.push = std::max(report.push, o.coupling_stiffness * norm(report.body.translation - device.translation));
    m.known = true;
    if (!in.degraded) choose_points(tick);
    for (std::size_t s = 0; s < tick.bodies(); ++s) {
        tick.touches[s].body_before = tick.body(s).pose;
        tick.touches[s].known = true;
    }
    if (in.degraded) report.status |= k_step_degraded;
    if (std::isfinite(norm_sq(w.force)) && std::isfinite(norm_sq(w.torque))) return w;  // sizes count too: they may overflow
    report.status |= k_step_not_finite;
    tick.clear();
    return {};
}

}  // namespace

StepResult step(State& state, const StepInput& in, std::span<Wrench> wrenches, std::span<Wrench> on_touched) noexcept
{
    State::Data& d = *state.data_;
    StepResult result;
    for (Wrench& w : wrenches) w = {};
    for (Wrench& w : on_touched) w = {};
    for (CachedQuery& q : d.queries) q = {};  // a probe may have been moved
    if (wrenches.size() < d.zones.size() || (!on_touched.empty() && on_touched.size() < in.touched.size()))
        result.status |= k_step_short_span;
    const bool usable = sound(in);
    if (in.touched.size() > d.max_touched) result.status |= k_step_full;
    if (in.degraded) {
        ++d.degraded_steps;
        result.status |= k_step_degraded;
    }
    for (std::size_t z = 0; z < d.zones.size(); ++z) {
        ZoneTick tick{d, in, on_touched, z};
        tick.report = {};
        if (!usable || z >= in.poses.size() || !is_finite(in.poses[z]) || tick.zone.probe == nullptr ||
            (z < in.twists.size() && !is_finite(in.twists[z]))) {
            tick.report.status = k_step_not_finite;
            tick.clear();
        } else {
            const Wrench w = step_zone(tick);
            if (z < wrenches.size()) wrenches[z] = w;
        }
        result.status |= tick.report.status;
        result.contacts += tick.report.contacts;
        result.deepest = std::max(result.deepest, tick.report.deepest);
    }
    return result;
}

}  // namespace sqmap::haptic
