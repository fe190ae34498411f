// Friction of section 6 as printed.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/friction.h"
#include "sqmap/math/vec.h"

namespace sqmap::haptic {

/// Eq. 33, N: against the motion since the last frame, P_t - P_(t - dt), m. None where the point is at rest (errata 9).
[[nodiscard]] inline Vec3d printed_friction(const PrintedFriction& friction, double depth, Vec3d motion) noexcept
{
    return -friction_size(friction, depth) * normalized(motion);
}

}  // namespace sqmap::haptic
