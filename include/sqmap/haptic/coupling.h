// The parameters of Mode::Coupled and the torque that a device can show.
#pragma once

#include "sqmap/haptic/stiffness.h"
#include "sqmap/haptic/zone.h"

namespace sqmap::haptic {

/// Numbers of a coupling and of the device that carries it. SI units.
struct CouplingPhysics {
    double stiffness = 0, mass = 0, period = 0.001, device_damping = 0;  ///< N/m, kg, s, N s/m
    double delay = 0;                                                    ///< s
    double friction = 0, resolution = 0;                                 ///< f_c, N; Delta, m; resolution 0: no such bound
};

/// Damping, N s/m, of a coupling of stiffness K to a body of mass m that leaves a device of damping b passive: critical, but at
/// most b - K (T / 2 + delay) (Colgate and Brown 1994; the delay as in check_stiffness) and m / T, and so small that an encoder
/// step within a tick makes less force than the device's own friction holds, f_c T / Delta (after Abbott and Okamura 2005).
/// Rotation alike. 0 where stiffness, mass or period is not positive. Any thread.
[[nodiscard]] double coupling_damping(const CouplingPhysics& physics) noexcept;

/// Sets up Mode::Coupled for a device: lowers coupling_stiffness to the bound of check_stiffness for 7/10 of the device's
/// damping, sets coupling_damping for 9/10 of it, takes rotation as at a lever of 2 cm, and copies the device's resolution. Mass
/// and inertia stay. The careful numbers of check_stiffness stand for those that the device does not report.
void choose_coupling(ZoneOptions& options, const DeviceLimits& device) noexcept;

/// Largest torque_share with which a tool of stiffness K, N/m, and points up to `reach`, m, from its pose turns the device no
/// more stiffly than the device can show, in [0, 1]: a device of damping b at its tip is taken to turn with b (2 cm)^2. For
/// Modes Direct and Proxy; a coupling limits the torque by itself. Any thread.
[[nodiscard]] double largest_torque_share(const DeviceLimits& device, double stiffness, double reach) noexcept;

}  // namespace sqmap::haptic
