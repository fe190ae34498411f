// Layer One of points: the superquadrics, and the polytopes beside them. A part holds a point if both do. Of the parts that hold
// it the one in whose superquadric it is deepest answers, for the union's surface is outside every part that holds it.
#if defined(SQMAP_QUERY_SUPERQUADRIC_LAYER_ONE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_SUPERQUADRIC_LAYER_ONE_INL_H
#undef SQMAP_QUERY_SUPERQUADRIC_LAYER_ONE_INL_H
#else
#define SQMAP_QUERY_SUPERQUADRIC_LAYER_ONE_INL_H
#endif

#include "query/probe/contacts-inl.h"
#include "query/probe/probe_walk-inl.h"

#include "query/superquadric/held-inl.h"

#include <algorithm>
#include <span>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Keeps the points that every side of a polytope holds. The sides have room for the rounding (see fit::touching_side), so no
/// point of the solid is left out.
HWY_INLINE M in_polytope(std::span<const HalfSpacef> sides, const V3& p, M which)
{
    for (const HalfSpacef& side : sides) {
        which = hn::And(which, hn::Le(row_dot(&side.normal.x, p), set(side.offset)));
        if (!any(which)) break;
    }
    return which;
}

/// Points that wait for the superquadrics, which answer one after the other.
class PointsOfLayerOne {
public:
    static constexpr std::size_t k_size = 512;

    explicit PointsOfLayerOne(const ModelView& model) : model_(model) {}

    bool is_full() const { return count_ > k_size - Probe::k_cluster; }

    /// Adds the points in the object's sphere. Superquadrics reach beyond the sphere, the solid does not.
    HWY_INLINE void add(const V3& p, I index, M which)
    {
        which = hn::And(which, in_sphere(model_.header.sphere, p));
        if (!any(which)) return;
        pack(p.x, which, p_[0] + count_);
        pack(p.y, which, p_[1] + count_);
        pack(p.z, which, p_[2] + count_);
        pack(index, which, index_ + count_);
        count_ += count_of(which);
    }
    void clear() { count_ = 0; }

    /// Computes the answers; some_only: of one vector of points that are held at least.
    HWY_NOINLINE void answer(bool some_only)
    {
        if (count_ == 0) return;
        bound();
        for (std::size_t i = 0; i < count_; i += hn::Lanes(df)) hn::StoreU(set(-1.f), df, depth_ + i);
        for (std::size_t k = 0; k < model_.parts.size(); ++k)
            if (reaches(model_.parts[k]) && answer_by(static_cast<std::int32_t>(k), some_only) && some_only) return;
    }

    /// take(lanes, which) for vectors of contacts, model space.
    template <class Take>
    HWY_INLINE void each_contact(Take&& take) const
    {
        for (std::size_t i = 0; i < count_; i += hn::Lanes(df)) {
            const F depth = hn::LoadU(df, depth_ + i);
            const M held = hn::And(present(i), hn::Ge(depth, hn::Zero(df)));
            if (any(held))
                take(ContactLanes{load(surface_, i), load(normal_, i), depth, hn::LoadU(di, index_ + i), hn::LoadU(di, part_ + i),
                                  none()},
                     held);
        }
    }

private:
    static constexpr std::size_t k_capacity = k_size + k_max_lanes;
    using Rows = float[3][k_capacity];

    static HWY_INLINE V3 load(const Rows& from, std::size_t i)
    {
        return {hn::LoadU(df, from[0] + i), hn::LoadU(df, from[1] + i), hn::LoadU(df, from[2] + i)};
    }
    HWY_INLINE M present(std::size_t i) const { return hn::FirstN(df, count_ - i); }
    static HWY_INLINE M in_sphere(const float* sphere, const V3& p)
    {
        const V3 d = minus(p, {set(sphere[0]), set(sphere[1]), set(sphere[2])});
        return hn::Le(dot(d, d), set(sphere[3] * sphere[3]));
    }

    /// The box of the points; the last one fills up its vector.
    void bound()
    {
        for (int k = 0; k < 3; ++k) {
            for (std::size_t i = count_; i % hn::Lanes(df) != 0; ++i) p_[k][i] = p_[k][count_ - 1];
            F low = hn::LoadU(df, p_[k]), high = low;
            for (std::size_t i = hn::Lanes(df); i < count_; i += hn::Lanes(df)) {
                const F v = hn::LoadU(df, p_[k] + i);
                low = hn::Min(low, v);
                high = hn::Max(high, v);
            }
            low_[k] = hn::GetLane(hn::MinOfLanes(df, low));
            high_[k] = hn::GetLane(hn::MaxOfLanes(df, high));
        }
    }
    /// A part's sphere and the box of the points, with a margin for rounding.
    bool reaches(const model::Part& part) const
    {
        float square = 0;
        for (int k = 0; k < 3; ++k) {
            const float c = part.sphere[k], d = c - std::clamp(c, low_[k], high_[k]);
            square += d * d;
        }
        return square <= 1.0001f * part.sphere[3] * part.sphere[3];
    }

