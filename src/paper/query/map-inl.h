// A paper map interpolated between its samples, at many positions at a time.
#if defined(SQMAP_PAPER_MAP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_PAPER_MAP_INL_H
#undef SQMAP_PAPER_MAP_INL_H
#else
#define SQMAP_PAPER_MAP_INL_H
#endif

#include "paper/model/codes.h"
#include "query/superquadric/power-inl.h"
#include "sqmap/paper/projection.h"

#include <algorithm>
#include <array>

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

struct AngleLanes {
    F eta, omega;
};

/// See MapSample.
struct SampleLanes {
    F distance;
    V3 normal;
    I flags;
};

class MapLanes {
public:
    explicit MapLanes(const MapView& map)
        : map_(map),
          scale_(set(map.distance_scale)),
          base_rows_(((map.eta_count - 1) >> map.subdivisions) + 1),
          base_columns_(map.omega_count >> map.subdivisions),
          spacing_(k_pi * std::max({map.superquadric.a.x, map.superquadric.a.y, map.superquadric.a.z}) /
                   static_cast<float>(std::min<std::size_t>(base_rows_ - 1, base_columns_ / 2)))
    {
    }

    /// Layer 2: the sample of the base grid nearest in angle.
    HWY_INLINE SampleLanes nearest_base(const AngleLanes& angles) const
    {
        const Cell c(angles, base_rows_, base_columns_);
        return base_sample(c.nearest_row(), c.nearest_column());
    }
    HWY_INLINE SampleLanes base_sample(I row, I column) const
    {
        const I normal = hn::Add(hn::Mul(row, set_int(static_cast<std::int32_t>(base_columns_))), column);
        return value_of(half_word(map_.distance.data(), base_node(row, column)), half_word(map_.normal.data(), normal));
    }

    /// Layer 3: linear interpolation on one sheet of the surface: that of the nearest corner, followed along uncut edges.
    HWY_NOINLINE SampleLanes interpolated(const AngleLanes& angles, bool corrections) const
    {
        const Cell c(angles, map_.eta_count, map_.omega_count);
        const I bottom = node_of(c.row, c.column), top = node_of(hn::Add(c.row, set_int(1)), c.column);
        const Corners<I> distance = corners(map_.distance.data(), c, bottom, top);
        const Cuts cuts(*this, c, bottom, top);
        const M whole = cuts.whole(), high = hn::Ge(c.y, set(0.5f)), right = hn::Ge(c.x, set(0.5f));
        const I code = blend(high, blend(right, distance[3], distance[2]), blend(right, distance[1], distance[0]));
        const M hit = hn::RebindMask(df, hn::Lt(code, set_int(k_map_largest + 1)));
        Corners<F> value;
        for (std::size_t i = 0; i < 4; ++i) value[i] = hn::Mul(scale_, to_float(distance[i]));
        SampleLanes sample{{}, {}, hn::Zero(di)};
        if (any(hn::AndNot(whole, hit))) one_sheet(cuts, high, right, value);
        sample.distance = c.bilinear(value[0], value[1], value[2], value[3]);
        sample.normal = normal_at(angles, sample.distance);
        if (corrections && !map_.corrections.empty() && any(hn::And(whole, hit)))
            sample.distance = hn::Add(sample.distance, correction_at(c, hn::And(whole, hit)));
        sample.distance = larger(sample.distance, hn::Zero(df));
        const SampleLanes coded = value_of(code, hn::Zero(di));
        sample.distance = blend(hit, sample.distance, coded.distance);
        sample.normal = blend(hit, sample.normal, {hn::Zero(df), hn::Zero(df), hn::Zero(df)});
        // In a cell inside which a surface enters the superquadric, the side of it that a position lies on is a guess.
        const M cap = equal(code, set_int(k_map_cap));
        M beside_cap = none();
        for (const I& corner : distance) beside_cap = hn::Or(beside_cap, equal(corner, set_int(k_map_cap)));
        const M mixed = hn::AndNot(hn::Or(whole, cap), beside_cap);
        sample.flags = hn::Or(hn::Or(hn::IfThenElseZero(hn::RebindMask(di, hn::Not(hit)), coded.flags),
                                     flag(hn::Not(whole), k_projection_silhouette)),
                              flag(mixed, k_projection_by_cap));
        return sample;
    }

