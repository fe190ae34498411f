// The locator, read for many points at a time: the cell that holds a point, its planes, its seeds.
#if defined(SQMAP_QUERY_LOCATOR_LOCATE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_LOCATOR_LOCATE_INL_H
#undef SQMAP_QUERY_LOCATOR_LOCATE_INL_H
#else
#define SQMAP_QUERY_LOCATOR_LOCATE_INL_H
#endif

#include "math/lanes-inl.h"
#include "model/locator_cells.h"
#include "sqmap/model/model.h"

#include <hwy/cache_control.h>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;
using model::LocatorBrick;
using model::LocatorCell;
using model::LocatorCellKind;
using model::LocatorPlane;
using model::ModelView;

/// A flat cell's plane that counts, for each lane: its word, and how far the point is below, in cells.
struct FlatPlanes {
    I plane;
    F below;
};

/// A model's locator, read for a vector of points.
class LocatorLanes {
public:
    explicit LocatorLanes(const ModelView& model) : model_(model), locator_(model.locator)
    {
        inverse_cell_ = 1.f / locator_.cell;
        for (int k = 0; k < 3; ++k) extent_[k] = static_cast<float>(model::k_brick * locator_.bricks[k]);
    }

    /// Model units.
    float cell() const { return locator_.cell; }

    HWY_INLINE V3 in_cells(const V3& p) const
    {
        const F scale = set(inverse_cell_);
        return {hn::Mul(hn::Sub(p.x, set(locator_.origin[0])), scale), hn::Mul(hn::Sub(p.y, set(locator_.origin[1])), scale),
                hn::Mul(hn::Sub(p.z, set(locator_.origin[2])), scale)};
    }

    /// Which of these, in cells, are in the grid.
    HWY_INLINE M in_grid(const V3& g) const
    {
        const F zero = hn::Zero(df);
        const M above = hn::And(hn::And(hn::Ge(g.x, zero), hn::Ge(g.y, zero)), hn::Ge(g.z, zero));
        return hn::And(
            above, hn::And(hn::And(hn::Lt(g.x, set(extent_[0])), hn::Lt(g.y, set(extent_[1]))), hn::Lt(g.z, set(extent_[2]))));
    }

    /// Fields of a cell's word.
    static HWY_INLINE I kind_of(I cell) { return hn::And(cell, set_word(LocatorCell::k_kind_mask)); }
    static HWY_INLINE M is_kind(I cell, LocatorCellKind kind, M which)
    {
        return hn::And(which, equal(kind_of(cell), set_int(static_cast<std::int32_t>(kind))));
    }
    static HWY_INLINE I list_of(I cell)
    {
        return hn::And(shift_right<LocatorCell::k_list_shift>(cell), set_word(LocatorCell::k_list_mask));
    }
    static HWY_INLINE I first_of(I cell) { return shift_right<LocatorCell::k_first_shift>(cell); }

    /// The cell under each lane.
    struct Located {
        M is_free;
        I gap_code;
        I cell;     // its word, where it is not free
        I index;    // of that word
        V3 offset;  // from its centre, in cells
        I brick;    // index
        I within;   // of the cell in its brick, 0 of a deep one
    };
    /// The address of each lane's cell, known before the cell is read.
    struct Address {
        M free_brick, whole;  // whole: the brick is one cell, or free
        I gap_code;           // of free bricks
        I index;              // of the cell's word; 0 where the brick is free
        V3 offset;            // from the cell's centre, in cells
        I brick;              // index
        I within;             // of the cell in its brick, 0 of a deep one
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
        a.whole = hn::Or(a.free_brick, hn::RebindMask(df, hn::Ne(hn::And(brick, set_word(LocatorBrick::k_deep)), nil)));
        const I three = set_int(3);
        const I within =
            hn::Add(hn::ShiftLeft<2>(hn::Add(hn::ShiftLeft<2>(hn::And(iz, three)), hn::And(iy, three))), hn::And(ix, three));
        a.within = blend(a.whole, nil, within);
        a.index = blend(hn::AndNot(a.free_brick, active),
                        hn::Add(hn::And(brick, set_word(~(LocatorBrick::k_free | LocatorBrick::k_deep))), a.within), nil);
        a.gap_code = hn::And(brick, set_word(~LocatorBrick::k_free));
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
        found.cell = gather_word(model_.locator_cells.data(), a.index);
        found.is_free = hn::Or(a.free_brick, hn::And(active, is_free(found.cell, a.whole)));
        found.offset = a.offset;
        found.index = a.index;
        found.brick = a.brick;
        found.within = a.within;
        found.gap_code = blend(a.free_brick, a.gap_code, shift_right<LocatorCell::k_gap_shift>(found.cell));
        return found;
    }
    static HWY_INLINE M is_free(I cell, M whole) { return hn::AndNot(whole, equal(kind_of(cell), hn::Zero(di))); }

