// The elementary forces of section 6: spring, reaction, friction as printed.
#pragma once

#include "sqmap/math/friction.h"
#include "sqmap/math/vec.h"

namespace sqmap::haptic {

/// Size of the spring force, N, of a point whose foot on the superquadric is foot_distance away and whose map there says
/// map_distance (eq. 21); m, N/m.
struct MapDepth {
    double foot_distance = 0, map_distance = 0;
};
[[nodiscard]] constexpr double spring_force(double stiffness, MapDepth m) noexcept
{
    const double depth = m.foot_distance - m.map_distance;
    return stiffness * (depth < 0 ? -depth : depth);
}

/// The reaction along the unit outward surface normal (eq. 32, with the stiffness of eq. 21: errata 10).
[[nodiscard]] constexpr Vec3d reaction_force(double stiffness, double depth, Vec3d normal) noexcept
{
    return (stiffness * depth) * normal;
}

/// Eq. 33: against the motion since the last frame, P_t - P_(t - dt). None where the point is still (errata 9).
[[nodiscard]] inline Vec3d printed_friction(const PrintedFriction& friction, double depth, Vec3d motion) noexcept
{
    return -friction_size(friction, depth) * normalized(motion);
}

}  // namespace sqmap::haptic
