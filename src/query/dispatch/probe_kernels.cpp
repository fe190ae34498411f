// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, for many points at once. Compiled
// for each instruction set by Highway (J. Wassenberg et al.); no fused multiply-add, so that all give the same bits.
#include "query/dispatch/run_probe.h"

#include "query/layer.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/dispatch/probe_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "plane_kernel-inl.h"
#include "query/chart/seed_queue-inl.h"
#include "query/locator/flat-inl.h"
#include "query/probe/contacts-inl.h"
#include "query/probe/probe_walk-inl.h"
#include "query/superquadric/layer_one-inl.h"

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Layers Three and Gate of a probe: its points are collected, their cells read, flat cells answered by planes, the others
/// by the charts. Between two queries others use the caches, and what a query mostly does is wait for cells: so nothing is read
/// right after its address is known.
class ProbeKernel : ProbeWalk {
public:
    explicit ProbeKernel(const ProbeJob& job)
        : ProbeWalk(job), contacts_(job), lowest_planes_(*this), queue_(*this, job.model, contacts_)
    {
    }

    ProbeResult run()
    {
        each_near([&](std::size_t slot) { collect(slot); },
                  [&] {
                      // Between clusters only, whatever a vector holds of one: the order of the answers is the same for all.
                      if (addressed_.count > k_addressed - Probe::k_cluster) read_cells();
                  },
                  [&] {
                      if (job_.first_only) finish();
                      return !job_.first_only || contacts_.count() == 0;
                  });
        finish();
        return contacts_.result();
    }

private:
    static_assert(Probe::k_cluster <= k_max_lanes);  // LocatedPoints has space for a cluster beyond its size
    static constexpr std::size_t k_addressed = 256;
    static constexpr std::int32_t k_whole = std::numeric_limits<std::int32_t>::min();  ///< of a cell's index: it is a brick

    void finish()
    {
        read_cells();
        answer_located();
        if (queue_.count() > 0) queue_.search();
    }

    /// Poses a vector of points from a slot on, keeps those whose cells have to be read, side by side, and has these fetched.
    HWY_NOINLINE void collect(std::size_t slot)
    {
        const Posed e = pose(slot);
        const Address a = address(e.in_cells, e.in_grid);
        const M read = hn::AndNot(a.free_brick, e.in_grid);
        if (!any(read)) return;
        fetch(model_.locator_cells.data(), a.index, read);
        const I whole = hn::IfThenElseZero(hn::RebindMask(di, a.whole), set_int(k_whole));
        addressed_.add(e.p, a.offset, hn::Or(a.index, whole),
                       hn::LoadU(di, reinterpret_cast<const std::int32_t*>(job_.point + slot)), read);
    }

    /// Reads the cells of the points that were collected and keeps those that may be inside.
    HWY_NOINLINE void read_cells()
    {
        if (located_.count > LocatedPoints::k_size - k_addressed) answer_located();
        for (std::size_t first = 0; first < addressed_.count; first += hn::Lanes(df)) {
            const I word = hn::LoadU(di, addressed_.cell + first);
            const M present = addressed_.present(first), whole = hn::RebindMask(df, hn::Lt(word, hn::Zero(di)));
            const I cell = gather_word(model_.locator_cells.data(),
                                       hn::IfThenElseZero(hn::RebindMask(di, present), hn::And(word, set_int(~k_whole))));
            const M occupied = hn::AndNot(is_free(cell, whole), present);
            if (!any(occupied)) continue;
            fetch_next(cell, occupied);
            located_.add(LocatedPoints::load(addressed_.p, first), LocatedPoints::load(addressed_.offset, first), cell,
                         hn::LoadU(di, addressed_.point + first), occupied);
        }
        addressed_.count = 0;
    }

    /// Fetches the words that the next step reads: planes of flat cells, eighths of divided ones.
    HWY_INLINE void fetch_next(I cell, M occupied) const
    {
        const M divided = is_divided(cell, occupied), flat = is_flat(cell, occupied);
        const I at = first_of(cell);
        if (any(divided)) fetch(model_.locator_cells.data(), at, divided);
        if (any(flat)) fetch(model_.planes.data(), at, flat);
    }

