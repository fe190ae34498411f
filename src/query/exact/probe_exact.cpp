// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, beyond its layers: the mesh's own
// triangles, for many points at once. A cell of the locator lists every triangle that can be nearest to a point of it, so the
// nearest of its list is the nearest of all, and the side of it is the verdict.

#include "exact_layer.h"
#include "model/candidate_lists.h"
#include "model/flags.h"
#include "sqmap/math/assert.h"

#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/exact/probe_exact.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "math/triangles-inl.h"
#include "query/probe/contacts-inl.h"
#include "query/probe/probe_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

class ExactKernel : ProbeWalk {
public:
    explicit ExactKernel(const ProbeJob& job) : ProbeWalk(job), contacts_(job)
    {
        const float size = model_.header.sphere[3];
        tie_ = 4e-12f * size * size;
        touching_ = 1e-4f * size;
        rounding_ = k_unproven * size;
    }

    ProbeResult run()
    {
        each_near([&](std::size_t slot) { collect(slot); },
                  [&] {
                      if (queued_ > k_queue - Probe::k_cluster) flush();
                  },
                  [&] {
                      if (job_.first_only) flush();
                      return !job_.first_only || contacts_.count() == 0;
                  });
        flush();
        return contacts_.result();
    }

private:
    static constexpr std::size_t k_queue = 1024, k_capacity = k_queue + 2 * Probe::k_cluster;
    static constexpr std::size_t k_slots = 2048;  // of the table of cells: a power of two, more than the queue's room
    static constexpr std::uint32_t k_inside = 1u << 31;
    static constexpr std::size_t k_read = 1024;  // triangles of a list that are read at once

