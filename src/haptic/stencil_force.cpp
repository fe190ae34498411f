// Averaging::Stencil and Ball: the force at a tip from samples on a sphere about it.
#include "contact_force.h"
#include "contact_query.h"
#include "sqmap/query/point.h"

namespace sqmap::haptic {

namespace {

/// The exact layer at a position in the world: searched, not looked up.
Sample search_exact(const TouchedBody& body, Vec3d at)
{
    const query::PointResult r =
        query::query_point(query::Body{body.model, nullptr, body.pose}, at, {.layer = query::Layer::Exact});
    if (!r.contact || (r.status & query::k_no_surface) != 0) return {};
    return {{}, r.depth * r.normal, r.normal, r.depth};
}

/// The vector from a position to the nearest surface, searched for about `offset`, another such vector.
Vec3d nearer_surface(const TouchedBody& body, Vec3d from, Vec3d offset)
{
    if (!model::has_exact(*body.model)) return offset;
    query::SurfacePoint there;
    there.point = from + offset;
    there.normal = normalized(-offset);
    const auto nearest = query::nearest_surface({body.model, nullptr, body.pose}, from, there);
    return nearest ? nearest->point - from : offset;
}

/// How far samples may have moved over the body since the last tick.
Passed passed(const ZoneTick& tick, const ContactPose& where)
{
    Passed passed;
    const TouchMemory& t = tick.touches[where.body];
    if (!where.remember || !t.known || !tick.memory.known) return passed;
    const ZoneOptions& o = tick.options;
    const Pose before = compose(inverse(t.body_before), tick.memory.points_before);
    const Pose now = compose(inverse(tick.body(where.body).pose), where.at);
    const Twist moved = twist_between(before, now, 1);
    passed.motion = norm(apply(now, tick.zone.tip) - apply(before, tick.zone.tip)) + o.smoothing.radius * norm(moved.angular);
    if (o.blend_time > 0) passed.left = std::exp(-tick.in.dt / o.blend_time);
    return passed;
}

}  // namespace

ContactForce stencil_force(ZoneTick& tick, const ContactPose& where, std::span<const query::Contact> contacts)
{
    const Zone& zone = tick.zone;
    const ZoneOptions& o = tick.options;
    const TouchedBody& body = tick.body(where.body);
    const std::size_t points = zone.probe->size(), first = std::min<std::size_t>(zone.first, points);
    const std::size_t own = std::min({std::size_t{zone.count}, points - first, tick.state.samples.size()});
    const Vec3d centre = where.at.rotation * zone.tip;
    if (own < 2) return {};
    StencilSum sum;
    sum.samples = std::span(tick.state.samples).first(own - 1);
    for (Sample& sample : sum.samples) sample = {};
    PointContact f;
    for (const query::Contact& c : contacts) {
        if (!read_contact(tick, where.body, where.at, c, f)) continue;
        const Vec3d normal = body.pose.rotation * f.normal, position = f.point - centre;
        const Sample sample{position, position + f.depth * normal, normal, f.depth};
        if (const std::size_t i = c.index - first; i < sum.samples.size())
            sum.samples[i] = sample;
        else
            sum.centre = sample;
    }
    // The depth hangs on this one point: its nearest surface is searched for, not looked up.
    const Vec3d tip = where.at.translation + centre;
    if (o.layer == query::Layer::Exact && sum.centre.depth > 0) {
        sum.centre = search_exact(body, tip);
        sum.searched = true;
    }
    const std::span<Trail> trail = tick.trail(where.body).first(own);
    const Passed since = passed(tick, where);
    sum.bound_by_neighbours(trail, since, [&](Vec3d p) { return apply(body.pose, p) - where.at.translation - centre; });
    sum.settle(o, trail[own - 1], since,
               [&](Vec3d offset) { return o.layer == query::Layer::Exact ? nearer_surface(body, tip, offset) : offset; });
    if (where.remember) {
        for (std::size_t i = 0; i < sum.samples.size(); ++i) {
            const Sample& sample = sum.samples[i];
            trail[i] = {apply_inverse(body.pose, sample.surface + where.at.translation + centre), sample.depth, true};
        }
        trail[own - 1] = {{}, sum.depth, true};
    }
    ContactForce force = sum.force(o);
    force.lever = centre;
    force.torque = cross(centre, force.force);
    if (where.remember) remember_plane(tick, where, force, norm(force.force));
    // Carves after the smoothing, which would flatten the relief. A proxy rests on the smooth surface; its spring is carved
    // (proxy.cpp).
    if (o.mode != Mode::Proxy) carve(tick, where, force);
    return force;
}

}  // namespace sqmap::haptic
