// P. Guigue and O. Devillers, "Fast and robust triangle-triangle overlap test using orientation predicates", 2003, a pair of
// triangles in each lane. J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
// 1997: his first bound says which signs double is sure of. It holds for any determinant of three vectors whose elements are
// differences of two coordinates: here of two sides and of the step from one to the other, or of two sides and a step of one
// triangle, whose products many determinants share.
#include "crossing_rows.h"
#include "separating_axes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/contacts/crossing_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_HAVE_FLOAT64

using DD = hn::CappedTag<double, 8>;
using D = hn::Vec<DD>;
using Where = hn::Mask<DD>;
using DCode = hn::RebindToUnsigned<DD>;
using Code = hn::Vec<DCode>;
constexpr DD dd{};
constexpr DCode dc{};
constexpr std::size_t k_pair_lanes = hn::MaxLanes(DD());
constexpr std::size_t k_block = 16;  // pairs whose corners are read at once
static_assert(k_block % k_pair_lanes == 0 && 64 % k_block == 0);

struct D3 {
    D x, y, z;
};
HWY_INLINE D3 step(const D3& from, const D3& to) { return {hn::Sub(to.x, from.x), hn::Sub(to.y, from.y), hn::Sub(to.z, from.z)}; }

/// A determinant, and its sign where double is sure of it.
struct Sign {
    Where above, below;
    D value;
};

/// The products of two vectors, for determinants with a third one.
struct Products {
    D3 cross, size;

    HWY_INLINE Products(const D3& u, const D3& v)
    {
        const D yz = hn::Mul(u.y, v.z), zy = hn::Mul(u.z, v.y), zx = hn::Mul(u.z, v.x), xz = hn::Mul(u.x, v.z),
                xy = hn::Mul(u.x, v.y), yx = hn::Mul(u.y, v.x);
        cross = {hn::Sub(yz, zy), hn::Sub(zx, xz), hn::Sub(xy, yx)};
        size = {hn::Add(hn::Abs(yz), hn::Abs(zy)), hn::Add(hn::Abs(zx), hn::Abs(xz)), hn::Add(hn::Abs(xy), hn::Abs(yx))};
    }
    HWY_INLINE Sign with(const D3& w) const
    {
        constexpr double k_epsilon = 0x1p-53, k_bound = (7 + 56 * k_epsilon) * k_epsilon;
        const D det = hn::Add(hn::Add(hn::Mul(w.x, cross.x), hn::Mul(w.y, cross.y)), hn::Mul(w.z, cross.z));
        const D permanent =
            hn::Add(hn::Add(hn::Mul(hn::Abs(w.x), size.x), hn::Mul(hn::Abs(w.y), size.y)), hn::Mul(hn::Abs(w.z), size.z));
        const D bound = hn::Mul(hn::Set(dd, k_bound), permanent);
        return {hn::Gt(det, bound), hn::Lt(det, hn::Neg(bound)), det};
    }
};

/// Corners of triangles, those of a and those of b in a's frame.
struct Corners {
    D3 a[3], b[3];
};

HWY_INLINE Where known(const Sign& sign) { return hn::Or(sign.above, sign.below); }
HWY_INLINE D3 blend(Where m, const D3& yes, const D3& no)
{
    return {hn::IfThenElse(m, yes.x, no.x), hn::IfThenElse(m, yes.y, no.y), hn::IfThenElse(m, yes.z, no.z)};
}

/// Heights of one triangle's corners over the plane of the other.
struct Heights {
    Sign corner[3];

    [[nodiscard]] HWY_INLINE Where beside() const
    {
        return hn::Or(hn::And(corner[0].above, hn::And(corner[1].above, corner[2].above)),
                      hn::And(corner[0].below, hn::And(corner[1].below, corner[2].below)));
    }
    [[nodiscard]] HWY_INLINE Where all_known() const
    {
        return hn::And(known(corner[0]), hn::And(known(corner[1]), known(corner[2])));
    }
    /// How far the lowest corner is below the plane, evaluated as depth_along_normals does. normal: the plane's.
    [[nodiscard]] HWY_INLINE D below(const D3& normal) const
    {
        const D sum = hn::Add(hn::Add(hn::Mul(normal.x, normal.x), hn::Mul(normal.y, normal.y)), hn::Mul(normal.z, normal.z)),
                length = hn::Sqrt(sum), lowest = hn::Min(corner[0].value, hn::Min(corner[1].value, corner[2].value));
        return hn::Div(hn::Neg(lowest), hn::IfThenElse(hn::Gt(length, hn::Zero(dd)), length, hn::Set(dd, 1.)));
    }
    /// Corner k is alone on its side, where all are known and not all are on one.
    [[nodiscard]] HWY_INLINE Where is_alone(int k) const
    {
        return hn::And(hn::Xor(corner[k].above, corner[(k + 1) % 3].above), hn::Xor(corner[k].above, corner[(k + 2) % 3].above));
    }
};

