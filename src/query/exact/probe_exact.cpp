// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, beyond its layers: the mesh's own
// triangles, for many points at once. A cell of the locator lists every triangle that can be nearest to a point of it, so the
// nearest of its list is the nearest of all, and the side of it is the verdict.

#include "exact_layer.h"
#include "model/candidate_lists.h"
#include "model/flags.h"
#include "sqmap/math/assert.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/exact/probe_exact.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/exact/nearest_triangles-inl.h"
#include "query/probe/contacts-inl.h"
#include "query/probe/probe_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Points are queued, measured cell by cell, and written in the order in which they were queued.
class ExactKernel : ProbeWalk {
public:
    explicit ExactKernel(const ProbeJob& job) : ProbeWalk(job), contacts_(job), keeps_(job.kept != nullptr), triangles_(job.model)
    {
        const float size = model_.header.sphere[3];
        touching_ = 1e-4f * size;
        rounding_ = k_unproven * size;
    }

    ProbeResult run()
    {
        each_near<true>([&](std::size_t slot) { collect(slot); },
                        [&] {
                            if (queued_ > k_queue - Probe::k_cluster) flush();
                        },
                        [&] {
                            if (job_.first_only) flush();
                            return !job_.first_only || contacts_.count() == 0;
                        });
        flush();
        if (keeps_) keep_visited(contacts_.count());
        return contacts_.result();
    }

private:
    static constexpr std::size_t k_queue = 1024, k_capacity = k_queue + 2 * Probe::k_cluster;
    static constexpr std::size_t k_slots = 2048;  // of the table of cells: a power of two, more than the queue's room
    static constexpr std::uint32_t k_inside = 1u << 31;

    HWY_NOINLINE void collect(std::size_t slot)
    {
        DuePoints due{hn::Not(none()), false};
        if (keeps_) {
            due = due_points(slot);
            if (!any(due.which)) return;
        }
        Entered e = enter(slot, due.which);
        const M inside = is_inside(e.at.cell, e.occupied);
        divide(e.at.cell, e.at.index, e.at.offset, e.occupied);
        if (keeps_) {
            const M free = hn::AndNot(e.occupied, due.which);
            if (any(free)) keep_points(slot, clearance_of(e), free);
        }
        if (!any(e.occupied)) return;
        // Above the planes of a flat cell by more than the solid reaches there: outside.
        const M flat = is_flat(e.at.cell, hn::AndNot(inside, e.occupied));
        if (any(flat)) {
            const F below = lowest_planes(e.at.cell, e.at.offset, flat).below;
            const I code = gather_byte(model_.rises.data(), blend(flat, e.at.index, hn::Zero(di)));
            const F rise = hn::Mul(to_float(code), set(model::k_rise_step));
            const M bounded = hn::RebindMask(df, hn::Ne(code, set_int(model::k_no_rise)));
            M above = hn::And(hn::And(flat, bounded), hn::Lt(hn::Add(below, rise), hn::Zero(df)));
            // How far above does not say how far from the solid, which is what can be kept: so some are measured all the same.
            if (due.rests && spends(above)) above = none();
            e.occupied = hn::AndNot(above, e.occupied);
            if (!any(e.occupied)) return;
        }
        const I key = hn::Or(hn::Add(hn::ShiftLeft<6>(e.at.brick), e.at.within),
                             hn::IfThenElseZero(hn::RebindMask(di, inside), set_int(static_cast<std::int32_t>(k_inside))));
        const I point = hn::LoadU(di, reinterpret_cast<const std::int32_t*>(job_.point + slot));
        pack(e.p.x, e.occupied, x_ + queued_);
        pack(e.p.y, e.occupied, y_ + queued_);
        pack(e.p.z, e.occupied, z_ + queued_);
        pack(key, e.occupied, reinterpret_cast<std::int32_t*>(key_) + queued_);
        pack(point, e.occupied, reinterpret_cast<std::int32_t*>(point_) + queued_);
        if (keeps_) pack(hn::Iota(di, static_cast<std::int32_t>(slot)), e.occupied, slot_ + queued_);
        queued_ += count_of(e.occupied);
    }

    /// Cell after cell, so that the points of a vector share their triangles.
    HWY_NOINLINE void flush()
    {
        if (queued_ == 0) return;
        for (std::uint16_t& slot : slots_) slot = 0;
        std::size_t groups = 0;
        std::uint32_t last_key = 0;
        std::size_t last = 0;
        for (std::size_t i = 0; i < queued_; ++i) {
            const std::uint32_t key = key_[i];
            if (groups == 0 || key != last_key) {
                std::size_t slot = (key * 0x9e3779b1u) >> 21;
                while (slots_[slot] != 0 && group_key_[slots_[slot] - 1u] != key) slot = (slot + 1) % k_slots;
                if (slots_[slot] == 0) {
                    group_key_[groups] = key;
                    group_end_[groups] = 0;
                    slots_[slot] = static_cast<std::uint16_t>(++groups);
                }
                last = slots_[slot] - 1u;
                last_key = key;
            }
            group_[i] = static_cast<std::uint16_t>(last);
            ++group_end_[last];
        }
        std::uint16_t sum = 0;
        for (std::size_t g = 0; g < groups; ++g) {
            const std::uint16_t count = group_end_[g];
            group_end_[g] = sum;
            sum = static_cast<std::uint16_t>(sum + count);
        }
        for (std::size_t i = 0; i < queued_; ++i) order_[group_end_[group_[i]]++] = static_cast<std::uint16_t>(i);
        std::size_t first = 0;
        for (std::size_t g = 0; g < groups; ++g) {
            answer(group_key_[g], first, group_end_[g]);
            first = group_end_[g];
        }
        write();
        queued_ = 0;
    }

