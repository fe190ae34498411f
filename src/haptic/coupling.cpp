// Colgate, Brown, "Factors affecting the Z-width of a haptic display", ICRA 1994 (b > K T / 2 + |B|); Abbott, Okamura, "Effects
// of position quantization and sampling rate on virtual-wall passivity", IEEE T-RO 2005 (an encoder's step against friction).
#include "sqmap/haptic/coupling.h"

#include <algorithm>
#include <cmath>

namespace sqmap::haptic {

namespace {

constexpr double k_spring_share = 0.7, k_share = 0.9;  // shares of the device's damping: for the spring; for spring and damper
constexpr double k_lever = 0.02;                       // m, as in SafetyFilter

}  // namespace

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
