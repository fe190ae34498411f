// Mode::Direct: the zone's points are at the device's pose.
#include "modes.h"
#include "push.h"

namespace sqmap::haptic {

Wrench direct(ZoneTick& tick)
{
    const Push p = push(tick, {tick.device(), tick.memory.device_twist});
    const bool touching = (tick.report.status & k_step_contact) != 0;
    const Wrench w = blended(tick, {touching, p.springs, p.springs + p.rest, p.explained});
    add_blend_reaction(tick, tick.device().translation);
    return tick.with_torque_share(w);
}

}  // namespace sqmap::haptic
