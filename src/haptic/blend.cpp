#include "push.h"

namespace sqmap::haptic {

namespace {

constexpr double k_fade = 250;  ///< N/s: the remains of a jump fade no faster, so that fading is no jump itself

/// The share of a change that is not explained.
double share_beyond(double change, double explained) { return change > explained ? 1 - explained / change : 0; }

}  // namespace

Wrench blended(ZoneTick& tick, const TickForces& f)
{
    const ZoneOptions& o = tick.options;
    ZoneMemory& m = tick.memory;
    if (!f.touching || !(o.blend_time > 0)) {
        m.left = {};
    } else if (m.was_touching) {
        // By k_fade at most: an exponential share of a large jump would be a jump itself.
        const double size = std::max(norm(m.left.force), norm(m.left.torque) / k_fade_arm);
        const double slowest = size > 0 ? 1 - k_fade * tick.in.dt / size : 0;
        m.left = std::max(std::exp(-tick.in.dt / o.blend_time), slowest) * m.left;
        const Wrench change = f.springs + -1. * m.springs_before;
        const double before = norm(m.springs_before.force), now = norm(f.springs.force), grown = now - before;
        const double across = std::sqrt(std::max(norm_sq(change.force) - grown * grown, 0.));
        const double jump = std::max({share_beyond(norm(change.force), f.explained.force),
                                      share_beyond(across, std::max(before, now) * f.explained.turn),
                                      share_beyond(norm(change.torque), f.explained.torque)});
        if (jump > 0) m.left = m.left + -jump * (f.whole + -1. * m.whole_before);
        if (norm(m.left.force) > 1e-6 * norm(f.springs.force)) tick.report.status |= k_step_blended;
    }
    m.springs_before = f.springs;
    m.whole_before = f.whole;
    m.was_touching = f.touching;
    return f.whole + m.left;
}

void add_blend_reaction(ZoneTick& tick, Vec3d centre)
{
    double total = 0;
    for (const TouchMemory& t : tick.touches) total += t.spring;
    if (!(total > 0)) return;
    for (std::size_t s = 0; s < tick.bodies(); ++s)
        tick.add_reaction(s, tick.touches[s].spring / total * tick.memory.left, centre);
}

}  // namespace sqmap::haptic
