// The tree of bounds for a vector of points at a time.
#if defined(SQMAP_QUERY_BOUNDS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_BOUNDS_INL_H
#undef SQMAP_QUERY_BOUNDS_INL_H
#else
#define SQMAP_QUERY_BOUNDS_INL_H
#endif

#include "math/lanes-inl.h"
#include "model/bound_tree.h"

#include "sqmap/model/model.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

/// The leaf that holds each point.
struct BoundLeaf {
    I node;  // its index
    I word;
    V3 offset;  // from its centre
    F bound;    // from the point to the surface, at least; may be negative
};

/// The leaf of the tree of bounds that holds a point; for a point outside the root, the outermost leaf towards it. @pre
/// there is a tree
HWY_INLINE BoundLeaf find_leaf(const model::DistanceArrays<model::ArrayView>& arrays, const V3& p)
{
    BoundLeaf leaf;
    leaf.offset = minus(p, {set(arrays.header.root[0]), set(arrays.header.root[1]), set(arrays.header.root[2])});
    const I nil = hn::Zero(di);
    const F zero = hn::Zero(df);
    F half = set(arrays.header.half);
    I block = nil;
    leaf.word = nil;
    M open = hn::Eq(zero, zero);
    for (int depth = 0; depth < model::k_max_bound_depth && any(open); ++depth) {
        const M up_x = hn::Ge(leaf.offset.x, zero), up_y = hn::Ge(leaf.offset.y, zero), up_z = hn::Ge(leaf.offset.z, zero);
        const I child =
            hn::Add(blend(up_x, set_int(1), nil), hn::Add(blend(up_y, set_int(2), nil), blend(up_z, set_int(4), nil)));
        const I node = hn::Add(hn::ShiftLeft<3>(block), child);
        half = blend(open, hn::Mul(half, set(0.5f)), half);
        const auto move = [&](M up, F v)
                              HWY_ATTR { return blend(open, hn::Sub(v, hn::CopySign(half, blend(up, half, hn::Neg(half)))), v); };
        leaf.offset = {move(up_x, leaf.offset.x), move(up_y, leaf.offset.y), move(up_z, leaf.offset.z)};
        leaf.word = blend(open, low(gather_pair(arrays.bounds.data(), blend(open, node, nil))), leaf.word);
        block = leaf.word;
        open = hn::And(open, equal(hn::And(leaf.word, set_int(static_cast<std::int32_t>(model::k_bound_leaf))), nil));
    }
    const I code = hn::And(leaf.word, set_int(static_cast<std::int32_t>(model::k_bound_code)));
    const F distance = hn::Mul(hn::Mul(to_float(code), set(model::k_bound_step)), half);
    // Less what rounding takes.
    const F away = hn::Mul(hn::Sqrt(dot(leaf.offset, leaf.offset)), set(1.00001f));
    leaf.bound = hn::Sub(distance, away);
    return leaf;
}

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