/// A triangle from its corner that is alone on its side of the other's plane: the sides from it and to it pass through the plane.
struct Apex {
    Where second, third;  // which corner it is
    D3 at, side_from, before, side_to;

    HWY_INLINE Apex(const Heights& heights, const D3 (&corner)[3])
    {
        second = heights.is_alone(1);
        third = heights.is_alone(2);
        at = blend(second, corner[1], blend(third, corner[2], corner[0]));
        side_from = step(at, blend(second, corner[2], blend(third, corner[0], corner[1])));
        before = blend(second, corner[0], blend(third, corner[1], corner[2]));
        side_to = step(before, at);
    }
    /// Numbers that have bit k where the side from corner k meets the other triangle.
    [[nodiscard]] HWY_INLINE Code bits(Where from_meets, Where to_meets) const
    {
        const auto bit = [](int first, int one, int two, Where is_one, Where is_two) HWY_ATTR {
            const auto number = [](int n) HWY_ATTR { return hn::Set(dc, std::uint64_t{1} << n); };
            return hn::IfThenElse(hn::RebindMask(dc, is_one), number(one),
                                  hn::IfThenElse(hn::RebindMask(dc, is_two), number(two), number(first)));
        };
        return hn::Or(hn::IfThenElseZero(hn::RebindMask(dc, from_meets), bit(0, 1, 2, second, third)),
                      hn::IfThenElseZero(hn::RebindMask(dc, to_meets), bit(2, 0, 1, second, third)));
    }
};

constexpr int k_bits_b = 8, k_bit_open = 16;  // of a code: sides_a, then sides_b, then that rounding leaves it open

/// The code of a pair in each lane, and the depth of those whose code is not zero. A line through both planes passes through two
/// sides of either triangle: the signs of these two pairs of sides are the order of the four positions on it, and a side meets
/// the triangle between whose two it is.
HWY_NOINLINE Code judge(const Corners& c, D& depth)
{
    const Products plane_a(step(c.a[0], c.a[1]), step(c.a[1], c.a[2])), plane_b(step(c.b[0], c.b[1]), step(c.b[1], c.b[2]));
    Heights of_a, of_b;
    for (int k = 0; k < 3; ++k) {
        of_b.corner[k] = plane_a.with(step(c.a[1], c.b[k]));
        of_a.corner[k] = plane_b.with(step(c.b[1], c.a[k]));
    }
    const Where beside = hn::Or(of_a.beside(), of_b.beside());
    if (hn::AllTrue(dd, beside)) return hn::Zero(dc);

    const Apex a(of_a, c.a), b(of_b, c.b);
    const D3 between = step(a.at, b.at);
    const Products from_b(b.side_from, between), to_b(b.side_to, between);
    const Sign from_from = from_b.with(a.side_from), from_to = to_b.with(a.side_from), to_from = from_b.with(a.side_to),
               to_to = to_b.with(a.side_to);
    const Where sure = hn::And(hn::And(of_a.all_known(), of_b.all_known()),
                               hn::And(hn::And(known(from_from), known(from_to)), hn::And(known(to_from), known(to_to))));
    const auto meet = [&](const Sign& x, const Sign& y)
                          HWY_ATTR { return hn::AndNot(beside, hn::AndNot(hn::Xor(x.above, y.above), sure)); };
    const Code code = hn::Or(a.bits(meet(from_from, from_to), meet(to_from, to_to)),
                             hn::ShiftLeft<k_bits_b>(b.bits(meet(from_from, to_from), meet(from_to, to_to))));
    depth = hn::Max(hn::Min(of_b.below(plane_a.cross), of_a.below(plane_b.cross)), hn::Zero(dd));
    const Where open = hn::Not(hn::Or(sure, beside));
    return hn::Or(code, hn::IfThenElseZero(hn::RebindMask(dc, open), hn::Set(dc, std::uint64_t{1} << k_bit_open)));
}

using DIndex = hn::RebindToSigned<DD>;
constexpr DIndex di{};

