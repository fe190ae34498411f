// The memory of a state: of its zones and of their contacts with touched bodies.
#pragma once

#include "sqmap/haptic/step.h"
#include "stencil_sum.h"
#include "track.h"

#include <vector>

namespace sqmap::haptic {

/// Springs kept for a tick without a query.
inline constexpr std::uint32_t k_kept = 64;

/// Memory of a zone's contact with a touched body.
struct TouchMemory {
    /// A contact's tangent plane in the body and its point in the zone's frame.
    struct Plane {
        Vec3d point{}, normal{};  ///< body's frame
        Vec3d probe{};            ///< zone's frame
        double weight = 0;
    };
    Plane planes[k_kept];
    std::uint32_t plane_count = 0;
    bool single = false;  ///< one plane stands for the zone's whole contact (stencils)
    Wrench braking{};     ///< before contact, of the last tick with a query
    double sink = 0;      ///< proxy: depth at which it rests, m
    double let_in = 0;    ///< proxy: m that its plane has receded since its last contact

    Pose body_before{};  ///< of the touched body at the last step
    bool known = false;  ///< body_before is set
    Vec3d bristle{};     ///< Coulomb: stretch of the sticking spring, in the body's frame
    double mu = 0;       ///< coefficient at which it slips: falls from static to dynamic after release
    bool stuck = true;
    bool touching = false;
    double spring = 0;  ///< N, of this tick
};

/// The probe query of a touched body in this tick.
struct CachedQuery {
    const query::Probe* probe = nullptr;
    Pose pose{};
    query::QueryOptions options{};
    query::ProbeResult result{};
};

/// Memory of a zone.
struct ZoneMemory {
    Pose points_before{};  ///< pose of the zone's points at the last step
    Twist device_twist{};
    Track track{};       ///< of the device
    bool known = false;  ///< the members above are set
    Pose body{};         ///< proxy or coupled body
    Twist body_twist{};
    bool has_body = false;
    bool inside = false;  ///< proxy: the device has not been free since the proxy was placed
    Vec3d side{};         ///< proxy, side_path: unit, out of the surface on the side that it came from; zero while free
    /// Blending: springs and total of the last tick, and what remains of jumps.
    Wrench springs_before{}, whole_before{}, left{};
    bool was_touching = false;
    std::uint32_t points = 0;  ///< 0: the zone's own; i: those of denser[i - 1]
};

struct State::Data {
    std::vector<Zone> zones;
    std::vector<ZoneReport> reports;
    std::vector<ZoneMemory> memory;
    std::vector<TouchMemory> touches;  ///< zone by touched body
    std::size_t max_touched = 0;
    std::vector<query::Contact> found;  ///< touched body by contact
    std::vector<CachedQuery> queries;   ///< per touched body
    std::vector<Sample> samples;        ///< of one stencil
    std::vector<Trail> trails;          ///< zone by touched body by sample
    std::uint64_t degraded_steps = 0;
};

}  // namespace sqmap::haptic
