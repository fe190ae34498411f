// The limits of a device that gives no energy: the stiffest wall, the parameters of Mode::Coupled, and the torque.
#pragma once

#include <cstdint>

namespace sqmap::haptic {

struct ZoneOptions;

/// Limits and mechanics of a device, from its maker's data sheet. Zero means unknown: a careful number stands in.
struct DeviceLimits {
    double max_force = 0;         ///< N
    double max_torque = 0;        ///< N m
    double continuous_force = 0;  ///< N, root mean square over 10 s; unknown: half the limit in force
    double damping = 0;           ///< b, N s/m
    double coulomb_friction = 0;  ///< f_c, N
    double resolution = 0;        ///< Delta, m
    double delay = 0;             ///< s from a pose to the force that answers it, besides the tick itself
    double period = 1e-3;         ///< T, s, of a tick
    double sample_period = 1e-3;  ///< s between fresh poses
};

/// The smallest of the bounds of a stable wall.
enum class StiffnessReason : std::uint8_t {
    Sampling,        ///< b > K T/2 + |B| (Colgate and Schenkel 1997): too little damping for the period
    Quantisation,    ///< K <= 2 f_c/Delta (Abbott and Okamura 2005): too little friction for the encoder
    Delay,           ///< K (T/2 + delay) + |B| < b: too little damping for the delay
    VirtualDamping,  ///< |B| >= b: no stiffness at all is safe
};
/// A sentence for people. Any thread.
[[nodiscard]] const char* describe(StiffnessReason reason) noexcept;

/// Verdict on a stiffness for a device.
struct StiffnessCheck {
    bool safe = false;                                   ///< the requested stiffness is at most largest
    double largest = 0;                                  ///< N/m, the largest safe K
    StiffnessReason reason = StiffnessReason::Sampling;  ///< the bound that sets largest
    bool assumed = false;                                ///< a careful number stands for one that the device does not report
};

/// The stiffness that a device can show without ever being able to give energy, whoever holds it: the smaller of 2 f_c/Delta and
/// (b - |B|)/(T/2 + delay), which without delay is Colgate's bound and without B Abbott and Okamura's 2b/T. virtual_damping is B,
/// N s/m. Unknown b, f_c, Delta: 0.1 N s/m, 0.02 N, 50 um. Not safe where a number is not finite or |B| >= b. Any thread.
[[nodiscard]] StiffnessCheck check_stiffness(const DeviceLimits& device, double stiffness, double virtual_damping = 0) noexcept;

/// J that a spring of stiffness K, N/m, gives back from where it commands a force, N, on, where no more than max_force is
/// exerted; of a spring in rotation with torques and N m/rad. 0 without a stiffness. Any thread.
[[nodiscard]] double spring_energy(double commanded, double max_force, double stiffness) noexcept;

/// The device with the careful numbers of check_stiffness for those it does not report. Any thread.
[[nodiscard]] DeviceLimits with_careful_numbers(const DeviceLimits& device) noexcept;

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