    /// True where the part holds one of the points.
    HWY_NOINLINE bool answer_by(std::int32_t number, bool some_only)
    {
        const model::Part& part = model_.parts[static_cast<std::size_t>(number)];
        const SuperquadricLanes sq(model::superquadric_of(part));
        const std::span<const HalfSpacef> polytope = model::polytope_of(model_, static_cast<std::size_t>(number));
        boxed_ = 0;
        for (std::size_t i = 0; i < count_; i += hn::Lanes(df)) {
            const V3 p = load(p_, i);
            const M near = hn::And(present(i), in_sphere(part.sphere, p));
            if (!any(near)) continue;
            const V3 unit = sq.to_unit(sq.to_local(p));
            M inside = hn::And(near, in_box(unit));
            if (!any(inside)) continue;
            inside = in_polytope(polytope, p, inside);
            if (!any(inside)) continue;
            pack(unit.x, inside, unit_[0] + boxed_);
            pack(unit.y, inside, unit_[1] + boxed_);
            pack(unit.z, inside, unit_[2] + boxed_);
            pack(hn::Iota(di, static_cast<std::int32_t>(i)), inside, slot_ + boxed_);
            boxed_ += count_of(inside);
        }
        bool some = false;
        for (std::size_t i = 0; i < boxed_; i += hn::Lanes(df)) {
            some = leave(sq, i, number) || some;
            if (some && some_only) break;
        }
        return some;
    }

    /// A vector of the points in the box.
    HWY_INLINE bool leave(const SuperquadricLanes& sq, std::size_t first, std::int32_t number)
    {
        const M there = hn::FirstN(df, boxed_ - first);
        const F one = set(1.f);
        HeldLanes point;
        point.unit = blend(there, load(unit_, first), {one, one, one});
        const M held = hn::And(there, holds(sq, point));
        if (!any(held)) return false;
        const I slot = blend(there, hn::LoadU(di, slot_ + first), hn::Zero(di));
        const V3 p{hn::GatherIndex(df, p_[0], slot), hn::GatherIndex(df, p_[1], slot), hn::GatherIndex(df, p_[2], slot)};
        const LeavingLanes found = leaving(sq, p, point.own);
        const M deeper = hn::And(held, hn::Gt(found.distance, hn::GatherIndex(df, depth_, slot)));
        HWY_ALIGN float values[7][k_lanes];
        hn::Store(found.distance, df, values[0]);
        hn::Store(found.point.x, df, values[1]);
        hn::Store(found.point.y, df, values[2]);
        hn::Store(found.point.z, df, values[3]);
        hn::Store(found.normal.x, df, values[4]);
        hn::Store(found.normal.y, df, values[5]);
        hn::Store(found.normal.z, df, values[6]);
        each_lane(deeper, [&](std::size_t i) {
            const auto s = static_cast<std::size_t>(slot_[first + i]);
            depth_[s] = values[0][i];
            for (std::size_t k = 0; k < 3; ++k) {
                surface_[k][s] = values[1 + k][i];
                normal_[k][s] = values[4 + k][i];
            }
            part_[s] = number;
        });
        return true;
    }

    const ModelView& model_;
    std::size_t count_ = 0, boxed_ = 0;
    Rows p_, surface_, normal_, unit_;
    float depth_[k_capacity];  ///< negative: nothing holds the point
    std::int32_t index_[k_capacity], part_[k_capacity], slot_[k_capacity];
    float low_[3], high_[3];
};

/// The points of a probe that are not in free cells of the locator.
class LayerOneKernel : ProbeWalk {
public:
    explicit LayerOneKernel(const ProbeJob& job) : ProbeWalk(job), contacts_(job), points_(job.model) {}

    ProbeResult run()
    {
        each_near([&](std::size_t slot) { collect(slot); },
                  [&] {
                      if (points_.is_full()) finish();
                  },
                  [&] {
                      // Some superquadric holds a point of the solid.
                      if (job_.first_only && inside_) finish();
                      return !job_.first_only || contacts_.count() == 0;
                  });
        if (!job_.first_only || contacts_.count() == 0) finish();
        return contacts_.result();
    }

private:
    HWY_NOINLINE void collect(std::size_t slot)
    {
        Entered e = enter(slot);
        if (!any(e.occupied)) return;
        divide(e.at.cell, e.at.index, e.at.offset, e.occupied);
        if (!any(e.occupied)) return;
        inside_ = inside_ || any(is_inside(e.at.cell, e.occupied));
        points_.add(e.p, hn::LoadU(di, reinterpret_cast<const std::int32_t*>(job_.point + slot)), e.occupied);
    }

    void finish()
    {
        points_.answer(job_.first_only);
        points_.each_contact([&](const ContactLanes& lanes, M held) { contacts_.write(lanes, held); });
        points_.clear();
        inside_ = false;
    }

    ContactWriter contacts_;
    PointsOfLayerOne points_;
    bool inside_ = false;  ///< one of the points is in the solid
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