    static HWY_INLINE M is_divided(I cell, M which)
    {
        return hn::And(which, equal(hn::And(cell, set_word(LocatorCell::k_divided_mask)), set_word(LocatorCell::k_divided)));
    }

    /// Points in divided cells: into the eighth that holds them. Takes those off the mask where that is free.
    HWY_INLINE void divide(I& cell, I& index, V3& offset, M& occupied) const
    {
        const I nil = hn::Zero(di);
        float quarter = 0.25f;
        M divided = is_divided(cell, occupied);
        for (int k = 0; k < model::k_max_divisions && any(divided); ++k) {
            const F zero = hn::Zero(df);
            const M up_x = hn::Ge(offset.x, zero), up_y = hn::Ge(offset.y, zero), up_z = hn::Ge(offset.z, zero);
            const I eighth =
                hn::Add(blend(up_x, set_int(1), nil), hn::Add(blend(up_y, set_int(2), nil), blend(up_z, set_int(4), nil)));
            index = blend(divided, hn::Add(first_of(cell), eighth), index);
            cell = blend(divided, gather_word(model_.locator_cells.data(), index), cell);
            const auto move = [&](M up, F v) { return blend(divided, hn::Sub(v, blend(up, set(quarter), set(-quarter))), v); };
            offset = {move(up_x, offset.x), move(up_y, offset.y), move(up_z, offset.z)};
            occupied = hn::AndNot(hn::And(divided, equal(kind_of(cell), nil)), occupied);
            divided = is_divided(cell, hn::And(divided, occupied));
            quarter *= 0.5f;
        }
    }

    /// A lower bound of the distance from a point in a free cell to the solid, in cells.
    HWY_INLINE static F gap_of(const Located& found)
    {
        return hn::Sub(hn::Mul(to_float(found.gap_code), set(model::k_gap_step)), hn::Sqrt(dot(found.offset, found.offset)));
    }

