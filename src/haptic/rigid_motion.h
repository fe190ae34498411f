// Rigid motions between ticks.
#pragma once

#include "sqmap/haptic/wrench.h"
#include "sqmap/math/rotation.h"

#include <algorithm>
#include <cmath>

namespace sqmap::haptic {

inline bool is_finite(const Twist& t) { return is_finite(t.linear) && is_finite(t.angular); }
inline bool same_pose(const Pose& a, const Pose& b) { return a.rotation == b.rotation && a.translation == b.translation; }
/// Takes a point of the parent frame into the body's.
inline Vec3d apply_inverse(const Pose& pose, Vec3d p) { return transpose_mul(pose.rotation, p - pose.translation); }

inline Twist twist_between(const Pose& before, const Pose& now, double dt)
{
    return {(now.translation - before.translation) / dt, rotation_vector(now.rotation * transpose(before.rotation)) / dt};
}

inline Vec3d velocity_at(const Twist& t, Vec3d from_centre) { return t.linear + cross(t.angular, from_centre); }

}  // namespace sqmap::haptic
