// Laws of friction, shared by rigid tools and cloth.
#pragma once

#include "sqmap/math/vec.h"

#include <cstdint>

namespace sqmap {

/// How a surface resists sliding. Coefficients stand where the law is used (haptic::Material, sim::Fabric, sim::ClothOptions).
enum class Friction : std::uint8_t {
    None,
    Coulomb,  ///< sticks while the tangential force is within mu_static times the normal force, then slips at mu_dynamic
    Paper,    ///< eq. 33 as printed: f_c (1 + k_f depth) against the motion, whatever the load; none at rest (errata 9)
};

/// Eq. 33's constants.
struct PrintedFriction {
    double f_c = 0, k_f = 0;  ///< N, 1/m
};
/// Size of the force of eq. 33, N, at a penetration depth in metres. Any thread.
[[nodiscard]] constexpr double friction_size(const PrintedFriction& friction, double depth) noexcept
{
    return friction.f_c * (1 + friction.k_f * depth);
}
/// Eq. 33, N: against the motion since the last frame, P_t - P_(t - dt), m. None where the point is at rest (errata 9). Any
/// thread.
[[nodiscard]] inline Vec3d printed_friction(const PrintedFriction& friction, double depth, Vec3d motion) noexcept
{
    return -friction_size(friction, depth) * normalized(motion);
}

}  // namespace sqmap
