// A paper map interpolated between its samples, at many positions at a time.
#if defined(SQMAP_PAPER_MAP_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_PAPER_MAP_INL_H
#undef SQMAP_PAPER_MAP_INL_H
#else
#define SQMAP_PAPER_MAP_INL_H
#endif

#include "paper/model/codes.h"
#include "paper/query/cell-inl.h"
#include "sqmap/paper/projection.h"

#include <algorithm>
#include <array>

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

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

    /// How samples are read.
    struct Wanted {
        F normals;         ///< has a normal where the surface is no farther from the foot; elsewhere it may be zero
        bool corrections;  ///< adds step 3's data on layer 3
    };

    /// Layer 2: the sample of the base grid nearest in angle.
    HWY_INLINE SampleLanes nearest_base(const AngleLanes& angles, const Wanted& wanted) const
    {
        const Cell c(angles, base_rows_, base_columns_);
        const I row = c.nearest_row(), column = c.nearest_column();
        const I code = half_word(map_.distance.data(), base_node(row, column));
        SampleLanes sample = value_of(code);
        const M hit = is_hit(code);
        if (any(hn::And(hit, hn::Ge(wanted.normals, sample.distance))))
            sample.normal = blend(hit, decoded(normal_code(hits_before(base_index(row, column)))), sample.normal);
        return sample;
    }

    /// Layer 3: linear interpolation on one sheet of the surface: that of the nearest corner, followed along uncut edges.
    HWY_NOINLINE SampleLanes interpolated(const AngleLanes& angles, const Wanted& wanted) const
    {
        const Cell c(angles, map_.eta_count, map_.omega_count);
        const I bottom = node_of(c.row, c.column), top = node_of(hn::Add(c.row, set_int(1)), c.column);
        const Corners<I> distance = corners(map_.distance.data(), c, bottom, top);
        const Cuts cuts(*this, c, bottom, top);
        const M whole = cuts.whole(), high = hn::Ge(c.y, set(0.5f)), right = hn::Ge(c.x, set(0.5f));
        const I code = blend(high, blend(right, distance[3], distance[2]), blend(right, distance[1], distance[0]));
        const M hit = is_hit(code);
        Corners<F> value;
        for (std::size_t i = 0; i < 4; ++i) value[i] = hn::Mul(scale_, to_float(distance[i]));
        if (any(hn::AndNot(whole, hit))) one_sheet(cuts, high, right, value);
        const F linear = c.bilinear(value[0], value[1], value[2], value[3]);
        F distance_of_hit = linear;
        if (wanted.corrections && !map_.corrections.empty() && any(hn::And(whole, hit)))
            distance_of_hit = hn::Add(linear, correction_at(c, hn::And(whole, hit)));
        SampleLanes sample = value_of(code);
        sample.distance = blend(hit, larger(distance_of_hit, hn::Zero(df)), sample.distance);
        if (any(hn::And(hit, hn::Ge(wanted.normals, sample.distance))))
            sample.normal = blend(hit, normal_at(angles, linear), sample.normal);
        // In a cell inside which a surface enters the superquadric, the side of it that a position lies on is a guess.
        const M cap = equal(code, set_int(k_map_cap));
        M beside_cap = none();
        for (const I& corner : distance) beside_cap = hn::Or(beside_cap, equal(corner, set_int(k_map_cap)));
        const M mixed = hn::AndNot(hn::Or(whole, cap), beside_cap);
        sample.flags =
            hn::Or(hn::Or(sample.flags, flag(hn::Not(whole), k_projection_silhouette)), flag(mixed, k_projection_by_cap));
        return sample;
    }

    /// Delta of eq. 12.
    HWY_INLINE F offset(const AngleLanes& angles) const
    {
        if (map_.offset.empty()) return hn::Zero(df);
        const Cell c(angles, base_rows_, base_columns_);
        Corners<F> value;
        for (std::size_t i = 0; i < 4; ++i) value[i] = offset_of(base_index(c.corner_row(i), c.corner_column(i)));
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
        const Corners<I> code = base_codes(c), entry = hit_entries(c, code);
        Corners<F> change;
        Corners<V3> directions;
        for (std::size_t i = 0; i < 4; ++i) {
            const I word = smoothed_word(entry[i]);
            known = hn::And(known, hn::And(is_hit(code[i]), is_smooth(word)));
            change[i] = change_of(word);
            directions[i] = smoothed_normal(word);
        }
        const F moved = larger(hn::Add(sample.distance, c.bilinear(change[0], change[1], change[2], change[3])), hn::Zero(df));
        sample.distance = blend(known, moved, sample.distance);
        sample.normal = blend(known, between(c, directions), sample.normal);
        return sample;
    }

    /// The same of a sample of layer 2: what smoothing adds at the base sample itself.
    HWY_INLINE SampleLanes smoothed_base(const AngleLanes& angles, SampleLanes sample) const
    {
        if (map_.smoothed.empty()) return sample;
        const Cell c(angles, base_rows_, base_columns_);
        const I word = smoothed_word(hits_before(base_index(c.nearest_row(), c.nearest_column())));
        const M known =
            hn::And(is_smooth(word), equal(hn::And(sample.flags, set_int(k_projection_miss | k_projection_cap)), hn::Zero(di)));
        sample.distance = blend(known, larger(hn::Add(sample.distance, change_of(word)), hn::Zero(df)), sample.distance);
        sample.normal = blend(known, smoothed_normal(word), sample.normal);
        return sample;
    }

    /// A base sample about a position: a corner of the cell, smoothed where the smoothed map has it.
    struct CornerLanes {
        I row, column;  ///< of the base grid
        F share;        ///< of bilinear interpolation
        M hit;
        F stored, smoothed;  ///< distances of a hit
        V3 normal;           ///< of a hit, smoothed
    };
    /// Rise from one sheet's sample to the next, at most.
    float steepest() const { return 3 * spacing_; }
    HWY_INLINE std::array<CornerLanes, 4> base_corners(const AngleLanes& angles) const
    {
        const Cell c(angles, base_rows_, base_columns_);
        const F one = set(1.f), left = hn::Sub(one, c.x), below = hn::Sub(one, c.y);
        const F shares[4] = {hn::Mul(left, below), hn::Mul(c.x, below), hn::Mul(left, c.y), hn::Mul(c.x, c.y)};
        const Corners<I> code = base_codes(c), entry = hit_entries(c, code);
        std::array<CornerLanes, 4> all;
        for (std::size_t i = 0; i < 4; ++i) {
            CornerLanes& corner = all[i];
            corner.row = c.corner_row(i);
            corner.column = c.corner_column(i);
            corner.share = shares[i];
            corner.hit = is_hit(code[i]);
            corner.stored = corner.smoothed = hn::Mul(scale_, to_float(code[i]));
            M known = none();
            if (!map_.smoothed.empty()) {
                const I word = smoothed_word(entry[i]);
                known = is_smooth(word);
                const F moved = larger(hn::Add(corner.stored, change_of(word)), hn::Zero(df));
                corner.smoothed = blend(known, moved, corner.stored);
                corner.normal = smoothed_normal(word);
            }
            if (any(hn::AndNot(known, corner.hit))) corner.normal = blend(known, corner.normal, decoded(normal_code(entry[i])));
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
            const I enter = high(word);
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
        return blend(first, low(pair), high(pair));
    }

private:
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

    static HWY_INLINE M is_hit(I code) { return hn::RebindMask(df, hn::Lt(code, set_int(k_map_largest + 1))); }

    HWY_INLINE I base_index(I row, I column) const
    {
        return hn::Add(hn::Mul(row, set_int(static_cast<std::int32_t>(base_columns_))), column);
    }
    /// As hit_index.
    HWY_INLINE I hits_before(I sample) const
    {
        const auto* words = reinterpret_cast<const std::uint32_t*>(map_.hits.data());
        const I rank = hn::ShiftLeft<1>(shift_right<5>(sample));
        const I bits = gather_word(words, rank), before = gather_word(words + 1, rank);
        const I below = hn::Sub(hn::Shl(set_int(1), hn::And(sample, set_int(31))), set_int(1));
        return hn::Add(before, hn::BitCast(di, hn::PopulationCount(hn::BitCast(du, hn::And(bits, below)))));
    }
    /// Distances at a cell's corners.
    HWY_INLINE Corners<I> base_codes(const Cell& c) const
    {
        Corners<I> code;
        for (std::size_t i = 0; i < 4; ++i)
            code[i] = half_word(map_.distance.data(), base_node(c.corner_row(i), c.corner_column(i)));
        return code;
    }
    /// hits_before at a cell's corners: the next column's is as many, or one more.
    HWY_INLINE Corners<I> hit_entries(const Cell& c, const Corners<I>& code) const
    {
        Corners<I> entry;
        for (std::size_t i = 0; i < 4; i += 2) {
            const I row = c.corner_row(i);
            entry[i] = hits_before(base_index(row, c.column));
            entry[i + 1] = hn::Add(entry[i], flagged(is_hit(code[i])));
            if (any(c.last)) entry[i + 1] = blend(c.last, hits_before(base_index(row, hn::Zero(di))), entry[i + 1]);
        }
        return entry;
    }
    /// Normals at a cell's corners; a row's two stand side by side where both are hits. Corners that are no hits have any.
    HWY_INLINE Corners<I> normal_codes(const Cell& c, const Corners<I>& stored) const
    {
        Corners<I> code;
        for (std::size_t i = 0; i < 4; i += 2) {
            const I row = c.corner_row(i);
            code[i] = normal_code(hits_before(base_index(row, c.column)));
            code[i + 1] = blend(is_hit(stored[i]), high(code[i]), code[i]);
            if (any(c.last)) code[i + 1] = blend(c.last, normal_code(hits_before(base_index(row, hn::Zero(di)))), code[i + 1]);
        }
        return code;
    }
    /// The normal of an entry below, that of the next one above.
    HWY_INLINE I normal_code(I entry) const { return gather_pair(map_.normal.data(), entry); }
    /// As smoothed_at, bits above those of the sample are its neighbour's.
    HWY_INLINE I smoothed_word(I entry) const
    {
        static_assert(k_smoothed_bits == 20 && k_change_bits == 6);
        const I nibble = hn::Add(hn::ShiftLeft<2>(entry), entry);
        const I word = hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(map_.smoothed.data()), shift_right<1>(nibble));
        return blend(equal(hn::And(nibble, set_int(1)), hn::Zero(di)), word, shift_right<4>(word));
    }
    static HWY_INLINE M is_smooth(I word)
    {
        constexpr std::int32_t k_mask = (1 << k_change_bits) - 1;
        return hn::Not(equal(hn::And(word, set_int(k_mask)), set_int(k_not_smoothed & k_mask)));
    }
    HWY_INLINE F change_of(I word) const
    {
        const I root = hn::ShiftRight<32 - k_change_bits>(hn::ShiftLeft<32 - k_change_bits>(word));
        return hn::Mul(set(map_.change_scale), to_float(hn::Mul(root, hn::Abs(root))));
    }
    static HWY_INLINE V3 smoothed_normal(I word)
    {
        constexpr int k_cells = 1 << k_smoothed_normal_bits;
        const auto coordinate = [](I code) {
            return mul_add(to_float(hn::And(code, set_int(k_cells - 1))), set(2.f / k_cells), set(1.f / k_cells - 1.f));
        };
        return unfolded(coordinate(shift_right<k_change_bits>(word)),
                        coordinate(shift_right<k_change_bits + k_smoothed_normal_bits>(word)));
    }
    /// As offset_steps, a length.
    HWY_INLINE F offset_of(I sample) const
    {
        // The first word not before the sample's, by halves; behind the last one come those that end them.
        const I wanted = hn::ShiftLeft<k_offset_bits>(sample);
        const std::size_t count = map_.offset.size() - k_hit_padding;
        I before = hn::Zero(di), after = set_int(static_cast<std::int32_t>(count));
        for (std::size_t left = count; left > 0; left /= 2) {
            const I middle = shift_right<1>(hn::Add(before, after));
            const M lower = hn::RebindMask(df, hn::Lt(gather_word(map_.offset.data(), middle), wanted));
            before = blend(lower, hn::Add(middle, set_int(1)), before);
            after = blend(lower, after, middle);
        }
        const I word = gather_word(map_.offset.data(), before), root = hn::And(word, set_int(15));
        const M found = equal(shift_right<k_offset_bits>(word), sample);
        return hn::IfThenElseZero(found, hn::Mul(set(map_.offset_scale), to_float(hn::Mul(root, root))));
    }
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
        Corners<I> all{blend(c.last, high(lower), low(lower)), high(lower), blend(c.last, high(upper), low(upper)), high(upper)};
        if (any(c.last)) {
            all[1] = blend(c.last, low(gather_pair(values, hn::Sub(bottom, c.column))), all[1]);
            all[3] = blend(c.last, low(gather_pair(values, hn::Sub(top, c.column))), all[3]);
        }
        return all;
    }

    /// Without a normal.
    HWY_INLINE SampleLanes value_of(I code) const
    {
        const M miss = equal(code, set_int(k_map_miss)), cap = equal(code, set_int(k_map_cap));
        const F zero = hn::Zero(df);
        return {blend(miss, set(INFINITY), blend(cap, zero, hn::Mul(scale_, to_float(code)))),
                {zero, zero, zero},
                hn::Or(flag(miss, k_projection_miss), flag(cap, k_projection_cap))};
    }

    /// The normal of a code that model::encode_normal gave.
    static HWY_INLINE V3 decoded(I code)
    {
        const auto coordinate = [](I byte) { return hn::Sub(hn::Mul(to_float(byte), set(1.f / 127.5f)), set(1.f)); };
        return unfolded(coordinate(hn::And(code, set_int(255))), coordinate(hn::And(shift_right<8>(code), set_int(255))));
    }
    /// A unit vector out of the octahedron's square.
    static HWY_INLINE V3 unfolded(F x, F y)
    {
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
        const Corners<I> stored = base_codes(c), code = normal_codes(c, stored);
        const F one = set(1.f), x = c.x, y = c.y, left = hn::Sub(one, x), below = hn::Sub(one, y);
        const Corners<F> share{hn::Mul(left, below), hn::Mul(x, below), hn::Mul(left, y), hn::Mul(x, y)};
        const F reach = set(steepest());
        V3 sum{hn::Zero(df), hn::Zero(df), hn::Zero(df)};
        for (std::size_t i = 0; i < 4; ++i) {
            const M near = hn::Le(hn::Abs(hn::Sub(hn::Mul(scale_, to_float(stored[i])), distance)), reach);
            const M known = hn::And(near, is_hit(stored[i]));
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
