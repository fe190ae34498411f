// P. Guigue and O. Devillers, "Fast and robust triangle-triangle overlap test using orientation predicates", 2003, a pair of
// triangles in each lane. J. R. Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
// 1997: his first bound says which signs double is sure of. It holds for any determinant of three vectors whose elements are
// differences of two coordinates: here of two sides and of the step from one to the other, or of two sides and a step of one
// triangle, whose products many determinants share.
#include "crossing_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/contacts/crossing_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_HAVE_FLOAT64

using DD = hn::CappedTag<double, 8>;
using D = hn::Vec<DD>;
using Where = hn::Mask<DD>;
constexpr DD dd{};
constexpr std::size_t k_pair_lanes = hn::MaxLanes(DD());
constexpr std::size_t k_block = 16;  // pairs whose corners are read at once
static_assert(k_block % k_pair_lanes == 0 && 64 % k_block == 0);

struct D3 {
    D x, y, z;
};
HWY_INLINE D3 step(const D3& from, const D3& to) { return {hn::Sub(to.x, from.x), hn::Sub(to.y, from.y), hn::Sub(to.z, from.z)}; }

/// Where a determinant is surely positive, and where surely negative.
struct Sign {
    Where above, below;
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
        return {hn::Gt(det, bound), hn::Lt(det, hn::Neg(bound))};
    }
};

/// Corners of triangles, those of a and those of b in a's frame.
struct Corners {
    D3 a[3], b[3];
};

/// What is known of vectors of pairs.
struct Verdict {
    Where sides_a[3], sides_b[3], open;
};

/// Sides between corners on different sides of the other's plane, whose three signs about the other's sides agree.
struct SideSigns {
    Where all_above, all_below, any_above, any_below;
    bool is_first = true;

    HWY_INLINE void add(const Sign& sign)
    {
        all_above = is_first ? sign.above : hn::And(all_above, sign.above);
        all_below = is_first ? sign.below : hn::And(all_below, sign.below);
        any_above = is_first ? sign.above : hn::Or(any_above, sign.above);
        any_below = is_first ? sign.below : hn::Or(any_below, sign.below);
        is_first = false;
    }
    [[nodiscard]] HWY_INLINE Where agree() const { return hn::Or(all_above, all_below); }
    [[nodiscard]] HWY_INLINE Where differ() const { return hn::And(any_above, any_below); }
};

/// Heights of one triangle's corners over the plane of the other.
struct Heights {
    Sign corner[3];

    [[nodiscard]] HWY_INLINE Where beside() const
    {
        return hn::Or(hn::And(corner[0].above, hn::And(corner[1].above, corner[2].above)),
                      hn::And(corner[0].below, hn::And(corner[1].below, corner[2].below)));
    }
    [[nodiscard]] HWY_INLINE Where known() const
    {
        const auto is_known = [&](int k) HWY_ATTR { return hn::Or(corner[k].above, corner[k].below); };
        return hn::And(is_known(0), hn::And(is_known(1), is_known(2)));
    }
    /// The side from corner k on passes through the plane, where all are known.
    [[nodiscard]] HWY_INLINE Where passes(int k) const { return hn::Xor(corner[k].above, corner[(k + 1) % 3].above); }
};

/// False where no pair of the lanes meets, for sure.
HWY_NOINLINE bool judge(const Corners& c, Verdict& out)
{
    D3 side_a[3], side_b[3];
    for (int k = 0; k < 3; ++k) {
        side_a[k] = step(c.a[k], c.a[(k + 1) % 3]);
        side_b[k] = step(c.b[k], c.b[(k + 1) % 3]);
    }
    const Products plane_a(side_a[0], side_a[1]), plane_b(side_b[0], side_b[1]);
    Heights of_a, of_b;
    for (int k = 0; k < 3; ++k) {
        of_b.corner[k] = plane_a.with(step(c.a[1], c.b[k]));
        of_a.corner[k] = plane_b.with(step(c.b[1], c.a[k]));
    }
    const Where beside = hn::Or(of_a.beside(), of_b.beside());
    if (hn::AllTrue(dd, beside)) return false;

    SideSigns signs_a[3], signs_b[3];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const Sign sign = Products(side_a[i], side_b[j]).with(step(c.a[i], c.b[j]));
            signs_a[i].add(sign);
            signs_b[j].add(sign);
        }
    const Where known = hn::And(of_a.known(), of_b.known());
    Where sure = known;
    for (int k = 0; k < 3; ++k) {
        const Where a = hn::And(known, of_a.passes(k)), b = hn::And(known, of_b.passes(k));
        out.sides_a[k] = hn::AndNot(beside, hn::And(a, signs_a[k].agree()));
        out.sides_b[k] = hn::AndNot(beside, hn::And(b, signs_b[k].agree()));
        sure = hn::AndNot(hn::AndNot(hn::Or(signs_a[k].agree(), signs_a[k].differ()), a), sure);
        sure = hn::AndNot(hn::AndNot(hn::Or(signs_b[k].agree(), signs_b[k].differ()), b), sure);
    }
    out.open = hn::Not(hn::Or(sure, beside));
    return true;
}

