// Vectors of up to eight points in double, compiled for each instruction set by Highway without fused multiply-add.
#if defined(SQMAP_MATH_DOUBLE_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_MATH_DOUBLE_LANES_INL_H
#undef SQMAP_MATH_DOUBLE_LANES_INL_H
#else
#define SQMAP_MATH_DOUBLE_LANES_INL_H
#endif

#ifndef SQMAP_HAS_DOUBLE_TARGETS
#error "include math/double_targets.h before Highway"
#endif

#include "sqmap/math/vec.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sqmap::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using DD = hn::CappedTag<double, 8>;
using D = hn::Vec<DD>;
constexpr DD dd{};

struct D3 {
    D x, y, z;
};
HWY_INLINE D3 minus(const D3& a, const D3& b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }
HWY_INLINE D dot(const D3& a, const D3& b) { return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z)); }
HWY_INLINE D3 cross(const D3& a, const D3& b)
{
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
/// The same vector for all points.
HWY_INLINE D3 all(Vec3d v) { return {hn::Set(dd, v.x), hn::Set(dd, v.y), hn::Set(dd, v.z)}; }

}  // namespace
}  // namespace sqmap::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
