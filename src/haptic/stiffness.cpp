// Colgate, Schenkel, "Passivity of a class of sampled-data systems", J. Robotic Systems 1997 (b > K T / 2 + |B|); Abbott,
// Okamura, "Effects of position quantization and sampling rate on virtual-wall passivity", IEEE T-RO 2005.
#include "sqmap/haptic/stiffness.h"

#include "haptic/sane.h"

#include <algorithm>

namespace sqmap::haptic {

namespace {

double or_unknown(double reported, double unknown) { return reported > 0 ? reported : unknown; }

}  // namespace

const char* describe(StiffnessReason reason) noexcept
{
    switch (reason) {
        case StiffnessReason::Sampling:
            return "the device's damping is too little for the tick: b > K T/2 + |B|";
        case StiffnessReason::Quantisation:
            return "the device's friction is too little for its encoder: K <= 2 f_c/Delta";
        case StiffnessReason::Delay:
            return "the device's damping is too little for its delay: K (T/2 + delay) + |B| < b";
        case StiffnessReason::VirtualDamping:
            return "virtual damping is as much as the device's own: |B| < b";
    }
    return "unknown reason";
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

}  // namespace sqmap::haptic
