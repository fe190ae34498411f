#include "contact_query.h"

#include "sqmap/query/contacts.h"

namespace sqmap::haptic {

namespace {

constexpr double k_denser_share = 0.75;  ///< of max_touching: so many points of a denser set are expected to touch at most

/// Memory for the contacts with a body.
std::span<query::Contact> contact_memory(State::Data& state, std::size_t s)
{
    const std::size_t size = state.found.size() / state.max_touched;
    return std::span(state.found).subspan(s * size, size);
}

/// Pose of the probe when the zone stands at `at`.
Pose probe_pose(const ZoneTick& tick, const Pose& at)
{
    if (!tick.zone.in_world) return at;
    if (same_pose(at, tick.device())) return {};
    return compose(at, inverse(tick.device()));
}

/// A contact of edges or faces as one of a point that the zone does not have.
query::Contact as_contact(const query::SurfaceContact& c, Vec3d anchor)
{
    return {.witness = cast<float>(c.witness.on_a - anchor),
            .normal = c.normal,
            .depth = c.depth,
            .index = query::k_unnamed,
            .part = c.part_a,
            .certain = c.certain};
}

/// Adds where edges and faces of the zone meet the body's, at `pose` in its frame: with no model no vertex is found once more.
void add_surfaces(ZoneTick& tick, std::size_t s, const Pose& pose, query::ProbeResult& found)
{
    const query::Probe *const body = tick.body(s).surface, *const zone = tick.zone.surface;
    if (body == nullptr || zone == nullptr || !tick.state.surfaces || found.contacts >= k_points_suffice) return;
    const std::span<query::Contact> memory = contact_memory(tick.state, s);
    const query::ContactResult r =
        query::query_contacts({nullptr, body, {}}, {nullptr, zone, pose}, {.supports = false}, *tick.state.surfaces);
    if ((r.status & query::k_full) != 0) tick.report.status |= k_step_full;
    for (const query::SurfaceContact& c : r.contacts) {
        if (found.contacts < memory.size()) memory[found.contacts] = as_contact(c, found.anchor);
        ++found.contacts;
    }
}

bool same_query(const query::QueryOptions& a, const query::QueryOptions& b)
{
    return a.layer == b.layer && a.gate == b.gate && a.offset == b.offset && a.smoothed_map == b.smoothed_map;
}

}  // namespace

DenserPoints points(const ZoneTick& tick)
{
    const std::uint32_t i = tick.memory.points;
    return i > 0 ? tick.zone.denser[i - 1] : DenserPoints{tick.zone.probe, tick.zone.weights};
}

// Denser points for the next tick while few touch, fewer where many do; the zone's own again once it is free, since what comes
// next may be a wall. Between the bounds nothing changes.
void choose_points(ZoneTick& tick)
{
    const Zone& zone = tick.zone;
    ZoneMemory& m = tick.memory;
    const std::size_t touching = tick.report.contacts;
    if (touching == 0) {
        m.points = 0;
    } else if (m.points > 0 && touching > zone.max_touching) {
        --m.points;
    } else if (m.points < zone.denser.size() && zone.options.averaging == Averaging::Patch && zone.first == 0 &&
               zone.count >= zone.probe->size()) {
        const query::Probe* next = zone.denser[m.points].probe;
        const double growth = next == nullptr ? INFINITY : double(next->size()) / double(points(tick).probe->size());
        if (growth * static_cast<double>(touching) < k_denser_share * zone.max_touching) ++m.points;
    }
}

std::span<const query::Contact> query_contacts(ZoneTick& tick, std::size_t s, const Pose& at)
{
    const query::Probe* probe = points(tick).probe;
    const Pose pose = compose(inverse(tick.body(s).pose), probe_pose(tick, at));
    const ZoneOptions& o = tick.options;
    const query::QueryOptions options{.layer = o.layer == query::Layer::One ? query::Layer::Two : o.layer,
                                      .gate = o.gate,
                                      .offset = o.offset,
                                      .smoothed_map = o.smoothed_map};
    const std::span<query::Contact> memory = contact_memory(tick.state, s);
    CachedQuery& cached = tick.state.queries[s];
    if (probe != cached.probe || !same_query(options, cached.options) || !same_pose(pose, cached.pose)) {
        query::ProbeResult r = query::query_probe({tick.body(s).model, nullptr, {}}, {nullptr, probe, pose}, options, memory);
        add_surfaces(tick, s, pose, r);
        cached = {probe, pose, options, r};
    }
    if (cached.result.contacts > memory.size()) tick.report.status |= k_step_full;
    if ((cached.result.status & query::k_not_finite) != 0) tick.report.status |= k_step_not_finite;
    return cached.result.written(memory);
}

}  // namespace sqmap::haptic
