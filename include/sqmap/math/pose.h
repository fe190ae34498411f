// Pose of a rigid body, and a sphere about it.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

namespace sqmap {

/// Pose of a body: x in the parent frame = rotation x + translation; the parent's units.
struct Pose {
    Mat3d rotation{};
    Vec3d translation{};
};

/// A point of the body, in the parent frame.
[[nodiscard]] constexpr Vec3d apply(const Pose& pose, Vec3d p) noexcept { return pose.rotation * p + pose.translation; }
/// a after b: x -> a(b(x)).
[[nodiscard]] constexpr Pose compose(const Pose& a, const Pose& b) noexcept
{
    return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}
/// Inverse of a pose whose matrix is a rotation; another matrix is transposed, not inverted. NaN stays NaN.
[[nodiscard]] constexpr Pose inverse(const Pose& pose) noexcept
{
    return {transpose(pose.rotation), -transpose_mul(pose.rotation, pose.translation)};
}

/// A ball's surface, centre and radius.
template <class Real>
struct Sphere3 {
    Vec3<Real> centre{};
    Real radius{};
};
/// In double.
using Sphere = Sphere3<double>;

/// True if all numbers of the pose are finite.
[[nodiscard]] inline bool is_finite(const Pose& pose) noexcept
{
    return is_finite(pose.rotation.row[0]) && is_finite(pose.rotation.row[1]) && is_finite(pose.rotation.row[2]) &&
           is_finite(pose.translation);
}

}  // namespace sqmap
