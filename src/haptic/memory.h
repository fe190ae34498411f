// What a state remembers of zones and of their contacts with solids.
#pragma once

#include "stencil_sum.h"
#include "track.h"

namespace sqmap::haptic {

/// Springs kept for a tick without a query.
inline constexpr std::uint32_t k_kept = 64;

struct State::Touch {
    /// A contact's tangent plane in the solid and its point in the zone's frame.
    struct Plane {
        Vec3d point{}, normal{};  ///< solid's frame
        Vec3d probe{};            ///< zone's frame
        double weight = 0;
    };
    Plane planes[k_kept];
    std::uint32_t plane_count = 0;
    bool single = false;  ///< one plane stands for the zone's whole felt contact (stencils)
    Wrench braking{};     ///< before contact, of the last tick with a query
    double sink = 0;      ///< proxy: m that it lies in the surface
    double let_in = 0;    ///< proxy: m that its plane has gone in since it was felt

    Pose solid_before{};  ///< at the last step
    bool known = false;   ///< solid_before is
    Vec3d bristle{};      ///< Coulomb: how far the sticking spring is stretched, in the solid's frame
    double mu = 0;        ///< what it slips at: falls from static to dynamic once it has let go
    bool stuck = true;
    bool touching = false;
    double spring = 0;  ///< N, of this tick
};

/// A frame query that has been made in this tick.
struct State::Asked {
    const query::Probe* probe = nullptr;
    Pose pose{};
    query::Layer layer{};
    query::ProbeResult result{};
};

struct State::Memory {
    Pose body_before{};  ///< where the points stood
    Twist device_twist{};
    Track track{};       ///< of the device
    bool known = false;  ///< the above are
    Pose body{};         ///< proxy or coupled body
    Twist body_twist{};
    bool has_body = false;
    bool inside = false;  ///< proxy: the device has not been free since the proxy was put there
    /// Blending: the springs of the last tick and all that was pushed with, what is left of jumps.
    Wrench springs_before{}, whole_before{}, left{};
    bool was_touching = false;
    std::uint32_t points = 0;  ///< 0: the zone's own; i: those of denser[i - 1]
};

}  // namespace sqmap::haptic