    /// Delta of eq. 12.
    HWY_INLINE F offset(const AngleLanes& angles) const
    {
        if (map_.offset.empty()) return hn::Zero(df);
        const Cell c(angles, base_rows_, base_columns_);
        Corners<F> value;
        for (std::size_t i = 0; i < 4; ++i) {
            const I sample = base_corner(c, i), byte = byte_at(map_.offset.data(), shift_right<1>(sample));
            const I root = hn::And(hn::Shr(byte, hn::ShiftLeft<2>(hn::And(sample, set_int(1)))), set_int(15));
            value[i] = hn::Mul(set(map_.offset_scale), to_float(hn::Mul(root, root)));
        }
        return c.bilinear(value[0], value[1], value[2], value[3]);
    }

    /// Smooths a sample of layer 3 there; leaves the sample as it is where the smoothed map has a hole.
    HWY_INLINE SampleLanes smoothed(const AngleLanes& angles, SampleLanes sample) const
    {
        if (map_.smoothed.empty()) return sample;
        constexpr std::int32_t k_no_surface_bits = k_projection_miss | k_projection_cap | k_projection_silhouette;
        M known = equal(hn::And(sample.flags, set_int(k_no_surface_bits)), hn::Zero(di));
        if (!any(known)) return sample;
        const Cell c(angles, base_rows_, base_columns_);
        Corners<F> change;
        Corners<V3> directions;
        for (std::size_t i = 0; i < 4; ++i) {
            const I word = hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(map_.smoothed.data()), base_corner(c, i));
            const I signed_change = hn::ShiftRight<16>(hn::ShiftLeft<16>(word));
            known = hn::AndNot(equal(signed_change, set_int(k_not_smoothed)), known);
            change[i] = hn::Mul(scale_, to_float(signed_change));
            directions[i] = decoded(high_half(word));
        }
        const F moved = larger(hn::Add(sample.distance, c.bilinear(change[0], change[1], change[2], change[3])), hn::Zero(df));
        sample.distance = blend(known, moved, sample.distance);
        sample.normal = blend(known, between(c, directions), sample.normal);
        return sample;
    }

    /// The same of a sample of layer 2: what smoothing adds at the base sample itself.
    HWY_INLINE SampleLanes smoothed_base(const AngleLanes& angles, const SampleLanes& sample) const
    {
        const Cell c(angles, base_rows_, base_columns_);
        return smoothed_node(c.nearest_row(), c.nearest_column(), sample);
    }

    /// A base sample about a position: a corner of the cell, as stored and smoothed.
    struct CornerLanes {
        I row, column;  ///< of the base grid
        F share;        ///< of bilinear interpolation
        SampleLanes stored, smoothed;
    };
    /// Rise from one sheet's sample to the next, at most.
    float steepest() const { return 3 * spacing_; }
    HWY_INLINE std::array<CornerLanes, 4> base_corners(const AngleLanes& angles) const
    {
        const Cell c(angles, base_rows_, base_columns_);
        const F one = set(1.f), left = hn::Sub(one, c.x), below = hn::Sub(one, c.y);
        const F shares[4] = {hn::Mul(left, below), hn::Mul(c.x, below), hn::Mul(left, c.y), hn::Mul(c.x, c.y)};
        std::array<CornerLanes, 4> all;
        for (std::size_t i = 0; i < 4; ++i) {
            CornerLanes& corner = all[i];
            corner.row = i < 2 ? c.row : hn::Add(c.row, set_int(1));
            corner.column = i % 2 == 0 ? c.column : c.next_column;
            corner.share = shares[i];
            corner.stored = base_sample(corner.row, corner.column);
            corner.smoothed = smoothed_node(corner.row, corner.column, corner.stored);
        }
        return all;
    }

    /// Openings of the nearest sample's ray. Of the lanes of a mask those at foot distance s that lie in one or behind one; sets
    /// their distance to where the solid is entered again.
    M behind_first(const AngleLanes& angles, F s, M which, F& distance) const
    {
        if (map_.gaps.empty()) return none();
        const Cell c(angles, map_.eta_count, map_.omega_count);
        const I row = c.nearest_row(), column = c.nearest_column();
        Entries entries(map_.gap_rows.data(), reinterpret_cast<const std::byte*>(map_.gaps.data()), row, column, which);
        M found = none();
        for (; any(entries.left); entries.next()) {
            const I word = entries.word(2);  // leave, enter
            const M behind = hn::And(entries.left, hn::Gt(s, hn::Mul(scale_, to_float(low(word)))));
            const I enter = high_half(word);
            const F again = blend(equal(enter, set_int(k_map_miss)), set(INFINITY), hn::Mul(scale_, to_float(enter)));
            distance = blend(behind, again, distance);
            found = hn::Or(found, behind);
            entries.left = behind;
        }
        return found;
    }

    /// A value of 16 bits; nothing is read behind the last but where it is the only one.
    static HWY_INLINE I half_word(const std::uint16_t* base, I index)
    {
        const M first = equal(index, hn::Zero(di));
        const I pair = gather_pair(base, hn::Sub(index, flagged(hn::Not(first))));
        return blend(first, low(pair), high_half(pair));
    }

