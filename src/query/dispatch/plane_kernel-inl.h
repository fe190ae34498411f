// Contacts on tangent planes, as layers Two and Three write them; and the kernel of layer Two: one plane a point, in one pass.
#if defined(SQMAP_QUERY_DISPATCH_PLANE_KERNEL_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_DISPATCH_PLANE_KERNEL_INL_H
#undef SQMAP_QUERY_DISPATCH_PLANE_KERNEL_INL_H
#else
#define SQMAP_QUERY_DISPATCH_PLANE_KERNEL_INL_H
#endif

#include "query/chart/seed_queue-inl.h"
#include "query/probe/contacts-inl.h"
#include "query/probe/probe_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Points, and which of them are proven to be inside.
struct QueriedPoints {
    V3 p;  // model space
    I index;
    M inside;
};

/// A plane for each, and how far the point is below; model units.
struct NearestPlanes {
    V3 normal;  // outward, unit
    F below;
    I part;
};

/// The contacts of the lanes of a mask: the feet on the planes.
HWY_INLINE void write_on_planes(const QueriedPoints& points, const NearestPlanes& on, M contact, ContactWriter& contacts)
{
    // Lanes of no contact may hold what no arithmetic should see.
    const F depth = hn::Max(hn::IfThenElseZero(contact, on.below), hn::Zero(df));
    const V3 &p = points.p, &n = on.normal;
    const V3 foot{mul_add(depth, n.x, p.x), mul_add(depth, n.y, p.y), mul_add(depth, n.z, p.z)};
    contacts.write({foot, n, depth, points.index, on.part, points.inside}, contact);
}

/// The plane that layer Two takes for the surface. A flat cell gives its first plane where that suffices, else the lowest of all
/// groups, so that no point is in contact that is free on layer Three. Another cell gives the plane of its first seed, whose word
/// counts where it says free and where the cell is inside.
class CoarsePlanes {
public:
    HWY_INLINE CoarsePlanes(const LocatorLanes& locator, I cell, const V3& offset, M occupied)
        : locator_(locator), cell_(cell), flat_(LocatorLanes::is_flat(cell, occupied)), seeded_(hn::AndNot(flat_, occupied))
    {
        const I first = blend(flat_, LocatorLanes::first_of(cell), hn::Zero(di));
        lowest_ = locator.read_planes(first, offset);
        M more = hn::And(flat_, hn::And(LocatorLanes::has_more(cell, 1), not_negative(lowest_.plane)));
        for (std::int32_t k = 1; any(more); more = hn::And(more, LocatorLanes::has_more(cell, ++k))) {
            const FlatPlanes next = locator.read_planes(hn::Add(first, blend(more, set_int(k), hn::Zero(di))), offset);
            const M lower = hn::And(more, hn::Lt(next.below, lowest_.below));
            lowest_ = {blend(lower, next.plane, lowest_.plane), blend(lower, next.below, lowest_.below)};
        }
        below_ = hn::Mul(lowest_.below, set(locator.cell()));
        if (!any(seeded_)) return;
        seed_ = locator.start_of(cell, offset, seeded_).planes;
        below_ = blend(flat_, below_, seed_.below);
    }

    /// How far points are below, model units.
    F below() const { return below_; }
    HWY_INLINE I part() const
    {
        const I part = locator_.part_of(cell_, lowest_.plane, flat_);
        return any(seeded_) ? blend(flat_, part, seed_.part) : part;
    }

    /// Points that the plane of a seed claims: it may lie outside the solid, so these are answered as on layer Three.
    M claimed(M inside) const { return hn::AndNot(inside, hn::And(seeded_, hn::Gt(below_, hn::Zero(df)))); }

    /// The contacts of the lanes of a mask that are below, or inside.
    HWY_INLINE void write(const QueriedPoints& points, M which, ContactWriter& contacts) const
    {
        const M contact = hn::And(which, hn::Or(points.inside, hn::Gt(below_, hn::Zero(df))));
        if (!any(contact)) return;
        const V3 normal = LocatorLanes::octahedral_normal<LocatorPlane::k_normal_bits>(lowest_.plane);
        write_on_planes(points, {any(seeded_) ? blend(flat_, normal, seed_.normal) : normal, below_, part()}, contact, contacts);
    }

private:
    const LocatorLanes& locator_;
    I cell_;
    M flat_, seeded_;
    FlatPlanes lowest_;
    LocatorLanes::SeedPlanes seed_{};
    F below_;
};

/// A vector of points after another, from pose to contact.
class PlaneKernel : ProbeWalk {
public:
    explicit PlaneKernel(const ProbeJob& job) : ProbeWalk(job), contacts_(job), queue_(*this, job.model, contacts_) {}

    ProbeResult run()
    {
        each_near([&](std::size_t slot) { answer(slot); },
                  [&] {
                      if (queue_.count() > SeedQueue::k_size - Probe::k_cluster) queue_.search();
                  },
                  [&] {
                      if (job_.first_only && contacts_.count() == 0) finish();
                      return !job_.first_only || contacts_.count() == 0;
                  });
        finish();
        return contacts_.result();
    }

private:
    HWY_NOINLINE void answer(std::size_t slot)
    {
        Entered e = enter(slot);
        if (!any(e.occupied)) return;
        divide(e.at.cell, e.at.index, e.at.offset, e.occupied);
        if (job_.unproven != nullptr) each_lane(e.occupied, [&](std::size_t i) { job_.unproven[job_.point[slot + i]] = 1; });
        const CoarsePlanes planes(*this, e.at.cell, e.at.offset, e.occupied);
        const I index = hn::LoadU(di, reinterpret_cast<const std::int32_t*>(job_.point + slot));
        const M inside = is_inside(e.at.cell, e.occupied), claimed = planes.claimed(inside);
        planes.write({e.p, index, inside}, hn::AndNot(claimed, e.occupied), contacts_);
        if (any(claimed))
            queue_.add({e.p, e.at.offset, e.at.cell, index, none()}, start_of(e.at.cell, e.at.offset, claimed), claimed);
    }

    void finish()
    {
        if (queue_.count() > 0) queue_.search();
    }

    ContactWriter contacts_;
    SeedQueue queue_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