    /// The points order_[first, end) of one cell.
    HWY_NOINLINE void answer(std::uint32_t key, std::size_t first, std::size_t end)
    {
        const model::CandidateList list = model::candidate_list(model_, (key & ~k_inside) >> 6, key & 63u);
        const bool known_inside = (key & k_inside) != 0;
        if (list.count == 0 || has_crossed(list)) {
            for (; first < end; ++first) side_[order_[first]] = k_open;
            return;
        }
        triangles_.start(list);
        for (; first < end; first += hn::Lanes(df)) {
            const std::size_t count = std::min(hn::Lanes(df), end - first);
            HWY_ALIGN std::int32_t slots[k_lanes];
            for (std::size_t i = 0; i < hn::Lanes(df); ++i) slots[i] = order_[first + std::min(i, count - 1)];
            const I at = hn::Load(di, slots);
            const V3 p{hn::GatherIndex(df, x_, at), hn::GatherIndex(df, y_, at), hn::GatherIndex(df, z_, at)};
            settle(slots, count, known_inside, triangles_.find(p, list));
        }
    }

    /// True where another triangle cuts one of a list's: not all of it may be boundary.
    bool has_crossed(const model::CandidateList& list) const
    {
        if (model_.header.self_intersecting == 0) return false;
        bool crossed = false;
        list.each([&](std::uint32_t t) { crossed |= model::is_crossed(model_.triangle_part[t]); });
        return crossed;
    }

    /// Notes what was measured of the queue's entries, until it is written.
    HWY_NOINLINE void settle(const std::int32_t* entries, std::size_t count, bool known_inside, const Nearest& nearest)
    {
        const M lanes = hn::FirstN(df, count);
        // The side is right where all nearest triangles agree on it, be it a face, an edge or a corner that is nearest: one of
        // the faces there is what the point sees.
        const M open = known_inside ? none() : hn::And(lanes, hn::Or(nearest.unclear, hn::And(nearest.outside, nearest.inside)));
        const M inside = known_inside ? lanes : hn::AndNot(open, hn::AndNot(nearest.outside, lanes));
        if (job_.unproven != nullptr) {
            const M unproven = hn::And(lanes, hn::Le(nearest.distance_sq, set(rounding_ * rounding_)));
            if (any(unproven)) each_lane(unproven, [&](std::size_t i) { job_.unproven[point_[entries[i]]] = 1; });
        }
        HWY_ALIGN float v[5][k_lanes];
        HWY_ALIGN std::int32_t triangles[k_lanes], sides[k_lanes];
        hn::Store(nearest.distance_sq, df, v[0]);
        hn::Store(nearest.offset.x, df, v[1]);
        hn::Store(nearest.offset.y, df, v[2]);
        hn::Store(nearest.offset.z, df, v[3]);
        hn::Store(nearest.triangle, di, triangles);
        hn::Store(blend(open, set_int(k_open), blend(inside, set_int(k_inner), set_int(k_outer))), di, sides);
        if (keeps_)
            hn::Store(blend(hn::Or(open, inside), set(KeptProbe::k_always), due_after(hn::Sqrt(nearest.distance_sq))), df, v[4]);
        for (std::size_t i = 0; i < count; ++i) {
            const auto entry = static_cast<std::size_t>(entries[i]);
            for (std::size_t k = 0; k < 4; ++k) measured_[k][entry] = v[k][i];
            nearest_[entry] = triangles[i];
            side_[entry] = sides[i];
            if (keeps_) job_.kept->point_due[static_cast<std::size_t>(slot_[entry])] = v[4][i];
        }
    }

