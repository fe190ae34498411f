#include "rulers.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bake/locator/rulers.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sqmap::bake::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 8>;
using V = hn::Vec<D>;
constexpr D d{};

/// 1 at the corners at the greater end of an axis.
alignas(32) constexpr float k_is_greater[3][8] = {{0, 1, 0, 1, 0, 1, 0, 1}, {0, 0, 1, 1, 0, 0, 1, 1}, {0, 0, 0, 0, 1, 1, 1, 1}};

/// True if a plane is above one of the rulers at all corners. lowest: its value at corner 0; rise: along each side.
HWY_INLINE bool is_above_one(const Rulers& rulers, float lowest, const float (&rise)[3])
{
    alignas(32) float plane[8];
    for (std::size_t k = 0; k < 8; k += hn::Lanes(d)) {
        V value = hn::Set(d, lowest);
        for (std::size_t axis = 0; axis < 3; ++axis)  // a product with 0 or 1 is exact
            value = hn::Add(value, hn::Mul(hn::Set(d, rise[axis]), hn::Load(d, k_is_greater[axis] + k)));
        hn::Store(value, d, plane + k);
    }
    for (std::size_t r = 0; r < rulers.count; ++r) {
        bool above = true;
        for (std::size_t k = 0; k < 8 && above; k += hn::Lanes(d))
            above = hn::AllFalse(d, hn::Le(hn::Sub(hn::Load(d, plane + k), hn::Load(d, rulers.value[r] + k)), hn::Zero(d)));
        if (above) return true;
    }
    return false;
}

}  // namespace

bool rule_out(const Rulers& rulers, const LatticeDistances& of, const std::size_t (&corners)[8], std::size_t nearest,
              std::size_t tried, float side, float slack)
{
    for (std::size_t i = 0; i < tried; ++i) {
        const std::size_t j = nearest ^ i, at = corners[j];
        // Away from the triangle distance grows.
        const float scale = -side / of.distance[at];
        const float rise[3] = {scale * of.offset[0][at], scale * of.offset[1][at], scale * of.offset[2][at]};
        const float lowest =
            of.distance[at] - slack - ((j & 1) != 0 ? rise[0] : 0) - ((j & 2) != 0 ? rise[1] : 0) - ((j & 4) != 0 ? rise[2] : 0);
        if (is_above_one(rulers, lowest, rise)) return true;
    }
    return false;
}

}  // namespace sqmap::bake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::bake {

HWY_EXPORT(rule_out);

bool Rulers::rule_out(const LatticeDistances& of, const std::size_t (&corners)[8], std::size_t nearest, std::size_t tried,
                      float side, float slack) const
{
    return HWY_DYNAMIC_DISPATCH(rule_out)(*this, of, corners, nearest, tried, side, slack);
}

}  // namespace sqmap::bake
#endif
