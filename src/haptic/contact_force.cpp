#include "contact_force.h"

#include "contact_query.h"

namespace sqmap::haptic {

namespace {

/// 1 at the centre of an impact sphere, 0 from its surface on, with zero slope there.
double share_of_sphere(double distance_sq, double radius)
{
    if (!(radius < INFINITY)) return 1;
    const double s = 1 - distance_sq / (radius * radius);
    return s > 0 ? s * s : 0;
}

}  // namespace

SpreadForce contact_force(ZoneTick& tick, const ContactPose& where)
{
    const std::span<const query::Contact> contacts = query_contacts(tick, where.body, where.at);
    SpreadForce out;
    if (tick.options.averaging == Averaging::Patch)
        out = patch_force(tick, where, contacts);
    else
        out.force = stencil_force(tick, where, contacts);
    tick.report.contacts += out.force.contacts;
    tick.report.deepest = std::max(tick.report.deepest, out.force.deepest);
    return out;
}

SpreadForce patch_force(ZoneTick& tick, const ContactPose& where, std::span<const query::Contact> contacts)
{
    const TouchedBody& body = tick.body(where.body);
    const Pose& at = where.at;
    const Texture* texture = body.material.texture;
    const std::size_t stride = std::max<std::size_t>(1, (contacts.size() + k_kept - 1) / k_kept);
    const double radius = tick.zone.radius;
    TouchMemory* keep = where.remember ? &tick.touches[where.body] : nullptr;
    if (keep != nullptr) keep->plane_count = 0, keep->single = false;
    ContactSum sum(tick.options);
    const std::span<const float> weights = points(tick).weights;
    const auto is_edge = [](const query::Contact& c) { return c.index == query::k_unnamed; };
    const auto edges = static_cast<std::size_t>(std::count_if(contacts.begin(), contacts.end(), is_edge));
    const double edge_weight = share_of_edges(contacts.size() - edges) * tick.state.mean_weight[tick.index][tick.memory.points];
    SpreadForce out;
    double spread_over = 0;
    PointContact f;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        if (!read_contact(tick, where.body, at, contacts[i], f)) continue;
        Spring spring{f.point, {}, f.depth, share_of_sphere(norm_sq(f.point), radius)};
        const std::uint32_t point = contacts[i].index;
        if (point < weights.size())
            spring.weight *= static_cast<double>(weights[point]);
        else if (point == query::k_unnamed)
            spring.weight *= edge_weight;
        if (!(spring.weight > 0)) continue;
        if (keep != nullptr && i % stride == 0 && keep->plane_count < k_kept)
            keep->planes[keep->plane_count++] = {f.surface, f.normal, transpose_mul(at.rotation, f.point), spring.weight};
        if (texture != nullptr) {
            const Carved c = carved(relief_at(*texture, f.surface, f.normal), f.depth, f.normal);
            spring.depth = c.depth;
            f.normal = c.normal;
        }
        spring.normal = body.pose.rotation * f.normal;
        if (!(spring.depth > 0)) continue;
        sum.add(spring);
        if (tick.options.mode == Mode::Coupled) {
            out.spread.stiffen(spring.weight, spring.normal, spring.point);
            spread_over += spring.weight;
        }
    }
    if (spread_over > 0) out.spread.scale(1 / spread_over);
    out.force = sum.force();
    return out;
}

ContactForce plane_force(const ZoneTick& tick, std::size_t s, const Pose& at)
{
    const TouchMemory& t = tick.touches[s];
    const TouchedBody& body = tick.body(s);
    ContactSum sum(tick.options);
    for (std::uint32_t i = 0; i < t.plane_count; ++i) {
        const TouchMemory::Plane& p = t.planes[i];
        const Vec3d lever = at.rotation * p.probe, point = apply_inverse(body.pose, at.translation + lever);
        const double depth = dot(p.point - point, p.normal);
        const Vec3d normal = body.pose.rotation * p.normal;
        if (!(depth > 0)) continue;
        if (t.single) {
            ContactForce force{depth, depth, depth * normal, cross(lever, depth * normal), lever, 1, depth};
            carve(tick, {s, at}, force);
            return force;
        }
        Carved c{depth, p.normal};
        if (const Texture* texture = body.material.texture; texture != nullptr)
            c = carved(relief_at(*texture, point + depth * p.normal, p.normal), depth, p.normal);
        if (c.depth > 0) sum.add({lever, body.pose.rotation * c.normal, c.depth, p.weight});
    }
    return sum.force();
}

void remember_plane(ZoneTick& tick, const ContactPose& where, const ContactForce& force, double out)
{
    const TouchedBody& body = tick.body(where.body);
    TouchMemory& keep = tick.touches[where.body];
    keep.single = true;
    keep.plane_count = 0;
    if (!(force.exact > 0) || !(norm_sq(force.force) > 0)) return;
    const Vec3d normal = transpose_mul(body.pose.rotation, normalized(force.force));
    keep.planes[0] = {apply_inverse(body.pose, where.at.translation + force.lever) + out * normal, normal,
                      transpose_mul(where.at.rotation, force.lever), 1};
    keep.plane_count = 1;
}

void carve(const ZoneTick& tick, const ContactPose& where, ContactForce& force)
{
    const ZoneOptions& o = tick.options;
    const TouchedBody& body = tick.body(where.body);
    const double size = norm(force.force);
    if (body.material.texture == nullptr || !(size > 0)) return;
    const Vec3d normal = transpose_mul(body.pose.rotation, force.force / size);
    const double below = o.averaging == Averaging::Ball ? force.depth - o.smoothing.radius : force.depth;
    const Vec3d surface = apply_inverse(body.pose, where.at.translation + force.lever) + below * normal;
    const Carved c = carved(relief_at(*body.material.texture, surface, normal), force.depth, normal);
    force.force = (size / force.depth * c.depth) * (body.pose.rotation * c.normal);
    force.torque = cross(force.lever, force.force);
    force.depth = c.depth;
}

}  // namespace sqmap::haptic