/// Numbers of the first coordinates of a block of pairs: corner, pair.
struct CornerBlock {
    HWY_ALIGN_MAX std::int64_t a[3][k_block], b[3][k_block];

    void read(const TriangleTree& tree_a, const TriangleTree& tree_b, std::span<const TrianglePair> pairs)
    {
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const ProbeTriangle &s = tree_a.triangle(pairs[i].a), &t = tree_b.triangle(pairs[i].b);
            for (std::size_t k = 0; k < 3; ++k) {
                a[k][i] = 3 * std::int64_t{s[k]};
                b[k][i] = 3 * std::int64_t{t[k]};
            }
        }
        // The rest of the last vector repeats the first pair.
        for (std::size_t i = pairs.size(); i % k_pair_lanes != 0; ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                a[k][i] = a[k][0];
                b[k][i] = b[k][0];
            }
    }
};

HWY_INLINE D3 load(const double* coordinates, const std::int64_t* from)
{
    const auto at = hn::Load(di, from);
    return {hn::GatherIndex(dd, coordinates, at), hn::GatherIndex(dd, coordinates + 1, at),
            hn::GatherIndex(dd, coordinates + 2, at)};
}
/// In the order of apply().
HWY_INLINE D3 moved(const Affine& map, const D3& p)
{
    const auto row = [&](Vec3d r, double shift) HWY_ATTR {
        const D turned =
            hn::Add(hn::Add(hn::Mul(hn::Set(dd, r.x), p.x), hn::Mul(hn::Set(dd, r.y), p.y)), hn::Mul(hn::Set(dd, r.z), p.z));
        return hn::Add(turned, hn::Set(dd, shift));
    };
    return {row(map.linear.row[0], map.shift.x), row(map.linear.row[1], map.shift.y), row(map.linear.row[2], map.shift.z)};
}

void search_crossings(const TriangleTree& tree_a, const TriangleTree& tree_b, const Affine& map,
                      std::span<const TrianglePair> pairs, CrossingRows& out)
{
    CornerBlock block;
    out.open = 0;
    for (std::size_t first = 0; first < pairs.size(); first += k_block) {
        const std::size_t count = std::min(k_block, pairs.size() - first);
        block.read(tree_a, tree_b, pairs.subspan(first, count));
        HWY_ALIGN std::uint64_t codes[k_block];
        for (std::size_t i = 0; i < count; i += hn::Lanes(dd)) {
            Corners corners;
            for (int k = 0; k < 3; ++k) {
                corners.a[k] = load(tree_a.coordinates(), block.a[k] + i);
                corners.b[k] = moved(map, load(tree_b.coordinates(), block.b[k] + i));
            }
            D depth = hn::Zero(dd);
            const Code code = judge(corners, depth);
            hn::Store(code, dc, codes + i);
            hn::StoreU(depth, dd, out.depths + first + i);
        }
        for (std::size_t i = 0; i < count; ++i) {
            out.crossings[first + i] = {static_cast<std::uint8_t>(codes[i]), static_cast<std::uint8_t>(codes[i] >> k_bits_b)};
            out.open |= (codes[i] >> k_bit_open) << (first + i);
        }
    }
}

#else  // the instruction set has no double: each pair is decided alone

void search_crossings(const TriangleTree& tree_a, const TriangleTree& tree_b, const Affine& map,
                      std::span<const TrianglePair> pairs, CrossingRows& out)
{
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const ProbeTriangle &s = tree_a.triangle(pairs[i].a), &t = tree_b.triangle(pairs[i].b);
        out.crossings[i] = {};
        out.depths[i] =
            depth_along_normals({tree_a.point(s[0]), tree_a.point(s[1]), tree_a.point(s[2])},
                                {apply(map, tree_b.point(t[0])), apply(map, tree_b.point(t[1])), apply(map, tree_b.point(t[2]))});
    }
    out.open = ~std::uint64_t{0} >> (64 - pairs.size());
}

#endif

}  // namespace

void run_crossings(const TriangleTree& a, const TriangleTree& b, const Affine& map, std::span<const TrianglePair> pairs,
                   CrossingRows& rows)
{
    search_crossings(a, b, map, pairs, rows);
}

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(run_crossings);

void find_crossings(const TriangleTree& a, const TriangleTree& b, const Affine& map, std::span<const TrianglePair> pairs,
                    CrossingRows& rows) noexcept
{
    rows.open = 0;
    if (!pairs.empty()) HWY_DYNAMIC_DISPATCH(run_crossings)(a, b, map, pairs, rows);
}

}  // namespace sqmap::query
#endif