/// Points of the triangles of a block of pairs as the caller gave them: corner, axis, pair.
struct CornerBlock {
    HWY_ALIGN double a[3][3][k_block], b[3][3][k_block];

    void read(const TriangleTree& tree_a, const TriangleTree& tree_b, std::span<const TrianglePair> pairs)
    {
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const ProbeTriangle &s = tree_a.triangle(pairs[i].a), &t = tree_b.triangle(pairs[i].b);
            for (std::size_t k = 0; k < 3; ++k) {
                put(tree_a.point(s[k]), a[k], i);
                put(tree_b.point(t[k]), b[k], i);
            }
        }
        // The rest of the last vector repeats the first pair.
        for (std::size_t i = pairs.size(); i % k_pair_lanes != 0; ++i)
            for (std::size_t k = 0; k < 3; ++k)
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    a[k][axis][i] = a[k][axis][0];
                    b[k][axis][i] = b[k][axis][0];
                }
    }

private:
    static void put(Vec3d p, double (&to)[3][k_block], std::size_t i)
    {
        to[0][i] = p.x;
        to[1][i] = p.y;
        to[2][i] = p.z;
    }
};

HWY_INLINE D3 load(const double (&from)[3][k_block], std::size_t i)
{
    return {hn::Load(dd, from[0] + i), hn::Load(dd, from[1] + i), hn::Load(dd, from[2] + i)};
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
HWY_INLINE std::uint32_t lanes_of(Where mask)
{
    HWY_ALIGN std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(dd, mask, bytes);
    return bytes[0];
}

std::uint64_t search_crossings(const TriangleTree& tree_a, const TriangleTree& tree_b, const Affine& map,
                               std::span<const TrianglePair> pairs, Crossing* out)
{
    std::uint64_t open = 0;
    CornerBlock block;
    for (std::size_t first = 0; first < pairs.size(); first += k_block) {
        const std::size_t count = std::min(k_block, pairs.size() - first);
        block.read(tree_a, tree_b, pairs.subspan(first, count));
        for (std::size_t i = 0; i < count; i += hn::Lanes(dd)) {
            Corners corners;
            for (int k = 0; k < 3; ++k) {
                corners.a[k] = load(block.a[k], i);
                corners.b[k] = moved(map, load(block.b[k], i));
            }
            const std::size_t used = std::min(hn::Lanes(dd), count - i);
            std::fill_n(out + first + i, used, Crossing{});
            Verdict verdict;
            if (!judge(corners, verdict)) continue;
            for (int k = 0; k < 3; ++k) {
                const std::uint32_t a = lanes_of(verdict.sides_a[k]), b = lanes_of(verdict.sides_b[k]);
                for (std::size_t lane = 0; lane < used; ++lane) {
                    Crossing& c = out[first + i + lane];
                    c.sides_a = static_cast<std::uint8_t>(c.sides_a | (a >> lane & 1u) << k);
                    c.sides_b = static_cast<std::uint8_t>(c.sides_b | (b >> lane & 1u) << k);
                }
            }
            const std::uint32_t left = lanes_of(verdict.open) & ((1u << used) - 1);
            for (std::size_t lane = 0; left != 0 && lane < used; ++lane)
                if ((left >> lane & 1u) != 0) out[first + i + lane] = {};
            open |= std::uint64_t{left} << (first + i);
        }
    }
    return open;
}

#else  // the instruction set has no double: each pair is decided alone

std::uint64_t search_crossings(const TriangleTree&, const TriangleTree&, const Affine&, std::span<const TrianglePair> pairs,
                               Crossing* out)
{
    std::fill_n(out, pairs.size(), Crossing{});
    return ~std::uint64_t{0} >> (64 - pairs.size());
}

#endif

}  // namespace

std::uint64_t run_crossings(const TriangleTree& a, const TriangleTree& b, const Affine& map, std::span<const TrianglePair> pairs,
                            Crossing* out)
{
    return search_crossings(a, b, map, pairs, out);
}

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(run_crossings);

std::uint64_t find_crossings(const TriangleTree& a, const TriangleTree& b, const Affine& map, std::span<const TrianglePair> pairs,
                             Crossing* crossings) noexcept
{
    return pairs.empty() ? 0 : HWY_DYNAMIC_DISPATCH(run_crossings)(a, b, map, pairs, crossings);
}

}  // namespace sqmap::query
#endif