    /// A vector out of the octahedron's square, not yet of unit length; see octahedral_normal.
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
        F below;    // how far the point is below, model units
        F length;   // how far the cell's centre is
    };
    HWY_INLINE SeedPlanes seed_planes(I direction, I extent, const V3& offset) const
    {
        SeedPlanes planes;
        planes.part = hn::And(direction, set_word(model::k_seed_part_mask));
        planes.normal = octahedral_normal<model::k_seed_normal_bits>(shift_right<model::k_seed_normal_shift>(direction));
        planes.length = hn::Mul(
            to_float(hn::Sub(hn::And(extent, set_word(model::k_seed_distance_mask)), set_word(model::k_seed_distance_zero))),
            set(model::k_seed_distance_step * locator_.cell));
        planes.below = hn::Sub(planes.length, hn::Mul(dot(planes.normal, offset), set(locator_.cell)));
        return planes;
    }

    /// The start of a lane's search for its nearest surface: the only seed of its cell, or the seed of a chain that the point's
    /// octant names.
    struct SeedStart {
        SeedPlanes planes;
        M single;
        I chain;  // index of the chain's first seed
        F reach;  // a surface found within is the nearest, model units
    };
    HWY_INLINE SeedStart start_of(I cell, const V3& offset, M occupied) const
    {
        const auto* words = reinterpret_cast<const std::uint32_t*>(model_.seeds.data());
        SeedStart start;
        start.chain = blend(occupied, first_of(cell), hn::Zero(di));
        I word = hn::Add(start.chain, start.chain);
        I direction = gather_word(words, word), extent = gather_word(words + 1, word);
        start.single = hn::Not(not_negative(extent));
        const M chain = hn::AndNot(start.single, occupied);
        if (any(chain)) {
            const I choices = gather_word(words, blend(chain, hn::Sub(word, set_int(2)), hn::Zero(di)));
            const auto upper = [&](F v, std::int32_t bit) { return blend(hn::Gt(v, hn::Zero(df)), set_int(bit), hn::Zero(di)); };
            const I octant3 = hn::Add(hn::Add(upper(offset.x, 3), upper(offset.y, 6)), upper(offset.z, 12));
            const I choice = blend(chain, hn::And(hn::Shr(choices, octant3), set_int(7)), hn::Zero(di));
            word = hn::Add(word, hn::Add(choice, choice));
            direction = gather_word(words, word);
            extent = gather_word(words + 1, word);
        }
        start.planes = seed_planes(direction, extent, offset);
        start.reach = hn::Mul(to_float(hn::And(shift_right<model::k_seed_reach_shift>(extent), set_int(0xff))),
                              set(model::k_seed_reach_step * locator_.cell));
        return start;
    }

    static HWY_INLINE I plane_count(I cell)
    {
        return hn::And(shift_right<LocatorCell::k_planes_shift>(cell), set_word(LocatorCell::k_planes_mask));
    }
    static HWY_INLINE M is_flat(I cell, M occupied)
    {
        return hn::And(occupied, hn::RebindMask(df, hn::Gt(plane_count(cell), hn::Zero(di))));
    }

    /// The planes at, words of their array, below which points are.
    HWY_INLINE FlatPlanes read_planes(I at, const V3& offset) const
    {
        constexpr int k_bits = LocatorPlane::k_normal_bits;
        constexpr float k_max = static_cast<float>(LocatorPlane::k_max_distance);
        const I plane = gather_word(model_.planes.data(), at);
        const V3 n = octahedral<k_bits>(plane);
        const F code =
            to_float(hn::And(shift_right<LocatorPlane::k_distance_shift>(plane), set_word(LocatorPlane::k_max_distance)));
        const F distance = hn::Sub(hn::Mul(hn::Mul(code, code), set(locator_.plane_reach / (k_max * k_max))), set(1.f));
        return {plane, hn::Sub(distance, hn::Mul(dot(n, offset), inverse_norm(n)))};
    }
    /// Ends a group: its plane replaces the lowest so far where the point is less deep below it.
    static HWY_INLINE void close_group(const FlatPlanes& group, M which, FlatPlanes& lowest)
    {
        const M lower = hn::And(which, hn::Lt(group.below, lowest.below));
        lowest = {blend(lower, group.plane, lowest.plane), blend(lower, group.below, lowest.below)};
    }
    /// One more plane for the lanes of a mask.
    static HWY_INLINE void add_planes(const FlatPlanes& next, M more, FlatPlanes& group, FlatPlanes& lowest)
    {
        const M fresh = hn::And(more, not_negative(next.plane));  // not joined to the one before
        close_group(group, fresh, lowest);
        // The first of a group, or higher than it.
        const M taken = hn::Or(fresh, hn::And(more, hn::Gt(next.below, group.below)));
        group = {blend(taken, next.plane, group.plane), blend(taken, next.below, group.below)};
    }
    /// Cells of more than k planes.
    static HWY_INLINE M has_more(I cell, std::int32_t k) { return hn::RebindMask(df, hn::Gt(plane_count(cell), set_int(k))); }
    /// The lowest of the groups' highest planes, for lanes in flat cells.
    HWY_INLINE FlatPlanes lowest_planes(I cell, const V3& offset, M flat) const
    {
        I at = blend(flat, first_of(cell), hn::Zero(di));
        FlatPlanes group = read_planes(at, offset), lowest{group.plane, set(INFINITY)};
        std::int32_t k = 1;
        for (M more = hn::And(flat, has_more(cell, k)); any(more); more = hn::And(flat, has_more(cell, ++k))) {
            at = hn::Add(at, blend(more, set_int(1), hn::Zero(di)));
            add_planes(read_planes(at, offset), more, group, lowest);
        }
        close_group(group, flat, lowest);
        return lowest;
    }

    /// The part that a plane is of.
    HWY_INLINE I part_of(I cell, I plane, M flat) const
    {
        const I list = gather_word(model_.part_lists.data(), blend(flat, list_of(cell), hn::Zero(di)));
        return hn::And(hn::Shr(list, hn::ShiftLeft<3>(hn::And(shift_right<LocatorPlane::k_slot_shift>(plane),
                                                              set_word(LocatorPlane::k_slot_mask)))),
                       set_int(0xff));
    }

    /// Has the words at some indices of an array fetched; WebAssembly cannot.
    static HWY_INLINE void fetch(const std::uint32_t* words, I index, M which)
    {
        if constexpr (!k_fetches) return;
        HWY_ALIGN std::int32_t at[k_lanes];
        hn::Store(index, di, at);
        each_lane(which, [&](std::size_t i) { hwy::Prefetch(words + at[i]); });
    }

    static HWY_INLINE M is_inside(I cell, M occupied) { return is_kind(cell, LocatorCellKind::Inside, occupied); }

protected:
    static constexpr bool k_fetches = HWY_TARGET != HWY_WASM;

    const ModelView& model_;
    const model::Locator& locator_;
    float inverse_cell_;
    float extent_[3];  // cells along each axis
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
