// Colgate, Brown, "Factors affecting the Z-width of a haptic display", ICRA 1994 (the coupling's damping); Colgate, Schenkel,
// "Passivity of a class of sampled-data systems", J. Robotic Systems 1997 (b > K T / 2 + |B|); Abbott, Okamura, "Effects of
// position quantization and sampling rate on virtual-wall passivity", IEEE T-RO 2005.
#include "sqmap/haptic/stiffness.h"

#include "haptic/sane.h"
#include "sqmap/haptic/zone.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace sqmap::haptic {

namespace {

constexpr double k_spring_share = 0.7, k_share = 0.9;  // shares of the device's damping: for the spring; for spring and damper

double or_unknown(double reported, double unknown) { return reported > 0 ? reported : unknown; }

}  // namespace

const char* describe(StiffnessReason reason) noexcept
{
    static constexpr const char* k_names[] = {"the device's damping is too little for the tick: b > K T/2 + |B|",
                                              "the device's friction is too little for its encoder: K <= 2 f_c/Delta",
                                              "the device's damping is too little for its delay: K (T/2 + delay) + |B| < b",
                                              "virtual damping is as much as the device's own: |B| < b"};
    static_assert(std::size(k_names) == static_cast<std::size_t>(StiffnessReason::VirtualDamping) + 1,
                  "in the order of the enumeration");
    const auto i = static_cast<std::size_t>(reason);
    return i < std::size(k_names) ? k_names[i] : "unknown reason";
}

double spring_energy(double commanded, double max_force, double stiffness) noexcept
{
    if (!(stiffness > 0)) return 0;
    return commanded <= max_force ? 0.5 * commanded * commanded / stiffness
                                  : max_force * (commanded - 0.5 * max_force) / stiffness;
}

DeviceLimits with_careful_numbers(const DeviceLimits& device) noexcept
{
    DeviceLimits d = device;
    d.damping = or_unknown(device.damping, 0.1);
    d.coulomb_friction = or_unknown(device.coulomb_friction, 0.02);
    d.resolution = or_unknown(device.resolution, 50e-6);
    d.period = or_unknown(device.period, 1e-3);
    return d;
}

StiffnessCheck check_stiffness(const DeviceLimits& device, double stiffness, double virtual_damping) noexcept
{
    StiffnessCheck check;
    const bool reported = device.damping > 0 && device.coulomb_friction > 0 && device.resolution > 0;
    check.assumed = !reported;
    const DeviceLimits d = with_careful_numbers(device);
    const double b = d.damping, friction = d.coulomb_friction, resolution = d.resolution, period = d.period,
                 delay = std::max(device.delay, 0.), left = b - std::fabs(virtual_damping);
    if (!(sane(b) && sane(friction) && sane(resolution) && sane(period) && sane(device.delay) && left > 0)) {
        check.reason = StiffnessReason::VirtualDamping;
        return check;
    }
    const double by_encoder = 2 * friction / resolution;
    // Strictly less, by a share that rounding cannot eat.
    const double by_damping = (1 - 1e-9) * left / (period / 2 + delay);
    check.largest = std::min(by_encoder, by_damping);
    if (by_encoder <= by_damping)
        check.reason = StiffnessReason::Quantisation;
    else
        check.reason = delay > 0 ? StiffnessReason::Delay : StiffnessReason::Sampling;
    check.safe = stiffness >= 0 && stiffness <= check.largest;
    return check;
}

double coupling_damping(const CouplingPhysics& p) noexcept
{
    if (!(p.stiffness > 0) || !(p.mass > 0) || !(p.period > 0)) return 0;
    const double critical = 2 * std::sqrt(p.stiffness * p.mass);
    const double quiet = p.resolution > 0 ? p.friction * p.period / p.resolution : INFINITY;
    return std::max(0.,
                    std::min({critical, p.device_damping - p.stiffness * (0.5 * p.period + p.delay), p.mass / p.period, quiet}));
}

void choose_coupling(ZoneOptions& o, const DeviceLimits& device) noexcept
{
    const DeviceLimits d = with_careful_numbers(device);
    DeviceLimits spring = d;
    spring.damping *= k_spring_share;
    o.coupling_stiffness = std::min(o.coupling_stiffness, check_stiffness(spring, 0).largest);
    o.coupling_damping = coupling_damping({.stiffness = o.coupling_stiffness,
                                           .mass = o.mass,
                                           .period = d.period,
                                           .device_damping = k_share * d.damping,
                                           .delay = d.delay,
                                           .friction = d.coulomb_friction,
                                           .resolution = d.resolution});
    o.coupling_rotational = k_lever * k_lever * o.coupling_stiffness;
    o.coupling_rotational_damping = k_lever * k_lever * o.coupling_damping;
    o.resolution = device.resolution;
}

double largest_torque_share(const DeviceLimits& device, double stiffness, double reach) noexcept
{
    if (!(stiffness > 0) || !(reach > 0)) return 1;
    return std::min(1., check_stiffness(device, stiffness).largest * k_lever * k_lever / (stiffness * reach * reach));
}

}  // namespace sqmap::haptic
