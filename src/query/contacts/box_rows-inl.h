// Boxes and triangles of two trees side by side, as the searches for pairs read them; compiled for each instruction set.
#if defined(SQMAP_QUERY_CONTACTS_BOX_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_CONTACTS_BOX_ROWS_INL_H
#undef SQMAP_QUERY_CONTACTS_BOX_ROWS_INL_H
#else
#define SQMAP_QUERY_CONTACTS_BOX_ROWS_INL_H
#endif

#include "query/contacts/candidates.h"
#include "query/probe/triangle_tree.h"

#include "math/lanes-inl.h"

#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

constexpr std::size_t k_row = TriangleTree::k_group;
static_assert(k_row == TriangleTree::k_leaf && k_row % k_lanes == 0);

using BoxRow = TriangleTree::BoxRow;
using CornerRow = TriangleTree::CornerRow;

constexpr std::uint32_t first_bits(std::size_t count) { return count >= k_row ? 0xffffu : (1u << count) - 1; }

HWY_INLINE F sum_of_sizes(const V3& v) { return hn::Add(hn::Abs(v.x), hn::Add(hn::Abs(v.y), hn::Abs(v.z))); }
HWY_INLINE V3 set3(const float* v) { return {set(v[0]), set(v[1]), set(v[2])}; }

/// A box for all lanes.
struct OneBox {
    V3 lo, hi;
    OneBox(const BoxRow& row, std::size_t i)
        : lo{set(row.lo[0][i]), set(row.lo[1][i]), set(row.lo[2][i])}, hi{set(row.hi[0][i]), set(row.hi[1][i]), set(row.hi[2][i])}
    {
    }
    explicit OneBox(const Boxf& box)
        : lo{set(box.lo.x), set(box.lo.y), set(box.lo.z)}, hi{set(box.hi.x), set(box.hi.y), set(box.hi.z)}
    {
    }
};
HWY_INLINE M overlapping(const V3& lo, const V3& hi, const OneBox& box)
{
    const M x = hn::And(hn::Le(lo.x, box.hi.x), hn::Le(box.lo.x, hi.x)),
            y = hn::And(hn::Le(lo.y, box.hi.y), hn::Le(box.lo.y, hi.y)),
            z = hn::And(hn::Le(lo.z, box.hi.z), hn::Le(box.lo.z, hi.z));
    return hn::And(x, hn::And(y, z));
}
HWY_INLINE V3 at(const float (&of)[3][k_row], std::size_t i)
{
    return {hn::LoadU(df, of[0] + i), hn::LoadU(df, of[1] + i), hn::LoadU(df, of[2] + i)};
}
HWY_INLINE void store(const V3& v, float (&to)[3][k_row], std::size_t i)
{
    hn::StoreU(v.x, df, to[0] + i);
    hn::StoreU(v.y, df, to[1] + i);
    hn::StoreU(v.z, df, to[2] + i);
}
/// Bit i: box i of the row overlaps the box.
HWY_INLINE std::uint32_t overlapping(const BoxRow& row, const OneBox& box)
{
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < k_row; i += hn::Lanes(df))
        bits |= static_cast<std::uint32_t>(bits_of(overlapping(at(row.lo, i), at(row.hi, i), box))) << i;
    return bits;
}
template <class Do>
HWY_INLINE void each_bit(std::uint32_t bits, Do&& action)
{
    for (; bits != 0; bits &= bits - 1) action(static_cast<std::size_t>(std::countr_zero(bits)));
}

/// A position about the centre of b's box, about that of a's.
HWY_INLINE V3 moved(const PosedTrees& trees, const V3& p)
{
    const float* r = trees.rotation;
    return {hn::Add(row_dot(r, p), set(trees.shift[0])), hn::Add(row_dot(r + 3, p), set(trees.shift[1])),
            hn::Add(row_dot(r + 6, p), set(trees.shift[2]))};
}
/// Boxes about b's boxes in a's frame, larger by the margin.
HWY_NOINLINE void move_boxes(const PosedTrees& trees, const BoxRow& from, BoxRow& to)
{
    const F half = set(0.5f), error = set(trees.margin);
    for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
        const V3 lo = at(from.lo, i), hi = at(from.hi, i);
        const V3 middle{hn::Mul(half, hn::Add(lo.x, hi.x)), hn::Mul(half, hn::Add(lo.y, hi.y)),
                        hn::Mul(half, hn::Add(lo.z, hi.z))};
        const V3 extent = minus(hi, middle), c = moved(trees, middle);
        const auto reach = [&](int k) HWY_ATTR {
            const float* r = trees.rotation + 3 * k;
            return mul_add(set(std::abs(r[0])), extent.x,
                           mul_add(set(std::abs(r[1])), extent.y, mul_add(set(std::abs(r[2])), extent.z, error)));
        };
        const V3 d{reach(0), reach(1), reach(2)};
        store(minus(c, d), to.lo, i);
        store({hn::Add(c.x, d.x), hn::Add(c.y, d.y), hn::Add(c.z, d.z)}, to.hi, i);
    }
}

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
