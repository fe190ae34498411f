// I. Akinola et al., "TacSL: A Library for Visuotactile Sensor Simulation and Learning", 2024: penalty forces of taxels. Depth
// and direction are sqmap's own.
#include "math/double_targets.h"  // before Highway

#include "sqmap/haptic/tactile.h"

#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>

#ifndef SQMAP_TACTILE_JOB
#define SQMAP_TACTILE_JOB
namespace sqmap::haptic {

/// A tick as the kernel reads it.
struct TactileJob {
    const TactileOptions& options;
    Pose now, last;     ///< pad's frame -> the touched model's: at this tick and at the one before
    double inverse_dt;  ///< 1/s; 0: no slip
    std::span<const Vec3d> points, normals;
};

}  // namespace sqmap::haptic
#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "haptic/tactile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "math/double_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::haptic::HWY_NAMESPACE {
using namespace sqmap::HWY_NAMESPACE;
namespace {

constexpr std::size_t k_block = 64;

HWY_INLINE D set(double v) { return hn::Set(dd, v); }
HWY_INLINE D3 scaled(D k, const D3& v) { return {hn::Mul(k, v.x), hn::Mul(k, v.y), hn::Mul(k, v.z)}; }
HWY_INLINE D positive(D v) { return hn::IfThenElseZero(hn::Gt(v, hn::Zero(dd)), v); }
HWY_INLINE D3 apply(const Pose& pose, const D3& p)
{
    const Mat3d& r = pose.rotation;
    const Vec3d& t = pose.translation;
    return {hn::Add(dot(all(r.row[0]), p), set(t.x)), hn::Add(dot(all(r.row[1]), p), set(t.y)),
            hn::Add(dot(all(r.row[2]), p), set(t.z))};
}
HWY_INLINE D3 turned_back(const Mat3d& m, const D3& v)
{
    const auto component = [&](int k) {
        return hn::Add(hn::Add(hn::Mul(v.x, set(m.row[0][k])), hn::Mul(v.y, set(m.row[1][k]))), hn::Mul(v.z, set(m.row[2][k])));
    };
    return {component(0), component(1), component(2)};
}

struct Rows {
    HWY_ALIGN double x[k_block], y[k_block], z[k_block];
    HWY_INLINE D3 load(std::size_t i) const { return {hn::Load(dd, x + i), hn::Load(dd, y + i), hn::Load(dd, z + i)}; }
    HWY_INLINE void store(std::size_t i, const D3& v)
    {
        hn::Store(v.x, dd, x + i);
        hn::Store(v.y, dd, y + i);
        hn::Store(v.z, dd, z + i);
    }
    HWY_INLINE void put(std::size_t i, Vec3d v)
    {
        x[i] = v.x;
        y[i] = v.y;
        z[i] = v.z;
    }
    HWY_INLINE Vec3d row(std::size_t i) const { return {x[i], y[i], z[i]}; }
};

/// Contacts that are computed together: in rows, so that vectors are loaded long after they were written.
class Block {
public:
    Block(const TactileJob& job, std::span<const query::Contact> contacts) : job_(job), contacts_(contacts)
    {
        const std::size_t filled = hwy::RoundUpTo(contacts.size(), hn::Lanes(dd));
        for (std::size_t i = 0; i < filled; ++i) {
            const query::Contact& c = contacts[std::min(i, contacts.size() - 1)];
            point_.put(i, job.points[c.index]);
            normal_.put(i, job.normals[c.index]);
            direction_.put(i, cast<double>(c.normal));
            depth_[i] = static_cast<double>(c.depth);
        }
    }
    HWY_INLINE void compute()
    {
        const TactileOptions& o = job_.options;
        for (std::size_t i = 0; i < contacts_.size(); i += hn::Lanes(dd)) {
            const D3 point = point_.load(i), direction = direction_.load(i), normal = normal_.load(i);
            D3 speed = all({});
            if (job_.inverse_dt > 0) speed = scaled(set(job_.inverse_dt), minus(apply(job_.now, point), apply(job_.last, point)));
            const D away = dot(speed, direction);
            const D push =
                positive(hn::Sub(hn::Mul(set(o.tactile_kn), hn::Load(dd, depth_ + i)), hn::Mul(set(o.tactile_damping), away)));
            const D3 slip = minus(speed, scaled(away, direction));
            const D size = hn::Sqrt(dot(slip, slip)), viscous = hn::Mul(set(o.tactile_kt), size),
                    coulomb = hn::Mul(set(o.tactile_mu), push), drag = hn::IfThenElse(hn::Lt(coulomb, viscous), coulomb, viscous);
            const auto slips = hn::Gt(size, hn::Zero(dd));
            const D per_slip = hn::IfThenElseZero(slips, hn::Div(drag, hn::IfThenElse(slips, size, set(1))));
            const D3 force = turned_back(job_.now.rotation, minus(scaled(push, direction), scaled(per_slip, slip)));
            const D along = dot(force, normal);
            force_.store(i, force);
            torque_.store(i, cross(point, force));
            shear_.store(i, minus(force, scaled(along, normal)));
            hn::Store(positive(hn::Neg(along)), dd, pressed_ + i);
        }
    }
    HWY_INLINE void write(std::span<Taxel> taxels, TactileResult& result) const
    {
        for (std::size_t i = 0; i < contacts_.size(); ++i) {
            const query::Contact& c = contacts_[i];
            taxels[c.index] = {static_cast<float>(pressed_[i]), cast<float>(shear_.row(i)), c.depth};
            result.force = result.force + force_.row(i);
            result.torque = result.torque + torque_.row(i);
        }
    }

private:
    const TactileJob& job_;
    std::span<const query::Contact> contacts_;
    Rows point_, normal_, direction_;  // direction: unit, out of the model, in its frame
    Rows force_, torque_, shear_;      // the pad's frame
    HWY_ALIGN double depth_[k_block], pressed_[k_block];
};

void force_blocks(const TactileJob& job, std::span<const query::Contact> contacts, std::span<Taxel> taxels, TactileResult& result)
{
    for (std::size_t first = 0; first < contacts.size(); first += k_block) {
        Block block(job, contacts.subspan(first, std::min(k_block, contacts.size() - first)));
        block.compute();
        block.write(taxels, result);
    }
}

}  // namespace
}  // namespace sqmap::haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::haptic {

HWY_EXPORT(force_blocks);

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
    const TactileJob job{options, relative, last_, slips ? 1 / tick.dt : 0, points_, normals_};
    HWY_DYNAMIC_DISPATCH(force_blocks)(job, found.written(contacts_), taxels, result);
    last_ = relative;
    has_last_ = true;
    return result;
}

}  // namespace sqmap::haptic
#endif
