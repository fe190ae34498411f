// Blending: a jump of the force that motion does not explain, as at the medial axis, is spread over some ticks.
#pragma once

#include "zone_tick.h"

namespace sqmap::haptic {

inline constexpr double k_free_turn = 0.001;  ///< m: the force may turn by motion over this without being a jump
inline constexpr double k_free_slope = 3;     ///< a force may change by so many times stiffness times motion without being a jump
inline constexpr double k_fade_arm = 0.05;    ///< m: lever at which torque counts as force

/// How much of the springs' change in a tick the motion explains.
struct Explained {
    double force = 0, torque = 0;  ///< N, N m
    double turn = 0;               ///< of the force, rad
};

/// A zone's forces in a tick.
struct TickForces {
    bool touching = false;
    Wrench springs{};  ///< tell of a jump
    Wrench whole{};    ///< with damping and friction
    Explained explained{};
};

/// The whole wrench with what remains of jumps. Damping and friction, whose normal and lever jump with the springs, are spread
/// alike, so that the wrench changes by no more than motion explains.
[[nodiscard]] Wrench blended(ZoneTick& tick, const TickForces& forces);

/// The reaction of what remains of jumps about `centre`: each body's share of the springs.
void add_blend_reaction(ZoneTick& tick, Vec3d centre);

}  // namespace sqmap::haptic