    HWY_NOINLINE void answer_located()
    {
        if (queue_.count() > SeedQueue::k_size - LocatedPoints::k_size) queue_.search();
        for (std::size_t first = 0; first < located_.count; first += hn::Lanes(df)) {
            V3 offset = LocatedPoints::load(located_.offset, first);
            I cell = hn::LoadU(di, located_.cell + first), index = hn::Zero(di);
            M occupied = located_.present(first);
            const M divided = is_divided(cell, occupied);
            divide(cell, index, offset, occupied);
            if (any(divided)) fetch_next(cell, hn::And(divided, occupied));
            if (job_.unproven != nullptr) mark_unproven(first, occupied);
            if (job_.layer == Layer::Gate) occupied = hn::AndNot(answer_coarsely(first, offset, cell, occupied), occupied);
            const M flat = is_flat(cell, occupied), seeded = hn::AndNot(flat, occupied);
            if (any(seeded)) answer_by_seeds(first, offset, cell, seeded);
            located_.set(first, offset, hn::IfThenElseZero(hn::RebindMask(di, flat), cell));
        }
        lowest_planes_.find(located_,
                            [&](std::size_t first, M flat, const FlatPlanes& lowest) { write_flat(first, flat, lowest); });
        located_.count = 0;
    }

    /// Marks the points that the locator does not prove free.
    HWY_NOINLINE void mark_unproven(std::size_t first, M occupied) const
    {
        each_lane(occupied, [&](std::size_t i) { job_.unproven[located_.point[first + i]] = 1; });
    }

    /// Section 4.2, step 4: points near parts for which layer 3 is not worth its time, as on layer Two. Returns which these are.
    HWY_NOINLINE M answer_coarsely(std::size_t first, const V3& offset, I cell, M occupied)
    {
        const CoarsePlanes planes(*this, cell, offset, occupied);
        HWY_ALIGN std::int32_t parts[k_lanes], dense[k_lanes];
        hn::Store(planes.part(), di, parts);
        for (std::size_t i = 0; i < hn::Lanes(df); ++i) {
            const auto index = static_cast<std::size_t>(parts[i]);
            dense[i] = index < model_.parts.size() && !passes_gate(model_.parts[index], job_.gate) ? -1 : 0;
        }
        const M inside = is_inside(cell, occupied);
        const M coarse =
            hn::AndNot(planes.claimed(inside), hn::And(occupied, hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, dense)))));
        planes.write({LocatedPoints::load(located_.p, first), hn::LoadU(di, located_.point + first), inside}, coarse, contacts_);
        return coarse;
    }

    HWY_INLINE void answer_by_seeds(std::size_t first, const V3& offset, I cell, M seeded)
    {
        queue_.add({LocatedPoints::load(located_.p, first), offset, cell, hn::LoadU(di, located_.point + first),
                    is_inside(cell, seeded)},
                   start_of(cell, offset, seeded), seeded);
    }

    HWY_INLINE void write_flat(std::size_t first, M flat, const FlatPlanes& lowest)
    {
        const I cell = hn::LoadU(di, located_.cell + first);
        const F below = hn::Mul(lowest.below, set(locator_.cell));
        const M inside = is_inside(cell, flat), contact = hn::Or(inside, hn::And(flat, hn::Gt(below, hn::Zero(df))));
        if (any(contact))
            write_on_planes(
                {LocatedPoints::load(located_.p, first), hn::LoadU(di, located_.point + first), inside},
                {octahedral_normal<LocatorPlane::k_normal_bits>(lowest.plane), below, part_of(cell, lowest.plane, contact)},
                contact, contacts_);
    }

    ContactWriter contacts_;
    LocatedPoints addressed_;  // whose cells have to be read: their indices
    LocatedPoints located_;    // in cells that are not free
    LowestPlanes lowest_planes_;
    SeedQueue queue_;
};

}  // namespace

ProbeResult run(const ProbeJob& job)
{
    if (job.layer == Layer::One) return LayerOneKernel(job).run();
    return job.layer == Layer::Two ? PlaneKernel(job).run() : ProbeKernel(job).run();
}

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(run);

ProbeResult run_probe(const ProbeJob& job) noexcept { return HWY_DYNAMIC_DISPATCH(run)(job); }

}  // namespace sqmap::query
#endif
