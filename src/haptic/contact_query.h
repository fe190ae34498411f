// The points of a zone that are in contact with a touched body: the probe query, once per body, pose and probe in a tick.
#pragma once

#include "zone_tick.h"

#include <algorithm>

namespace sqmap::haptic {

/// The points that a zone has in this tick.
[[nodiscard]] DenserPoints points(const ZoneTick& tick);
/// Chooses those of the next tick.
void choose_points(ZoneTick& tick);

/// The contacts of the zone's probe with body s while the zone stands at `at`; other zones' too, where they share a probe. Those
/// of its edges and faces have no point: query::k_unnamed.
[[nodiscard]] std::span<const query::Contact> query_contacts(ZoneTick& tick, std::size_t s, const Pose& at);

/// Number of touching points from which on edges have no weight and are not looked for: one spring of many changes the mean
/// little, and finding it takes longer than the rest of a tick. Up to a third of that number edges have their full weight.
inline constexpr std::size_t k_points_suffice = 24;

/// The share of its weight that a contact of edges or faces has while so many points touch.
inline double share_of_edges(std::size_t points)
{
    const double n = static_cast<double>(points), enough = static_cast<double>(k_points_suffice);
    return std::clamp(1.5 * (1 - n / enough), 0., 1.);
}

/// One contact.
struct PointContact {
    Vec3d surface, normal;  ///< body's frame, m
    double depth = 0;       ///< m
    Vec3d point;            ///< of the zone, from the pose's centre, world axes
};

/// A contact that query_contacts found last with body s. False: another zone's point, or one without a surface to push to.
inline bool read_contact(ZoneTick& tick, std::size_t s, const Pose& at, const query::Contact& c, PointContact& out)
{
    const Zone& zone = tick.zone;
    const TouchedBody& body = tick.body(s);
    if (c.index != query::k_unnamed && tick.memory.points == 0 && (c.index < zone.first || c.index - zone.first >= zone.count))
        return false;
    if ((c.status & query::k_no_surface) != 0) {
        tick.report.status |= k_step_no_surface;
        return false;
    }
    out.surface = tick.state.queries[s].result.position(c);
    out.normal = cast<double>(c.normal);
    out.depth = static_cast<double>(c.depth);
    out.point = apply(body.pose, out.surface - out.depth * out.normal) - at.translation;
    return true;
}

}  // namespace sqmap::haptic
