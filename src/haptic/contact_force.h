// The force of a zone's contacts with a touched body, over the stiffness: from a query, or from the planes of the last one.
#pragma once

#include "contact_sum.h"
#include "rigid_motion.h"
#include "zone_tick.h"

namespace sqmap::haptic {

/// A damper of b, N s/m, along a unit normal at a lever; away: minus the velocity, m/s, of the body it is fixed to.
struct Damper {
    double b = 0;
    Vec3d away{}, normal{}, lever{};
};

/// Force and torque about the body's centre now, and how they weaken as it yields.
struct BodyLoad {
    Wrench wrench{};
    double stiffness[6][6] = {};  ///< positive semi-definite: minus the derivative by (translation, rotation)

    /// A spring of k, N/m, along unit n at the lever r.
    void stiffen(double k, Vec3d n, Vec3d r)
    {
        const Vec3d t = cross(r, n);
        const double j[6] = {n.x, n.y, n.z, t.x, t.y, t.z};
        for (int a = 0; a < 6; ++a)
            for (int b = 0; b < 6; ++b) stiffness[a][b] += k * j[a] * j[b];
    }
    /// Two such springs in the plane across n.
    void stiffen_across(double k, Vec3d n, Vec3d r)
    {
        const Vec3d other = std::fabs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, t = normalized(cross(n, other));
        stiffen(k, t, r);
        stiffen(k, cross(n, t), r);
    }
    void scale(double by)
    {
        for (auto& row : stiffness)
            for (double& x : row) x *= by;
    }
    /// k times other's springs.
    void add(double k, const BodyLoad& other)
    {
        for (int a = 0; a < 6; ++a)
            for (int b = 0; b < 6; ++b) stiffness[a][b] += k * other.stiffness[a][b];
    }
    /// Adds a damper along each of other's springs, with its force at the end of a step of dt.
    void damp(const Damper& d, double dt, const BodyLoad& other)
    {
        add(d.b / dt, other);
        const Vec3d push = -d.b * dot(d.away, d.normal) * d.normal;
        wrench = wrench + Wrench{push, cross(d.lever, push)};
    }
};

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
