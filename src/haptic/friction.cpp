#include "friction.h"

#include "sqmap/math/friction.h"

namespace sqmap::haptic {

Vec3d friction_force(ZoneTick& tick, std::size_t s, const Sliding& c)
{
    const ZoneOptions& o = tick.options;
    const TouchedBody& body = tick.body(s);
    const Material& material = body.material;
    TouchMemory& t = tick.touches[s];
    if (material.friction == Friction::Paper) return printed_friction({material.f_c, material.k_f}, c.depth, c.motion);
    if (material.friction != Friction::Coulomb || !(o.tangential_stiffness > 0)) return {};
    if (!t.touching) t.bristle = {}, t.stuck = true;
    if (t.stuck) t.mu = material.mu_static;
    Vec3d stretch = body.pose.rotation * t.bristle + c.motion;
    stretch -= dot(stretch, c.normal) * c.normal;
    const double pull = o.tangential_stiffness * norm(stretch);
    if (pull > t.mu * c.load) {
        t.stuck = false;
        // The release takes some ticks: the drop from one coefficient to the other would be a jump.
        const double kept = o.blend_time > 0 ? std::exp(-tick.in.dt / o.blend_time) : 0;
        t.mu = material.mu_dynamic + kept * std::max(t.mu - material.mu_dynamic, 0.);
        stretch = (t.mu * c.load / pull) * stretch;
        tick.report.status |= k_step_slipping;
    } else {
        t.stuck = true;
    }
    t.bristle = transpose_mul(body.pose.rotation, stretch);
    return -o.tangential_stiffness * stretch;
}

}  // namespace sqmap::haptic