private:
    template <class T>
    using Corners = std::array<T, 4>;  // (row, column), (row, next), (next, column), (next, next)

    /// A cell of a grid, and where in it.
    struct Cell {
        I row, column, next_column;
        F y, x;
        M last;  // the cell ends where the columns begin

        HWY_INLINE Cell(const AngleLanes& angles, std::size_t rows, std::size_t columns)
        {
            const auto count = [](std::size_t n) { return static_cast<float>(n); };
            const auto within = [](F v, float max) { return smaller(larger(v, hn::Zero(df)), set(max)); };
            const F at_y = within(mul_add(angles.eta, set(count(rows - 1) / k_pi), set(0.5f * count(rows - 1))), count(rows - 1)),
                    at_x = within(mul_add(angles.omega, set(count(columns) / (2 * k_pi)), set(0.5f * count(columns))),
                                  count(columns));
            row = hn::Min(truncate(at_y), set_int(static_cast<std::int32_t>(rows) - 2));
            const I end = set_int(static_cast<std::int32_t>(columns) - 1);
            column = hn::Min(truncate(at_x), end);
            last = equal(column, end);
            next_column = hn::IfThenElseZero(hn::RebindMask(di, hn::Not(last)), hn::Add(column, set_int(1)));
            y = hn::Sub(at_y, to_float(row));
            x = hn::Sub(at_x, to_float(column));
        }
        HWY_INLINE I nearest_row() const
        {
            return hn::Add(row, hn::IfThenElseZero(hn::RebindMask(di, hn::Ge(y, set(0.5f))), set_int(1)));
        }
        HWY_INLINE I nearest_column() const { return blend(hn::Ge(x, set(0.5f)), next_column, column); }
        HWY_INLINE F bilinear(F v00, F v01, F v10, F v11) const
        {
            const F lower = mul_add(x, hn::Sub(v01, v00), v00), upper = mul_add(x, hn::Sub(v11, v10), v10);
            return mul_add(y, hn::Sub(upper, lower), lower);
        }
    };

    /// Which edges of a cell the surface jumps across.
    struct Cuts {
        M bottom, top, left, right;  // uncut

        HWY_INLINE Cuts(const MapLanes& map, const Cell& c, I lower, I upper)
        {
            const I beside = hn::Add(hn::Sub(lower, c.column), c.next_column);
            const I b0 = map.cut_bits(lower), b1 = map.cut_bits(beside), b2 = map.cut_bits(upper);
            const auto clear = [](I bits, std::int32_t bit) { return equal(hn::And(bits, set_int(bit)), hn::Zero(di)); };
            bottom = clear(b0, 2);
            top = clear(b2, 2);
            left = clear(b0, 1);
            right = clear(b1, 1);
        }
        HWY_INLINE M whole() const { return hn::And(hn::And(bottom, top), hn::And(left, right)); }
    };

    /// Records of six bytes, a lane at a time sorted by column, from the first of a column on.
    struct Entries {
        const std::byte* base;
        I at, end, column;
        M left;

        HWY_INLINE Entries(const std::uint32_t* rows, const std::byte* records, I row, I wanted, M which)
            : base(records), column(wanted)
        {
            const I from = blend(which, row, hn::Zero(di));
            at = gather_word(rows, from);
            end = gather_word(rows, hn::Add(from, set_int(1)));
            left = hn::And(which, hn::RebindMask(df, hn::Lt(at, end)));
            // The first not before the column, by halves.
            I before = at, after = end;
            for (M open = left; any(open); open = hn::And(open, hn::RebindMask(df, hn::Lt(before, after)))) {
                const I middle = shift_right<1>(hn::Add(before, after));
                const M lower = hn::And(open, hn::RebindMask(df, hn::Lt(column_of(middle, open), column)));
                before = blend(lower, hn::Add(middle, set_int(1)), before);
                after = blend(hn::AndNot(lower, open), middle, after);
            }
            at = before;
            check();
        }
        /// Two bytes at a time from an even offset in the record on.
        HWY_INLINE I word(int offset) const { return gather(at, left, offset); }
        HWY_INLINE void next()
        {
            at = hn::Add(at, set_int(1));
            check();
        }

    private:
        HWY_INLINE I gather(I index, M which, int offset) const
        {
            const I byte = hn::Mul(blend(which, index, hn::Zero(di)), set_int(6));
            return hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(base), hn::Add(byte, set_int(offset)));
        }
        HWY_INLINE I column_of(I index, M which) const { return low(gather(index, which, 0)); }
        HWY_INLINE void check()
        {
            left = hn::And(left, hn::RebindMask(df, hn::Lt(at, end)));
            if (any(left)) left = hn::And(left, equal(column_of(at, left), column));
        }
    };

    static HWY_INLINE I high_half(I word) { return shift_right<16>(word); }
    /// Smooths the sample of a node of the base grid.
    HWY_INLINE SampleLanes smoothed_node(I row, I column, SampleLanes sample) const
    {
        if (map_.smoothed.empty()) return sample;
        const I node = hn::Add(hn::Mul(row, set_int(static_cast<std::int32_t>(base_columns_))), column);
        const I word = hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(map_.smoothed.data()), node);
        const I change = hn::ShiftRight<16>(hn::ShiftLeft<16>(word));
        const M known = hn::AndNot(equal(change, set_int(k_not_smoothed)),
                                   equal(hn::And(sample.flags, set_int(k_projection_miss | k_projection_cap)), hn::Zero(di)));
        const F moved = larger(hn::Add(sample.distance, hn::Mul(scale_, to_float(change))), hn::Zero(df));
        sample.distance = blend(known, moved, sample.distance);
        sample.normal = blend(known, decoded(high_half(word)), sample.normal);
        return sample;
    }
    static HWY_INLINE I flagged(M m) { return hn::IfThenElseZero(hn::RebindMask(di, m), set_int(1)); }
    /// Reads bytes of an array that holds four at least, and nothing behind its last.
    static HWY_INLINE I byte_at(const std::uint8_t* base, I index)
    {
        const I from = hn::Max(hn::Sub(index, set_int(3)), hn::Zero(di));
        const I word = hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(base), from);
        return hn::And(hn::Shr(word, hn::ShiftLeft<3>(hn::Sub(index, from))), set_int(255));
    }
    HWY_INLINE I node_of(I row, I column) const
    {
        return hn::Add(hn::Mul(row, set_int(static_cast<std::int32_t>(map_.omega_count))), column);
    }
    /// The finest grid's node that is a sample of the base grid.
    HWY_INLINE I base_node(I row, I column) const
    {
        const I every = set_int(std::int32_t{1} << map_.subdivisions);
        return node_of(hn::Mul(row, every), hn::Mul(column, every));
    }
    HWY_INLINE I base_corner(const Cell& c, std::size_t i) const
    {
        const I row = i < 2 ? c.row : hn::Add(c.row, set_int(1)), column = i % 2 == 0 ? c.column : c.next_column;
        return hn::Add(hn::Mul(row, set_int(static_cast<std::int32_t>(base_columns_))), column);
    }
    HWY_INLINE I cut_bits(I node) const
    {
        const I byte = byte_at(map_.cuts.data(), shift_right<2>(node));
        return hn::And(hn::Shr(byte, hn::ShiftLeft<1>(hn::And(node, set_int(3)))), set_int(3));
    }
    /// Reads two neighbouring columns at a time.
    static HWY_INLINE Corners<I> corners(const std::uint16_t* values, const Cell& c, I bottom, I top)
    {
        const I back = flagged(c.last);
        const I lower = gather_pair(values, hn::Sub(bottom, back)), upper = gather_pair(values, hn::Sub(top, back));
        Corners<I> all{blend(c.last, high_half(lower), low(lower)), high_half(lower), blend(c.last, high_half(upper), low(upper)),
                       high_half(upper)};
        if (any(c.last)) {
            all[1] = blend(c.last, low(gather_pair(values, hn::Sub(bottom, c.column))), all[1]);
            all[3] = blend(c.last, low(gather_pair(values, hn::Sub(top, c.column))), all[3]);
        }
        return all;
    }

    HWY_INLINE SampleLanes value_of(I code, I normal) const
    {
        const M miss = equal(code, set_int(k_map_miss)), cap = equal(code, set_int(k_map_cap));
        const M none_known = hn::Or(miss, cap);
        const F zero = hn::Zero(df);
        return {blend(miss, set(INFINITY), blend(cap, zero, hn::Mul(scale_, to_float(code)))),
                blend(none_known, {zero, zero, zero}, decoded(normal)),
                hn::Or(flag(miss, k_projection_miss), flag(cap, k_projection_cap))};
    }

    /// The normal of a code that model::encode_normal gave.
    static HWY_INLINE V3 decoded(I code)
    {
        const auto coordinate = [](I byte) { return hn::Sub(hn::Mul(to_float(byte), set(1.f / 127.5f)), set(1.f)); };
        const F x = coordinate(hn::And(code, set_int(255))), y = coordinate(hn::And(shift_right<8>(code), set_int(255)));
        const F one = set(1.f), z = hn::Sub(hn::Sub(one, hn::Abs(x)), hn::Abs(y));
        const F fold = larger(hn::Neg(z), hn::Zero(df));
        return unit_of({hn::Sub(x, hn::CopySign(fold, x)), hn::Sub(y, hn::CopySign(fold, y)), z});
    }
    static HWY_INLINE V3 between(const Cell& c, const Corners<V3>& n)
    {
        return unit_of({c.bilinear(n[0].x, n[1].x, n[2].x, n[3].x), c.bilinear(n[0].y, n[1].y, n[2].y, n[3].y),
                        c.bilinear(n[0].z, n[1].z, n[2].z, n[3].z)});
    }

    /// Corners on another sheet are continued from the nearest's: in the plane of three corners, level across the missing side of
    /// two, constant from one.
    static HWY_NOINLINE void one_sheet(const Cuts& cuts, M high, M right, Corners<F>& value)
    {
        Corners<M> known{hn::Not(hn::Or(high, right)), hn::AndNot(high, right), hn::AndNot(right, high), hn::And(high, right)};
        const auto join = [&](M uncut, std::size_t a, std::size_t b) {
            const M either = hn::And(uncut, hn::Or(known[a], known[b]));
            known[a] = hn::Or(known[a], either);
            known[b] = hn::Or(known[b], either);
        };
        // Three sweeps reach every corner from any start.
        for (int sweep = 0; sweep < 3; ++sweep) {
            join(cuts.bottom, 0, 1);
            join(cuts.top, 2, 3);
            join(cuts.left, 0, 2);
            join(cuts.right, 1, 3);
        }
        const Corners<F> had = value;
        for (std::size_t i = 0; i < 4; ++i) {
            const std::size_t along = i ^ 1, across = i ^ 2, opposite = i ^ 3;
            const M three = hn::And(hn::And(known[along], known[across]), known[opposite]);
            const F one = blend(known[along], had[along], blend(known[across], had[across], had[opposite]));
            const F level = blend(three, hn::Sub(hn::Add(had[along], had[across]), had[opposite]), one);
            value[i] = blend(known[i], had[i], level);
        }
    }

    /// Between the base samples about a position of those whose surface is at about its distance: others are on another sheet.
    /// Zero where none is.
    HWY_INLINE V3 normal_at(const AngleLanes& angles, F distance) const
    {
        const Cell c(angles, base_rows_, base_columns_);
        const I row_above = hn::Add(c.row, set_int(1)), columns = set_int(static_cast<std::int32_t>(base_columns_));
        const Corners<I> code = corners(map_.normal.data(), c, hn::Add(hn::Mul(c.row, columns), c.column),
                                        hn::Add(hn::Mul(row_above, columns), c.column));
        const Corners<I> stored{half_word(map_.distance.data(), base_node(c.row, c.column)),
                                half_word(map_.distance.data(), base_node(c.row, c.next_column)),
                                half_word(map_.distance.data(), base_node(row_above, c.column)),
                                half_word(map_.distance.data(), base_node(row_above, c.next_column))};
        const F one = set(1.f), x = c.x, y = c.y, left = hn::Sub(one, x), below = hn::Sub(one, y);
        const Corners<F> share{hn::Mul(left, below), hn::Mul(x, below), hn::Mul(left, y), hn::Mul(x, y)};
        const F reach = set(steepest());
        V3 sum{hn::Zero(df), hn::Zero(df), hn::Zero(df)};
        for (std::size_t i = 0; i < 4; ++i) {
            const M near = hn::Le(hn::Abs(hn::Sub(hn::Mul(scale_, to_float(stored[i])), distance)), reach);
            const M known = hn::And(near, hn::RebindMask(df, hn::Lt(stored[i], set_int(k_map_largest + 1))));
            // A share for corners that others leave alone.
            const F weight = hn::IfThenElseZero(known, larger(share[i], set(1e-4f)));
            sum = plus(sum, scaled(weight, decoded(code[i])));
        }
        return unit_of(sum);
    }

    /// The weights of step 3: pyramids over the cell, 1 at a vertex and 0 on the border.
    F correction_at(const Cell& c, M which) const
    {
        const F one = set(1.f);
        F sum = hn::Zero(df);
        for (Entries e(map_.correction_rows.data(), reinterpret_cast<const std::byte*>(map_.corrections.data()), c.row, c.column,
                       which);
             any(e.left); e.next()) {
            const I word = e.word(2);  // eta, omega, correction
            const auto position = [](I byte) { return hn::Mul(hn::Add(to_float(byte), set(0.5f)), set(1.f / 256)); };
            const F y0 = position(hn::And(word, set_int(255))), x0 = position(hn::And(shift_right<8>(word), set_int(255)));
            const F along_x = smaller(hn::Div(c.x, x0), hn::Div(hn::Sub(one, c.x), hn::Sub(one, x0))),
                    along_y = smaller(hn::Div(c.y, y0), hn::Div(hn::Sub(one, c.y), hn::Sub(one, y0)));
            const F hat = larger(smaller(along_x, along_y), hn::Zero(df));
            sum = hn::Add(sum, hn::IfThenElseZero(e.left, hn::Mul(hat, to_float(hn::ShiftRight<16>(word)))));
        }
        return hn::Mul(scale_, sum);
    }

    const MapView& map_;
    const F scale_;
    const std::size_t base_rows_, base_columns_;
    const float spacing_;  // of base samples, at most about so much; model units
};

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
