// Where a probe's points are in a model's locator: what is far is dropped, cluster after cluster, by the places' gaps.
#if defined(SQMAP_QUERY_LOCATE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_LOCATE_INL_H
#undef SQMAP_QUERY_LOCATE_INL_H
#else
#define SQMAP_QUERY_LOCATE_INL_H
#endif

#include "frame_job.h"
#include "lanes-inl.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using model::ModelView;
using model::PlaceKind;

class Places {
public:
    explicit Places(const FrameJob& job) : job_(job), model_(job.model), locator_(job.model.locator)
    {
        inverse_cell_ = 1.f / locator_.cell;
        for (int k = 0; k < 3; ++k) cells_[k] = static_cast<float>(model::k_brick * locator_.bricks[k]);
    }

    /// Calls ask(slot) for a vector of points from each slot on that may touch the solid; after_cluster() when a cluster of them
    /// is done and after_group() for a group, which ends the walk by false.
    template <class Ask, class AfterCluster, class AfterGroup>
    HWY_INLINE void each_near(Ask&& ask, AfterCluster&& after_cluster, AfterGroup&& after_group) const
    {
        if (job_.points == 0 || is_far(job_.sphere[0], job_.sphere[1], job_.sphere[2], job_.sphere[3])) return;
        for (std::size_t g = 0; g < job_.groups; ++g) {
            if (job_.groups > 1 && is_far(job_.group_x[g], job_.group_y[g], job_.group_z[g], job_.group_radius[g])) continue;
            const std::size_t last = std::min(job_.clusters, (g + 1) * Probe::k_cluster);
            for (std::size_t c = g * Probe::k_cluster; c < last; c += hn::Lanes(df)) {
                const M near = hn::And(near_clusters(c), hn::FirstN(df, std::min(last - c, hn::Lanes(df))));
                each_lane(near, [&](std::size_t i) {
                    for (std::size_t k = 0; k < Probe::k_cluster; k += hn::Lanes(df)) ask((c + i) * Probe::k_cluster + k);
                    after_cluster();
                });
            }
            if (!after_group()) return;
        }
    }

    Vec3f transformed(float x, float y, float z) const
    {
        const float* r = job_.rotation;
        return {r[0] * x + r[1] * y + r[2] * z + job_.translation[0], r[3] * x + r[4] * y + r[5] * z + job_.translation[1],
                r[6] * x + r[7] * y + r[8] * z + job_.translation[2]};
    }

    /// True where no point of a sphere (of the probe) is in the solid, by the locator's gap about its centre.
    HWY_NOINLINE bool is_far(float x, float y, float z, float radius) const
    {
        const Vec3f c = transformed(x, y, z);
        const float reach = radius * job_.scale;
        float outside_sq = 0.f;
        int at[3];
        Vec3f g;
        for (int k = 0; k < 3; ++k) {
            const float in_cells = (c[k] - locator_.origin[k]) * inverse_cell_;
            g[k] = std::clamp(in_cells, 0.f, cells_[k]);
            const float gap = (in_cells - g[k]) * locator_.cell;
            outside_sq += gap * gap;
            at[k] = std::min(static_cast<int>(g[k]), static_cast<int>(cells_[k]) - 1);
        }
        // Also where the sum overflows.
        if (!(outside_sq <= reach * reach * 1.0001f)) return true;
        const auto* n = locator_.bricks;
        const std::uint32_t brick = model_.bricks[(static_cast<std::size_t>(at[2] / model::k_brick) * n[1] +
                                                   static_cast<std::size_t>(at[1] / model::k_brick)) *
                                                      n[0] +
                                                  static_cast<std::size_t>(at[0] / model::k_brick)];
        if ((brick & model::k_free_brick) == 0) return false;
        const float half = 0.5f * model::k_brick;
        const auto middle = [&](int k) { return static_cast<float>(at[k] / model::k_brick * model::k_brick) + half; };
        const Vec3f d{g.x - middle(0), g.y - middle(1), g.z - middle(2)};
        const float away = (static_cast<float>(brick & ~model::k_free_brick) * model::k_gap_step - norm(d)) * locator_.cell;
        return away > 0.f && away * away + outside_sq > reach * reach * 1.0001f;
    }

