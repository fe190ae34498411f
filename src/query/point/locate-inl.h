// Where a probe's points are in a model's locator: what is far is dropped, cluster after cluster, by the places' gaps.
#if defined(SQMAP_QUERY_LOCATE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_LOCATE_INL_H
#undef SQMAP_QUERY_LOCATE_INL_H
#else
#define SQMAP_QUERY_LOCATE_INL_H
#endif

#include "math/lanes-inl.h"
#include "model/locator_cells.h"
#include "probe_job.h"

#include <hwy/cache_control.h>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;
using model::LocatorCellKind;
using model::ModelView;

static_assert(Probe::k_cluster % k_lanes == 0);

/// A flat place's plane that counts, for each lane: its word, and how far the point is below, in cells.
struct FlatPlanes {
    I plane;
    F gap;
};

class Places {
public:
    static constexpr std::size_t k_groups_at_once = 16;

    explicit Places(const ProbeJob& job) : job_(job), model_(job.model), locator_(job.model.locator)
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
        for (std::size_t first = 0; first < job_.groups; first += k_groups_at_once) {
            // What their clusters' centres are in is fetched for all before it is read for one.
            std::uint32_t near_groups = 0;
            const std::size_t end = std::min(job_.groups, first + k_groups_at_once);
            for (std::size_t g = first; g < end; ++g) {
                if (job_.groups > 1 && is_far(job_.group_x[g], job_.group_y[g], job_.group_z[g], job_.group_radius[g])) continue;
                near_groups |= 1u << (g - first);
                each_vector(g, [&](std::size_t c, std::size_t) { fetch_clusters(c); });
            }
            for (std::size_t g = first; g < end; ++g) {
                if ((near_groups >> (g - first) & 1u) == 0) continue;
                each_vector(g, [&](std::size_t c, std::size_t count) {
                    const M near = hn::And(near_clusters(c), hn::FirstN(df, count));
                    each_lane(near, [&](std::size_t i) {
                        for (std::size_t k = 0; k < Probe::k_cluster; k += hn::Lanes(df)) ask((c + i) * Probe::k_cluster + k);
                        after_cluster();
                    });
                });
                if (!after_group()) return;
            }
        }
    }

    /// The clusters of a group by whole vectors: their first, and how many there are.
    template <class Do>
    HWY_INLINE void each_vector(std::size_t group, Do&& action) const
    {
        const std::size_t last = std::min(job_.clusters, (group + 1) * Probe::k_cluster);
        for (std::size_t c = group * Probe::k_cluster; c < last; c += hn::Lanes(df)) action(c, std::min(last - c, hn::Lanes(df)));
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

    /// Clusters from one on, where their centres are in the grid or nearest to it.
    struct Centres {
        V3 at;  // in cells
        F reach_sq, outside_sq;
        M touches_box;
    };
    HWY_INLINE Centres centres(std::size_t first) const
    {
        const F zero = hn::Zero(df);
        const V3 c = posed(
            {hn::LoadU(df, job_.centre_x + first), hn::LoadU(df, job_.centre_y + first), hn::LoadU(df, job_.centre_z + first)});
        const F reach = hn::Mul(hn::LoadU(df, job_.radius + first), set(job_.scale));
        Centres found;
        found.reach_sq = hn::Mul(hn::Mul(reach, reach), set(1.0001f));
        const V3 g = in_cells(c);
        // Clamped below the last cell's end, so that truncation stays within.
        const auto within = [&](F v, int k) { return hn::Min(hn::Max(v, zero), set(cells_[k] - 0.001f)); };
        found.at = {within(g.x, 0), within(g.y, 1), within(g.z, 2)};
        const V3 out = minus(g, found.at);
        found.outside_sq = hn::Mul(dot(out, out), set(locator_.cell * locator_.cell));
        found.touches_box = hn::Le(found.outside_sq, found.reach_sq);
        return found;
    }

    HWY_NOINLINE void fetch_clusters(std::size_t first) const
    {
        const Centres c = centres(first);
        if (!any(c.touches_box)) return;
        const Address a = address(c.at, c.touches_box);
        fetch(model_.places.data(), a.index, hn::AndNot(a.free_brick, c.touches_box));
    }

    /// The clusters from first on that may touch the solid: the same test, finer, for each lane.
    HWY_NOINLINE M near_clusters(std::size_t first) const
    {
        const Centres c = centres(first);
        if (!any(c.touches_box)) return c.touches_box;
        const Located found = locate(c.at, c.touches_box);
        const F gap = gap_of(found);
        const M far_away = hn::And(found.is_free, hn::Gt(gap, hn::Zero(df)));
        const F away = hn::Mul(gap, set(locator_.cell));
        return hn::AndNot(hn::And(far_away, hn::Gt(mul_add(away, away, c.outside_sq), c.reach_sq)), c.touches_box);
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
        I gap_code;
        I place;    // its word, where it is not free
        I index;    // of that word
        V3 offset;  // from its centre, in cells
        I brick;    // index
        I within;   // of the place in its brick, 0 of a deep one
    };
    /// Where a lane's place is written, before it is read.
    struct Address {
        M free_brick, whole;  // whole: the brick is one place, or free
        I gap_code;           // of free bricks
        I index;              // of the place's word; 0 where the brick is free
        V3 offset;            // from the place's centre, in cells
        I brick;              // index
        I within;             // of the place in its brick, 0 of a deep one
    };
    /// at: in cells, within the grid for active lanes.
    HWY_INLINE Address address(const V3& at, M active) const
    {
        const I nil = hn::Zero(di);
        const I ix = blend(active, truncate(at.x), nil), iy = blend(active, truncate(at.y), nil),
                iz = blend(active, truncate(at.z), nil);
        const I nx = set_int(static_cast<std::int32_t>(locator_.bricks[0])),
                ny = set_int(static_cast<std::int32_t>(locator_.bricks[1]));
        const I bx = shift_right<2>(ix), by = shift_right<2>(iy), bz = shift_right<2>(iz);
        Address a;
        a.brick = hn::Add(hn::Mul(hn::Add(hn::Mul(bz, ny), by), nx), bx);
        const I brick = gather_word(model_.bricks.data(), a.brick);
        a.free_brick = hn::AndNot(not_negative(brick), active);
        a.whole = hn::Or(a.free_brick, hn::RebindMask(df, hn::Ne(hn::And(brick, set_int(model::k_deep_brick)), nil)));
        const I three = set_int(3);
        const I within =
            hn::Add(hn::ShiftLeft<2>(hn::Add(hn::ShiftLeft<2>(hn::And(iz, three)), hn::And(iy, three))), hn::And(ix, three));
        a.within = blend(a.whole, nil, within);
        a.index = blend(hn::AndNot(a.free_brick, active), hn::Add(hn::And(brick, set_int(0x3fffffff)), a.within), nil);
        a.gap_code = hn::And(brick, set_int(0x7fffffff));
        const F half = blend(a.whole, set(0.5f * model::k_brick), set(0.5f));
        const auto from_centre = [&](F v, I cell, I brick_at) {
            return hn::Sub(v, hn::Add(to_float(blend(a.whole, hn::ShiftLeft<2>(brick_at), cell)), half));
        };
        a.offset = {from_centre(at.x, ix, bx), from_centre(at.y, iy, by), from_centre(at.z, iz, bz)};
        return a;
    }
    HWY_INLINE Located locate(const V3& at, M active) const
    {
        const Address a = address(at, active);
        Located found;
        found.place = gather_word(model_.places.data(), a.index);
        found.is_free = hn::Or(a.free_brick, hn::And(active, is_free(found.place, a.whole)));
        found.offset = a.offset;
        found.index = a.index;
        found.brick = a.brick;
        found.within = a.within;
        found.gap_code = blend(a.free_brick, a.gap_code, shift_right<2>(found.place));
        return found;
    }
    static HWY_INLINE M is_free(I place, M whole) { return hn::AndNot(whole, equal(hn::And(place, set_int(3)), hn::Zero(di))); }

    static HWY_INLINE M is_divided(I place, M which)
    {
        return hn::And(
            which, equal(hn::And(place, set_int(0x7ff)), set_int(static_cast<std::int32_t>(model::k_divided_place << 2) | 3)));
    }

    /// Points in divided places: into the eighth that holds them. Takes those off the mask where that is free.
    HWY_INLINE void divide(I& place, I& index, V3& offset, M& occupied) const
    {
        const I nil = hn::Zero(di);
        float quarter = 0.25f;
        M divided = is_divided(place, occupied);
        for (int k = 0; k < model::k_max_divisions && any(divided); ++k) {
            const F zero = hn::Zero(df);
            const M up_x = hn::Ge(offset.x, zero), up_y = hn::Ge(offset.y, zero), up_z = hn::Ge(offset.z, zero);
            const I eighth =
                hn::Add(blend(up_x, set_int(1), nil), hn::Add(blend(up_y, set_int(2), nil), blend(up_z, set_int(4), nil)));
            index = blend(divided, hn::Add(shift_right<14>(place), eighth), index);
            place = blend(divided, gather_word(model_.places.data(), index), place);
            const auto move = [&](M up, F v) { return blend(divided, hn::Sub(v, blend(up, set(quarter), set(-quarter))), v); };
            offset = {move(up_x, offset.x), move(up_y, offset.y), move(up_z, offset.z)};
            occupied = hn::AndNot(hn::And(divided, equal(hn::And(place, set_int(3)), nil)), occupied);
            divided = is_divided(place, hn::And(divided, occupied));
            quarter *= 0.5f;
        }
    }

    /// Where it is free: a lower bound of the distance to the solid, in cells.
    HWY_INLINE static F gap_of(const Located& found)
    {
        return hn::Sub(hn::Mul(to_float(found.gap_code), set(model::k_gap_step)), hn::Sqrt(dot(found.offset, found.offset)));
    }

    /// A vector out of the octahedron's square, not yet of unit length; see model/octahedral.h.
    template <int bits>
    HWY_INLINE static V3 octahedral(I code)
    {
        const I mask = set_int((1 << bits) - 1);
        const F step = set(2.f / static_cast<float>(1 << bits)), first = set(1.f / static_cast<float>(1 << bits) - 1.f);
        const F x = mul_add(to_float(hn::And(code, mask)), step, first);
        const F y = mul_add(to_float(hn::And(shift_right<bits>(code), mask)), step, first);
        const F z = hn::Sub(hn::Sub(set(1.f), hn::Abs(x)), hn::Abs(y)), fold = hn::Max(hn::Neg(z), hn::Zero(df));
        return {hn::Sub(x, hn::CopySign(fold, x)), hn::Sub(y, hn::CopySign(fold, y)), z};
    }
    HWY_INLINE static F inverse_norm(const V3& v) { return hn::Div(set(1.f), hn::Sqrt(dot(v, v))); }
    template <int bits>
    HWY_INLINE static V3 octahedral_normal(I code)
    {
        const V3 n = octahedral<bits>(code);
        const F inverse = inverse_norm(n);
        return times(n, {inverse, inverse, inverse});
    }

    /// The plane of a seed for each lane.
    struct SeedPlanes {
        I part;
        V3 normal;  // outward, unit
        F gap;      // how far the point is below, model units
        F length;   // how far the place's centre is
    };
    HWY_INLINE SeedPlanes planes_of(I direction, I extent, const V3& offset) const
    {
        SeedPlanes planes;
        planes.part = hn::And(direction, set_int(0xff));
        planes.normal = octahedral_normal<model::k_seed_normal_bits>(shift_right<8>(direction));
        planes.length = hn::Mul(to_float(hn::Sub(hn::And(extent, set_int(0xffff)), set_int(0x8000))),
                                set(model::k_seed_distance_step * locator_.cell));
        planes.gap = hn::Sub(planes.length, hn::Mul(dot(planes.normal, offset), set(locator_.cell)));
        return planes;
    }

    static HWY_INLINE I plane_count(I place) { return hn::And(shift_right<11>(place), set_int(7)); }
    static HWY_INLINE M is_flat(I place, M occupied)
    {
        return hn::And(occupied, hn::RebindMask(df, hn::Gt(plane_count(place), hn::Zero(di))));
    }

    /// The planes at, words of their array, below which points are.
    HWY_INLINE FlatPlanes read_planes(I at, const V3& offset) const
    {
        constexpr int bits = model::k_plane_normal_bits;
        constexpr float k_max = static_cast<float>(model::k_plane_most_distance);
        const I plane = gather_word(model_.planes.data(), at);
        const V3 n = octahedral<bits>(plane);
        const F code =
            to_float(hn::And(shift_right<2 * bits>(plane), set_int(static_cast<std::int32_t>(model::k_plane_most_distance))));
        const F distance = hn::Sub(hn::Mul(hn::Mul(code, code), set(locator_.plane_reach / (k_max * k_max))), set(1.f));
        return {plane, hn::Sub(distance, hn::Mul(dot(n, offset), inverse_norm(n)))};
    }
    /// What is lower, of a group that ends there.
    static HWY_INLINE void close_group(const FlatPlanes& group, M which, FlatPlanes& lowest)
    {
        const M lower = hn::And(which, hn::Lt(group.gap, lowest.gap));
        lowest = {blend(lower, group.plane, lowest.plane), blend(lower, group.gap, lowest.gap)};
    }
    /// One more plane for the lanes of a mask.
    static HWY_INLINE void add_planes(const FlatPlanes& next, M more, FlatPlanes& group, FlatPlanes& lowest)
    {
        const M fresh = hn::And(more, not_negative(next.plane));  // not joined to the one before
        close_group(group, fresh, lowest);
        // The first of a group, or higher than it.
        const M taken = hn::Or(fresh, hn::And(more, hn::Gt(next.gap, group.gap)));
        group = {blend(taken, next.plane, group.plane), blend(taken, next.gap, group.gap)};
    }
    /// Places of more than k planes.
    static HWY_INLINE M has_more(I place, std::int32_t k) { return hn::RebindMask(df, hn::Gt(plane_count(place), set_int(k))); }
    /// The lowest of the groups' highest planes, for lanes in flat places.
    HWY_INLINE FlatPlanes lowest_planes(I place, const V3& offset, M flat) const
    {
        I at = blend(flat, shift_right<14>(place), hn::Zero(di));
        FlatPlanes group = read_planes(at, offset), lowest{group.plane, set(INFINITY)};
        std::int32_t k = 1;
        for (M more = hn::And(flat, has_more(place, k)); any(more); more = hn::And(flat, has_more(place, ++k))) {
            at = hn::Add(at, blend(more, set_int(1), hn::Zero(di)));
            add_planes(read_planes(at, offset), more, group, lowest);
        }
        close_group(group, flat, lowest);
        return lowest;
    }

    /// The part that a plane is of.
    HWY_INLINE I part_of(I place, I plane, M flat) const
    {
        const I list =
            gather_word(model_.part_lists.data(), blend(flat, hn::And(shift_right<2>(place), set_int(0x1ff)), hn::Zero(di)));
        return hn::And(hn::Shr(list, hn::ShiftLeft<3>(hn::And(shift_right<29>(plane), set_int(3)))), set_int(0xff));
    }

    /// The points from a slot on, and those of them that are in the grid.
    struct Posed {
        V3 p;         // model space
        V3 in_cells;  // from the grid's corner
        M in_grid;
    };
    HWY_INLINE Posed pose(std::size_t slot) const
    {
        Posed e;
        e.p = posed({hn::LoadU(df, job_.x + slot), hn::LoadU(df, job_.y + slot), hn::LoadU(df, job_.z + slot)});
        const V3 g = e.in_cells = in_cells(e.p);
        const F zero = hn::Zero(df);
        e.in_grid = hn::And(hn::And(hn::Ge(g.x, zero), hn::Ge(g.y, zero)), hn::Ge(g.z, zero));
        e.in_grid = hn::And(
            e.in_grid, hn::And(hn::And(hn::Lt(g.x, set(cells_[0])), hn::Lt(g.y, set(cells_[1]))), hn::Lt(g.z, set(cells_[2]))));
        // The padding of the last cluster is nobody.
        if (slot + hn::Lanes(df) > job_.points)
            e.in_grid = hn::And(e.in_grid, hn::FirstN(df, job_.points > slot ? job_.points - slot : 0));
        return e;
    }

    /// Those that are in places which are not Free; those may be divided.
    struct Entered {
        V3 p;  // model space
        Located at;
        M occupied;
    };
    HWY_INLINE Entered enter(std::size_t slot) const
    {
        const Posed posed = pose(slot);
        Entered e{posed.p, locate(posed.in_cells, posed.in_grid), posed.in_grid};
        e.occupied = hn::AndNot(e.at.is_free, e.occupied);
        return e;
    }

    /// Has the words at some indices of an array fetched.
    static HWY_INLINE void fetch(const std::uint32_t* words, I index, M which)
    {
        HWY_ALIGN std::int32_t at[k_lanes];
        hn::Store(index, di, at);
        each_lane(which, [&](std::size_t i) { hwy::Prefetch(words + at[i]); });
    }

    static HWY_INLINE M is_inside(I place, M occupied)
    {
        return hn::And(occupied, equal(hn::And(place, set_int(3)), set_int(static_cast<std::int32_t>(LocatorCellKind::Inside))));
    }

    const ProbeJob& job_;
    const ModelView& model_;
    const model::Locator& locator_;
    float inverse_cell_;
    float cells_[3];
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
