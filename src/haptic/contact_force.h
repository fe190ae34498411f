// The force of a zone's contacts with a touched body, over the stiffness: from a query, or from the planes of the last one.
#pragma once

#include "body_load.h"
#include "contact_sum.h"
#include "zone_tick.h"

namespace sqmap::haptic {

/// A touched body and a pose of the zone's points.
struct ContactPose {
    std::size_t body = 0;   ///< touched body's number
    Pose at{};              ///< pose of the zone's points
    bool remember = false;  ///< keep planes for a tick without a query, and samples for the next one
};

/// A force with the spread of its springs over the contacts.
struct SpreadForce {
    ContactForce force;
    BodyLoad spread{};  ///< Mode::Coupled with a Patch: the mean over the contacts of springs of 1 N/m
};

/// Queries the body. Adds contacts and depth to the zone's report.
[[nodiscard]] SpreadForce contact_force(ZoneTick& tick, const ContactPose& where);
/// From the planes of the last query that was remembered.
[[nodiscard]] ContactForce plane_force(const ZoneTick& tick, std::size_t s, const Pose& at);

/// Averaging::Patch. contacts: of query_contacts.
[[nodiscard]] SpreadForce patch_force(ZoneTick& tick, const ContactPose& where, std::span<const query::Contact> contacts);
/// Averaging::Stencil and Ball.
[[nodiscard]] ContactForce stencil_force(ZoneTick& tick, const ContactPose& where, std::span<const query::Contact> contacts);

/// Keeps one plane for the whole contact, `out` metres along the force from its centre.
void remember_plane(ZoneTick& tick, const ContactPose& where, const ContactForce& force, double out);
/// Takes the body's relief off a contact that is one plane.
void carve(const ZoneTick& tick, const ContactPose& where, ContactForce& force);

}  // namespace sqmap::haptic