    /// The clusters from first on that may touch the solid: the same test, finer, for each lane.
    HWY_NOINLINE M near_clusters(std::size_t first) const
    {
        const F zero = hn::Zero(df);
        const V3 c = posed(
            {hn::LoadU(df, job_.centre_x + first), hn::LoadU(df, job_.centre_y + first), hn::LoadU(df, job_.centre_z + first)});
        const F reach = hn::Mul(hn::LoadU(df, job_.radius + first), set(job_.scale));
        const F reach_sq = hn::Mul(hn::Mul(reach, reach), set(1.0001f));
        const V3 g = in_cells(c);
        // Clamped below the last cell's end, so that truncation stays within.
        const V3 at{hn::Min(hn::Max(g.x, zero), set(cells_[0] - 0.001f)), hn::Min(hn::Max(g.y, zero), set(cells_[1] - 0.001f)),
                    hn::Min(hn::Max(g.z, zero), set(cells_[2] - 0.001f))};
        const V3 out{hn::Sub(g.x, at.x), hn::Sub(g.y, at.y), hn::Sub(g.z, at.z)};
        const F outside_sq = hn::Mul(dot(out, out), set(locator_.cell * locator_.cell));
        const M touches_box = hn::Le(outside_sq, reach_sq);
        if (!any(touches_box)) return touches_box;
        const Located found = locate(at, touches_box);
        const M far_away = hn::And(found.is_free, hn::Gt(found.gap, zero));
        const F away = hn::Mul(found.gap, set(locator_.cell));
        return hn::AndNot(hn::And(far_away, hn::Gt(mul_add(away, away, outside_sq), reach_sq)), touches_box);
    }

    HWY_INLINE V3 posed(const V3& local) const
    {
        const float* r = job_.rotation;
        return {hn::Add(row_dot(r, local), set(job_.translation[0])), hn::Add(row_dot(r + 3, local), set(job_.translation[1])),
                hn::Add(row_dot(r + 6, local), set(job_.translation[2]))};
    }

    HWY_INLINE V3 in_cells(const V3& p) const
    {
        const F scale = set(inverse_cell_);
        return {hn::Mul(hn::Sub(p.x, set(locator_.origin[0])), scale), hn::Mul(hn::Sub(p.y, set(locator_.origin[1])), scale),
                hn::Mul(hn::Sub(p.z, set(locator_.origin[2])), scale)};
    }

