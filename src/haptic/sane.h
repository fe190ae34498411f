// Lengths, forces and times of haptic devices: which are in range, and the lever of a spring that turns.
#pragma once

#include "sqmap/haptic/wrench.h"

#include <cmath>

namespace sqmap::haptic {

inline constexpr double k_absurd = 1e9;  ///< beyond any length, force or time of a haptic device: counts as not finite
inline constexpr double k_lever = 0.02;  ///< m: a spring that turns is as stiff as one of K at the end of it

/// False for NaN, without a floating-point exception.
inline bool sane(double x) { return std::islessequal(std::fabs(x), k_absurd); }
inline bool sane(const Vec3d& v) { return sane(v.x) && sane(v.y) && sane(v.z); }
inline bool sane(const Pose& p)
{
    return sane(p.translation) && sane(p.rotation.row[0]) && sane(p.rotation.row[1]) && sane(p.rotation.row[2]);
}
inline bool sane(const Twist& t) { return sane(t.linear) && sane(t.angular); }
inline bool sane(const Wrench& w) { return sane(w.force) && sane(w.torque); }

}  // namespace sqmap::haptic
