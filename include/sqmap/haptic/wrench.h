// Force and torque, velocity and angular velocity. SI units, world axes.
// Plain data: any number of threads may read it.
#pragma once

#include "sqmap/math/pose.h"

namespace sqmap::haptic {

/// Force, N, and torque about the tool's centre, N m; the world's axes.
struct Wrench {
    Vec3d force{};
    Vec3d torque{};
    friend constexpr bool operator==(const Wrench&, const Wrench&) = default;
};

/// How a tool moves: velocity of its centre, m/s, and angular velocity, rad/s; the world's axes.
struct Twist {
    Vec3d linear{};
    Vec3d angular{};
    friend constexpr bool operator==(const Twist&, const Twist&) = default;
};

/// Sums and multiples; about one centre.
[[nodiscard]] constexpr Wrench operator+(const Wrench& a, const Wrench& b) { return {a.force + b.force, a.torque + b.torque}; }
[[nodiscard]] constexpr Wrench operator*(double s, const Wrench& w) { return {s * w.force, s * w.torque}; }

}  // namespace sqmap::haptic