    /// The place under each lane.
    struct Located {
        M is_free;
        F gap;      // lower bound of the distance to the solid where it is free, in cells
        I place;    // its word, where it is not
        V3 offset;  // from its centre, in cells
        I brick;    // index
        I within;   // of the place in its brick, 0 of a deep one
    };
    /// at: in cells, within the grid for active lanes.
    HWY_INLINE Located locate(const V3& at, M active) const
    {
        const I nil = hn::Zero(di);
        const I ix = blend(active, truncate(at.x), nil), iy = blend(active, truncate(at.y), nil),
                iz = blend(active, truncate(at.z), nil);
        const I nx = set_int(static_cast<std::int32_t>(locator_.bricks[0])),
                ny = set_int(static_cast<std::int32_t>(locator_.bricks[1]));
        const I bx = shift_right<2>(ix), by = shift_right<2>(iy), bz = shift_right<2>(iz);
        const I brick_index = hn::Add(hn::Mul(hn::Add(hn::Mul(bz, ny), by), nx), bx);
        const I brick = gather_word(model_.bricks.data(), brick_index);
        const M free_brick = hn::AndNot(not_negative(brick), active);
        const M whole = hn::Or(free_brick, hn::RebindMask(df, hn::Ne(hn::And(brick, set_int(model::k_deep_brick)), nil)));
        const I three = set_int(3);
        const I within =
            hn::Add(hn::ShiftLeft<2>(hn::Add(hn::ShiftLeft<2>(hn::And(iz, three)), hn::And(iy, three))), hn::And(ix, three));
        const I low_bits = hn::And(brick, set_int(0x3fffffff));
        I place = gather_word(model_.places.data(),
                              blend(hn::AndNot(free_brick, active), hn::Add(low_bits, blend(whole, nil, within)), nil));
        Located found;
        const F half = blend(whole, set(0.5f * model::k_brick), set(0.5f));
        const auto from_centre = [&](F v, I cell, I brick_at) {
            return hn::Sub(v, hn::Add(to_float(blend(whole, hn::ShiftLeft<2>(brick_at), cell)), half));
        };
        found.offset = {from_centre(at.x, ix, bx), from_centre(at.y, iy, by), from_centre(at.z, iz, bz)};
        // Divided places, the kind and the list in one: into the eighth that holds the point.
        const I divided_bits = set_int(static_cast<std::int32_t>(model::k_divided_place << 2) | 3);
        M divided = hn::AndNot(whole, hn::And(active, equal(hn::And(place, set_int(0x3fff)), divided_bits)));
        float quarter = 0.25f;
        for (int k = 0; k < model::k_most_divisions && any(divided); ++k) {
            const F zero = hn::Zero(df);
            const M up_x = hn::Ge(found.offset.x, zero), up_y = hn::Ge(found.offset.y, zero), up_z = hn::Ge(found.offset.z, zero);
            const I eighth =
                hn::Add(blend(up_x, set_int(1), nil), hn::Add(blend(up_y, set_int(2), nil), blend(up_z, set_int(4), nil)));
            place = blend(divided,
                          gather_word(model_.places.data(), blend(divided, hn::Add(shift_right<14>(place), eighth), nil)), place);
            const auto move = [&](M up, F v) { return blend(divided, hn::Sub(v, blend(up, set(quarter), set(-quarter))), v); };
            found.offset = {move(up_x, found.offset.x), move(up_y, found.offset.y), move(up_z, found.offset.z)};
            divided = hn::And(divided, equal(hn::And(place, set_int(0x3fff)), divided_bits));
            quarter *= 0.5f;
        }
        const M free_place = hn::AndNot(whole, equal(hn::And(place, three), nil));
        found.is_free = hn::Or(free_brick, hn::And(active, free_place));
        found.place = place;
        found.brick = brick_index;
        found.within = blend(whole, nil, within);
        const I code = blend(free_brick, hn::And(brick, set_int(0x7fffffff)), shift_right<2>(place));
        found.gap = hn::Sub(hn::Mul(to_float(code), set(model::k_gap_step)), hn::Sqrt(dot(found.offset, found.offset)));
        return found;
    }

    /// A plane of a seed for each lane.
    struct Planes {
        I part;
        V3 normal;  // outward, unit
        F gap;      // how far the point is below, model units
        F length;   // how far the place's centre is
    };
    HWY_INLINE Planes planes_of(I direction, I extent, const V3& offset) const
    {
        constexpr int bits = model::k_seed_normal_bits;
        const I mask = set_int((1 << bits) - 1);
        const F step = set(2.f / static_cast<float>(1 << bits)), half = set(0.5f), one = set(1.f), zero = hn::Zero(df);
        const F x = hn::Sub(hn::Mul(hn::Add(to_float(hn::And(shift_right<8>(direction), mask)), half), step), one);
        const F y = hn::Sub(hn::Mul(hn::Add(to_float(hn::And(shift_right<8 + bits>(direction), mask)), half), step), one);
        const F z = hn::Sub(hn::Sub(one, hn::Abs(x)), hn::Abs(y)), fold = hn::Max(hn::Neg(z), zero);
        const V3 n{blend(hn::Lt(x, zero), hn::Add(x, fold), hn::Sub(x, fold)),
                   blend(hn::Lt(y, zero), hn::Add(y, fold), hn::Sub(y, fold)), z};
        const F inverse = hn::Div(one, hn::Sqrt(dot(n, n)));
        Planes planes;
        planes.part = hn::And(direction, set_int(0xff));
        planes.normal = {hn::Mul(n.x, inverse), hn::Mul(n.y, inverse), hn::Mul(n.z, inverse)};
        planes.length = hn::Mul(to_float(hn::Sub(hn::And(extent, set_int(0xffff)), set_int(0x8000))),
                                set(model::k_seed_distance_step * locator_.cell));
        planes.gap = hn::Sub(planes.length, hn::Mul(dot(planes.normal, offset), set(locator_.cell)));
        return planes;
    }