    HWY_NOINLINE void collect(std::size_t slot)
    {
        Entered e = enter(slot);
        const M inside = is_inside(e.at.cell, e.occupied);
        divide(e.at.cell, e.at.index, e.at.offset, e.occupied);
        if (!any(e.occupied)) return;
        // Above the planes of a flat cell by more than the solid reaches there: outside.
        const M flat = is_flat(e.at.cell, hn::AndNot(inside, e.occupied));
        if (any(flat)) {
            const F below = lowest_planes(e.at.cell, e.at.offset, flat).below;
            const I code = gather_byte(model_.rises.data(), blend(flat, e.at.index, hn::Zero(di)));
            const F rise = hn::Mul(to_float(code), set(model::k_rise_step));
            const M bounded = hn::RebindMask(df, hn::Ne(code, set_int(model::k_no_rise)));
            e.occupied = hn::AndNot(hn::And(hn::And(flat, bounded), hn::Lt(hn::Add(below, rise), hn::Zero(df))), e.occupied);
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
        queued_ = 0;
    }

    /// The nearest triangles so far of a vector of points, and what those that are as near within rounding say of the side.
    struct Nearest {
        F distance_sq;
        V3 offset;  // from the point to it
        I triangle;
        M outside, inside, unclear;
    };

    /// The points order_[first, end) of one cell.
    HWY_NOINLINE void answer(std::uint32_t key, std::size_t first, std::size_t end)
    {
        const model::CandidateList list = model::candidate_list(model_, (key & ~k_inside) >> 6, key & 63u);
        const bool known_inside = (key & k_inside) != 0;
        if (list.count == 0 || has_crossed(list)) {
            for (; first < end; ++first) answer_singly(order_[first], key);
            return;
        }
        const bool is_read = list.count <= k_read, is_short = list.count <= TriangleBlock::k_max;
        if (is_read) read(list, 0, list.count);
        if (is_short) prepare(triangle_, list.count);
        for (; first < end; first += hn::Lanes(df)) {
            const std::size_t count = std::min(hn::Lanes(df), end - first);
            HWY_ALIGN std::int32_t slots[k_lanes];
            for (std::size_t i = 0; i < hn::Lanes(df); ++i) slots[i] = order_[first + std::min(i, count - 1)];
            const I at = hn::Load(di, slots);
            const V3 p{hn::GatherIndex(df, x_, at), hn::GatherIndex(df, y_, at), hn::GatherIndex(df, z_, at)};
            const F zero = hn::Zero(df);
            Nearest nearest{set(1e30f), {zero, zero, zero}, hn::Zero(di), none(), none(), none()};
            if (is_short) {
                search(p, triangle_, list.count, nearest);
            } else {
                for (std::uint32_t k = 0; k < list.count; k += TriangleBlock::k_max) {
                    const auto n = std::min<std::uint32_t>(list.count - k, TriangleBlock::k_max);
                    if (!is_read) read(list, k, n);
                    const std::int32_t* block = is_read ? triangle_ + k : triangle_;
                    prepare(block, n);
                    search(p, block, n, nearest);
                }
            }
            write(p, slots, count, known_inside, nearest);
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

    /// Fills up the last vector.
    void read(const model::CandidateList& list, std::uint32_t first, std::uint32_t count)
    {
        list.read(first, count, triangle_);
        for (std::size_t k = 0; k < k_lanes; ++k) triangle_[count + k] = triangle_[count - 1];
    }

    HWY_NOINLINE void prepare(const std::int32_t* triangles, std::uint32_t count)
    {
        for (std::uint32_t k = 0; k < count; k += static_cast<std::uint32_t>(hn::Lanes(df))) {
            const I t = hn::LoadU(di, triangles + k), t3 = hn::Add(hn::Add(t, t), t);
            I corner[3];
            if (model_.triangles16.empty()) {
                for (int j = 0; j < 3; ++j) corner[j] = gather_word(model_.triangles32.data() + j, t3);
            } else {
                const I one_two = gather_pair(model_.triangles16.data(), t3);
                corner[0] = low(one_two);
                corner[1] = high(one_two);
                corner[2] = high(gather_pair(model_.triangles16.data() + 1, t3));
            }
            V3 v[3];
            for (int j = 0; j < 3; ++j) {
                const I at = hn::Add(hn::Add(corner[j], corner[j]), corner[j]);
                const float* vertices = model_.vertices.data();
                v[j] = {hn::GatherIndex(df, vertices, at), hn::GatherIndex(df, vertices + 1, at),
                        hn::GatherIndex(df, vertices + 2, at)};
            }
            block_.put(k, v[0], v[1], v[2]);
        }
    }

    /// Bounds first, without a branch; then what they leave.
    HWY_NOINLINE void search(const V3& p, const std::int32_t* triangles, std::uint32_t count, Nearest& nearest) const
    {
        HWY_ALIGN float lower[TriangleBlock::k_max][k_lanes];
        F upper = nearest.distance_sq;
        for (std::uint32_t k = 0; k < count; ++k) {
            const TriangleBlock::Position q = block_.position(k, p);
            hn::Store(q.lower_sq, df, lower[k]);
            // The foot, or else a corner.
            upper = hn::Min(upper, blend(q.above, q.lower_sq, dot(q.ap, q.ap)));
        }
        const F reach = tie_above(upper);
        std::uint64_t near = 0;
        for (std::uint32_t k = 0; k < count; ++k)
            near |= std::uint64_t{any(hn::Le(hn::Load(df, lower[k]), reach)) ? 1u : 0u} << k;
        Nearest best = nearest;
        for (; near != 0; near &= near - 1) {
            const auto k = static_cast<std::uint32_t>(std::countr_zero(near));
            const TriangleBlock::Position q = block_.position(k, p);
            const F tie = tie_above(best.distance_sq);
            F edge_sq;
            const V3 to_edge = block_.to_edges(k, q, edge_sq);
            const V3 to_face = block_.to_face(k, q);
            const V3 offset = blend(q.above, to_face, to_edge);
            const F distance_sq = blend(q.above, dot(to_face, to_face), edge_sq);
            // Only triangles near this point count, so that an answer does not depend on its neighbours.
            const M near_this = hn::Le(hn::Load(df, lower[k]), reach);
            const M level = hn::And(near_this, hn::Le(distance_sq, tie));
            // Clearly nearer than what was found before, whose side is forgotten.
            const M fresh = hn::And(near_this, hn::Lt(tie_above(distance_sq), best.distance_sq));
            // In the plane of a triangle, or without area, it says nothing of the side.
            const M in_plane = hn::Lt(hn::Mul(q.height, q.height), hn::Mul(set(0.0025f), distance_sq));
            const M outside = hn::Gt(q.height, hn::Zero(df));
            best.unclear = hn::Or(hn::AndNot(fresh, best.unclear), hn::And(level, in_plane));
            best.outside = hn::Or(hn::AndNot(fresh, best.outside), hn::And(level, outside));
            best.inside = hn::Or(hn::AndNot(fresh, best.inside), hn::AndNot(outside, level));
            // A tie goes to the triangle with the highest number, so the order of the list does not matter.
            const I triangle = set_int(triangles[k]);
            const M after = hn::RebindMask(df, hn::Gt(triangle, best.triangle));
            const M nearer = hn::And(
                near_this, hn::Or(hn::Lt(distance_sq, best.distance_sq), hn::And(hn::Eq(distance_sq, best.distance_sq), after)));
            best.distance_sq = blend(nearer, distance_sq, best.distance_sq);
            best.offset = blend(nearer, offset, best.offset);
            best.triangle = blend(nearer, triangle, best.triangle);
        }
        nearest = best;
    }

    /// Squared distances up to which a triangle is as near, for all that float tells.
    HWY_INLINE F tie_above(F distance_sq) const { return mul_add(distance_sq, set(1.02f), set(tie_)); }

    HWY_NOINLINE void write(const V3& p, const std::int32_t* slots, std::size_t count, bool known_inside, const Nearest& nearest)
    {
        const M lanes = hn::FirstN(df, count);
        // The side is right where all nearest triangles agree on it, be it a face, an edge or a corner that is nearest: one of
        // the faces there is what the point sees.
        const M open = known_inside ? none() : hn::And(lanes, hn::Or(nearest.unclear, hn::And(nearest.outside, nearest.inside)));
        const M inside = known_inside ? lanes : hn::AndNot(open, hn::AndNot(nearest.outside, lanes));
        if (job_.unproven != nullptr) {
            const M unproven = hn::And(lanes, hn::Le(nearest.distance_sq, set(rounding_ * rounding_)));
            if (any(unproven)) each_lane(unproven, [&](std::size_t i) { job_.unproven[point_[slots[i]]] = 1; });
        }
        const M candidates = hn::Or(inside, open);
        if (!any(candidates)) return;
        const F depth = hn::Sqrt(nearest.distance_sq), inverse = hn::Div(set(1.f), hn::Max(depth, set(1e-30f)));
        HWY_ALIGN float v[7][k_lanes];
        HWY_ALIGN std::int32_t triangles[k_lanes], is_open[k_lanes];
        hn::Store(hn::Add(p.x, nearest.offset.x), df, v[0]);
        hn::Store(hn::Add(p.y, nearest.offset.y), df, v[1]);
        hn::Store(hn::Add(p.z, nearest.offset.z), df, v[2]);
        hn::Store(hn::Mul(nearest.offset.x, inverse), df, v[3]);
        hn::Store(hn::Mul(nearest.offset.y, inverse), df, v[4]);
        hn::Store(hn::Mul(nearest.offset.z, inverse), df, v[5]);
        hn::Store(depth, df, v[6]);
        hn::Store(nearest.triangle, di, triangles);
        hn::Store(hn::VecFromMask(di, hn::RebindMask(di, open)), di, is_open);
        each_lane(candidates, [&](std::size_t i) {
            const auto slot = static_cast<std::size_t>(slots[i]);
            if (is_open[i] != 0) {
                answer_singly(slot, key_[slot]);
                return;
            }
            const auto triangle = static_cast<std::uint32_t>(triangles[i]);
            const std::uint16_t word = model_.triangle_part[triangle];
            const Vec3f normal = v[6][i] > touching_ ? Vec3f{v[3][i], v[4][i], v[5][i]} : normal_of(triangle);
            contacts_.write({{v[0][i], v[1][i], v[2][i]},
                             normal,
                             v[6][i],
                             point_[slot],
                             static_cast<std::int16_t>(model::part_of(word)),
                             v[6][i] > rounding_,
                             model::is_made_up(word) ? k_made_up : k_ok});
        });
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

    void answer_singly(std::size_t slot, std::uint32_t key)
    {
        const ModelContact c =
            query_exact_in(model_, {x_[slot], y_[slot], z_[slot]}, (key & ~k_inside) >> 6, key & 63u, (key & k_inside) != 0);
        if (!c.certain && job_.unproven != nullptr) job_.unproven[point_[slot]] = 1;
        if (c.contact) contacts_.write(contact_of(c, point_[slot]));
    }

    ContactWriter contacts_;
    float tie_;       // what rounding adds to a squared distance
    float rounding_;  // distance up to which float does not prove the side
    float touching_;  // depth up to which a contact's normal is its triangle's
    std::size_t queued_ = 0;
    float x_[k_capacity], y_[k_capacity], z_[k_capacity];
    std::uint32_t key_[k_capacity], point_[k_capacity];  // 64 times the brick and the cell in it, k_inside; the probe's point
    std::uint16_t group_[k_capacity], order_[k_capacity], slots_[k_slots];
    std::uint32_t group_key_[k_capacity];
    std::uint16_t group_end_[k_capacity];
    TriangleBlock block_;
    std::int32_t triangle_[k_read + k_lanes];  // of a list, or of a block of one that is longer
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
