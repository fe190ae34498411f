// The push of all touched bodies on a zone (springs, damping, friction, braking: Modes Direct and Coupled), and blending: a jump
// of the force that motion does not explain, as at the medial axis, is spread over some ticks.
#pragma once

#include "contact_force.h"
#include "zone_tick.h"

namespace sqmap::haptic {

inline constexpr double k_free_turn = 0.001;  ///< m: the force may turn by motion over this without being a jump
inline constexpr double k_free_slope = 3;     ///< a force may change by this times stiffness times motion without being a jump
inline constexpr double k_fade_arm = 0.05;    ///< m: lever at which torque counts as force
inline constexpr double k_damping_depth = 0.001;  ///< m: deeper, damping has full strength

/// How much of the springs' change in a tick the motion explains.
struct Explained {
    double force = 0, torque = 0;  ///< N, N m
    double turn = 0;               ///< of the force, rad
};

/// A zone's forces in a tick.
struct TickForces {
    bool touching = false;
    Wrench springs{};  ///< jumps show in them
    Wrench whole{};    ///< with damping and friction
    Explained explained{};
};

/// Adds the remains of jumps to the whole wrench. Damping and friction jump with the springs, whose normal and lever they share,
/// so they are spread alike, and the wrench changes by no more than motion explains.
[[nodiscard]] Wrench blended(ZoneTick& tick, const TickForces& forces);

/// Adds the reaction of the remains of jumps, about `centre`, to each body by its share of the springs.
void add_blend_reaction(ZoneTick& tick, Vec3d centre);

struct Push {
    Wrench springs{};
    Wrench rest{};  ///< friction, braking; Mode::Direct: damping too
    Explained explained{};
    BodyLoad load{};  ///< Mode::Coupled: how the forces weaken as the body yields, and damping in its wrench
};

/// Pose and twist of the zone's points.
struct PointsMotion {
    Pose pose{};
    Twist twist{};
};
/// Sums the pushes of all touched bodies and fills the zone's report.
[[nodiscard]] Push push(ZoneTick& tick, const PointsMotion& points);

/// Modes Proxy and Coupled: give the wrench on the hand and fill the zone's report.
[[nodiscard]] Wrench proxy(ZoneTick& tick);
[[nodiscard]] Wrench coupled(ZoneTick& tick);

}  // namespace sqmap::haptic