    /// The lowest plane of the lanes whose place is flat, and the extent of its first seed. Returns those lanes.
    HWY_INLINE M lowest_planes(const Located& at, M occupied, Planes& lowest, I& first_extent) const
    {
        const auto* words = reinterpret_cast<const std::uint32_t*>(model_.seeds.data());
        I word = blend(occupied, hn::ShiftLeft<1>(shift_right<14>(at.place)), hn::Zero(di));
        I direction = gather_word(words, word), extent = gather_word(words + 1, word);
        first_extent = extent;
        const M flat = hn::And(occupied, hn::RebindMask(df, hn::Ne(hn::And(extent, set_int(model::k_flat)), hn::Zero(di))));
        if (!any(flat)) return flat;
        lowest = planes_of(direction, extent, at.offset);
        Planes group = lowest;
        lowest.gap = set(INFINITY);
        const auto close_group = [&](M which) {
            const M lower = hn::And(which, hn::Lt(group.gap, lowest.gap));
            lowest.gap = blend(lower, group.gap, lowest.gap);
            lowest.normal = blend(lower, group.normal, lowest.normal);
            lowest.part = blend(lower, group.part, lowest.part);
        };
        for (M more = hn::And(flat, not_negative(extent)); any(more); more = hn::And(more, not_negative(extent))) {
            word = hn::Add(word, blend(more, set_int(2), hn::Zero(di)));
            direction = gather_word(words, word);
            extent = gather_word(words + 1, word);
            const Planes next = planes_of(direction, extent, at.offset);
            const M joined = hn::RebindMask(df, hn::Ne(hn::And(extent, set_int(model::k_joined)), hn::Zero(di)));
            const M fresh = hn::AndNot(joined, more);
            close_group(fresh);
            // The first of a group, or higher than it.
            const M taken = hn::Or(fresh, hn::And(more, hn::Gt(next.gap, group.gap)));
            group.gap = blend(taken, next.gap, group.gap);
            group.normal = blend(taken, next.normal, group.normal);
            group.part = blend(taken, next.part, group.part);
        }
        close_group(flat);
        return flat;
    }

    /// The points from a slot on that are in places which are not Free.
    struct Entered {
        V3 p;  // model space
        Located at;
        M occupied;
        M inside;  // their places are wholly in the solid
    };
    /// False where there are none.
    HWY_INLINE bool enter(std::size_t slot, Entered& e) const
    {
        e.p = posed({hn::LoadU(df, job_.x + slot), hn::LoadU(df, job_.y + slot), hn::LoadU(df, job_.z + slot)});
        const V3 g = in_cells(e.p);
        const F zero = hn::Zero(df);
        M in_grid = hn::And(hn::And(hn::Ge(g.x, zero), hn::Ge(g.y, zero)), hn::Ge(g.z, zero));
        in_grid = hn::And(
            in_grid, hn::And(hn::And(hn::Lt(g.x, set(cells_[0])), hn::Lt(g.y, set(cells_[1]))), hn::Lt(g.z, set(cells_[2]))));
        // The padding of the last cluster is nobody.
        if (slot + hn::Lanes(df) > job_.points)
            in_grid = hn::And(in_grid, hn::FirstN(df, job_.points > slot ? job_.points - slot : 0));
        if (!any(in_grid)) return false;
        e.at = locate(g, in_grid);
        e.occupied = hn::AndNot(e.at.is_free, in_grid);
        const I kind = hn::And(e.at.place, set_int(3));
        e.inside = hn::And(e.occupied, equal(kind, set_int(static_cast<std::int32_t>(PlaceKind::Inside))));
        return any(e.occupied);
    }

    const FrameJob& job_;
    const ModelView& model_;
    const model::Locator& locator_;
    float inverse_cell_;
    float cells_[3];
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
