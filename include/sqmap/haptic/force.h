// The elementary forces of section 6: spring, reaction, friction as printed.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/friction.h"
#include "sqmap/math/vec.h"

namespace sqmap::haptic {

/// Distances of a point, m: from its foot on the superquadric, and of the surface there by the map.
struct MapDepth {
    double foot_distance = 0, map_distance = 0;
};
/// Size of the spring force, N, for a stiffness in N/m (eq. 21).
[[nodiscard]] constexpr double spring_force(double stiffness, MapDepth m) noexcept
{
    const double depth = m.foot_distance - m.map_distance;
    return stiffness * (depth < 0 ? -depth : depth);
}

/// The reaction, N, along the unit outward surface normal; stiffness in N/m, depth in m (eq. 32, with the stiffness of eq. 21:
/// errata 10).
[[nodiscard]] constexpr Vec3d reaction_force(double stiffness, double depth, Vec3d normal) noexcept
{
    return (stiffness * depth) * normal;
}

/// Eq. 33, N: against the motion since the last frame, P_t - P_(t - dt), m. None where the point is at rest (errata 9).
[[nodiscard]] inline Vec3d printed_friction(const PrintedFriction& friction, double depth, Vec3d motion) noexcept
{
    return -friction_size(friction, depth) * normalized(motion);
}

}  // namespace sqmap::haptic
