// The stiffest wall that a device can show without giving energy.
#pragma once

#include <cstdint>

namespace sqmap::haptic {

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

/// The device with the careful numbers of check_stiffness for those it does not report. Any thread.
[[nodiscard]] DeviceLimits with_careful_numbers(const DeviceLimits& device) noexcept;

}  // namespace sqmap::haptic