    /// The contacts among what is queued.
    HWY_NOINLINE void write()
    {
        for (std::size_t first = 0; first < queued_; first += hn::Lanes(df)) {
            const M lanes = hn::FirstN(df, std::min(queued_ - first, hn::Lanes(df)));
            const M contact = hn::And(lanes, hn::RebindMask(df, hn::Ne(hn::LoadU(di, side_ + first), set_int(k_outer))));
            if (any(contact)) write_contacts(first, contact);
        }
    }
    HWY_NOINLINE void write_contacts(std::size_t first, M contact)
    {
        // Nothing may have been measured of entries that are open.
        const M measured = hn::And(contact, hn::RebindMask(df, hn::Ne(hn::LoadU(di, side_ + first), set_int(k_open))));
        const auto column = [&](std::size_t k) { return hn::IfThenElseZero(measured, hn::LoadU(df, measured_[k] + first)); };
        const V3 offset{column(1), column(2), column(3)};
        const F depth = hn::Sqrt(column(0)), inverse = hn::Div(set(1.f), hn::Max(depth, set(1e-30f)));
        HWY_ALIGN float v[7][k_lanes];
        hn::Store(hn::Add(hn::LoadU(df, x_ + first), offset.x), df, v[0]);
        hn::Store(hn::Add(hn::LoadU(df, y_ + first), offset.y), df, v[1]);
        hn::Store(hn::Add(hn::LoadU(df, z_ + first), offset.z), df, v[2]);
        hn::Store(hn::Mul(offset.x, inverse), df, v[3]);
        hn::Store(hn::Mul(offset.y, inverse), df, v[4]);
        hn::Store(hn::Mul(offset.z, inverse), df, v[5]);
        hn::Store(depth, df, v[6]);
        each_lane(contact, [&](std::size_t i) {
            const std::size_t entry = first + i;
            if (side_[entry] == k_open) {
                answer_singly(entry, key_[entry]);
                return;
            }
            const auto triangle = static_cast<std::uint32_t>(nearest_[entry]);
            const std::uint16_t word = model_.triangle_part[triangle];
            const Vec3f normal = v[6][i] > touching_ ? Vec3f{v[3][i], v[4][i], v[5][i]} : normal_of(triangle);
            contacts_.write({{v[0][i], v[1][i], v[2][i]},
                             normal,
                             v[6][i],
                             point_[entry],
                             static_cast<std::int16_t>(model::part_of(word)),
                             v[6][i] > rounding_,
                             model::is_made_up(word) ? k_made_up : k_ok});
        });
    }

    /// How far points in free cells are from the solid at least, and points outside the grid from that; model units.
    HWY_INLINE F clearance_of(const Entered& e) const
    {
        Located at = e.at;  // or the free eighth of a divided cell
        at.gap_code = blend(at.is_free, at.gap_code, shift_right<LocatorCell::k_gap_shift>(at.cell));
        return hn::Mul(blend(in_grid(e.in_cells), gap_of(at), outside_grid(e.in_cells)), set(locator_.cell));
    }
    /// True where points are measured that need not be: a few a tick, which then rest for longer.
    bool spends(M points)
    {
        const std::size_t count = count_of(points);
        if (count > job_.kept->budget) return false;
        job_.kept->budget -= count;
        return true;
    }

    Vec3f normal_of(std::uint32_t triangle) const
    {
        const auto corner = [&](std::uint32_t k) {
            return model::vec3(model_.vertices.data() +
                               3 * static_cast<std::size_t>(model::triangle_vertex(model_, triangle, k)));
        };
        const Vec3f a = corner(0);
        return normalized(cross(corner(1) - a, corner(2) - a));
    }

    void answer_singly(std::size_t entry, std::uint32_t key)
    {
        const ModelContact c =
            query_exact_in(model_, {x_[entry], y_[entry], z_[entry]}, (key & ~k_inside) >> 6, key & 63u, (key & k_inside) != 0);
        if (!c.certain && job_.unproven != nullptr) job_.unproven[point_[entry]] = 1;
        if (c.contact) contacts_.write(contact_of(c, point_[entry]));
    }

    enum Side : std::int32_t { k_outer, k_inner, k_open };  // open: answered singly

    ContactWriter contacts_;
    float rounding_;  // distance up to which float does not prove the side
    float touching_;  // depth up to which a contact's normal is its triangle's
    std::size_t queued_ = 0;
    float x_[k_capacity], y_[k_capacity], z_[k_capacity];
    std::uint32_t key_[k_capacity], point_[k_capacity];  // 64 times the brick and the cell in it, k_inside; the probe's point
    std::uint16_t group_[k_capacity], order_[k_capacity], slots_[k_slots];
    std::uint32_t group_key_[k_capacity];
    std::uint16_t group_end_[k_capacity];
    // Squared distance of the nearest triangle and offset to it, that triangle, and the side, for each entry of the queue.
    float measured_[4][k_capacity];
    std::int32_t nearest_[k_capacity], side_[k_capacity];
    const bool keeps_;
    std::int32_t slot_[k_capacity];  // where points are kept
    NearestTriangles triangles_;
};

}  // namespace

ProbeResult run_exact(const ProbeJob& job) { return ExactKernel(job).run(); }

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(run_exact);

ProbeResult run_probe_exact(const ProbeJob& job) noexcept
{
    SQMAP_ASSERT(model::has_locator(job.model) && model::has_exact(job.model));
    return HWY_DYNAMIC_DISPATCH(run_exact)(job);
}

}  // namespace sqmap::query
#endif
