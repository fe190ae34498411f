// I. Akinola et al., "TacSL: A Library for Visuotactile Sensor Simulation and Learning", 2024: penalty forces of taxels. Depth
// and direction are sqmap's own.
#include "sqmap/haptic/tactile.h"

#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>

namespace sqmap::haptic {

namespace {

/// On a taxel, in the touched model's frame. direction: unit, out of the model; speed: of the taxel over the model.
Vec3d force_of(const TactileOptions& o, double depth, Vec3d direction, Vec3d speed)
{
    const double along = dot(speed, direction);
    const double push = std::max(0.0, o.tactile_kn * depth - o.tactile_damping * along);
    const Vec3d slip = speed - along * direction;
    const double size = norm(slip);
    const double drag = std::min(o.tactile_kt * size, o.tactile_mu * push);
    return push * direction - (size > 0 ? drag / size : 0) * slip;
}

}  // namespace

TactileResult TactilePad::tick(const TactileTick& tick, const TactileOptions& options, std::span<Taxel> taxels) noexcept
{
    SQMAP_ASSERT(taxels.size() == size());
    std::fill(taxels.begin(), taxels.end(), Taxel{});
    TactileResult result;
    if (!is_finite(tick.pose) || !is_finite(tick.touched.pose) || !std::isfinite(tick.dt)) {
        has_last_ = false;
        result.status = query::k_not_finite;
        return result;
    }
    const Pose relative = compose(inverse(tick.touched.pose), tick.pose);  // pad's frame -> the model's
    const bool slips = has_last_ && tick.dt > 0;
    const query::Body touched{tick.touched.model, nullptr, {}}, pad{nullptr, &probe_, relative};
    const query::ProbeResult found = query::query_probe(touched, pad, options.query, contacts_);
    result.contacts = found.contacts;
    result.status = found.status;
    for (const query::Contact& c : found.written(contacts_)) {
        const Vec3d point = points_[c.index], normal = normals_[c.index];
        const Vec3d speed = slips ? (1 / tick.dt) * (apply(relative, point) - apply(last_, point)) : Vec3d{};
        const double depth = static_cast<double>(c.depth);
        const Vec3d force = transpose_mul(relative.rotation, force_of(options, depth, cast<double>(c.normal), speed));
        const double along = dot(force, normal);
        taxels[c.index] = {static_cast<float>(std::max(0.0, -along)), cast<float>(force - along * normal), c.depth};
        result.force = result.force + force;
        result.torque = result.torque + cross(point, force);
    }
    last_ = relative;
    has_last_ = true;
    return result;
}

}  // namespace sqmap::haptic
