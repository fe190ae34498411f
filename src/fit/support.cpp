#include "math/double_targets.h"  // before Highway

#include "support.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/support.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "math/double_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::fit::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

HWY_INLINE D along(const D3& direction, const Vec3d* points)
{
    D3 p;
    hn::LoadInterleaved3(dd, &points->x, p.x, p.y, p.z);
    return dot(direction, p);
}

}  // namespace

double greatest_along(Vec3d direction, std::span<const Vec3d> points)
{
    const std::size_t lanes = hn::Lanes(dd), whole = points.size() / lanes * lanes;
    double greatest = -std::numeric_limits<double>::infinity();
    if (whole > 0) {
        const D3 towards = all(direction);
        D greatest_lanes = along(towards, points.data());
        for (std::size_t i = lanes; i < whole; i += lanes) greatest_lanes = hn::Max(greatest_lanes, along(towards, &points[i]));
        greatest = hn::GetLane(hn::MaxOfLanes(dd, greatest_lanes));
    }
    for (std::size_t i = whole; i < points.size(); ++i) greatest = std::max(greatest, dot(direction, points[i]));
    return greatest;
}

void mark_beyond(Vec3d direction, double offset, std::span<const Vec3d> points, std::span<std::uint64_t> words)
{
    std::fill(words.begin(), words.end(), 0);
    const std::size_t lanes = hn::Lanes(dd), whole = points.size() / lanes * lanes;
    const D3 towards = all(direction);
    for (std::size_t i = 0; i < whole; i += lanes) {
        std::uint8_t bits[8] = {};
        (void)hn::StoreMaskBits(dd, hn::Gt(along(towards, &points[i]), hn::Set(dd, offset)), bits);
        words[i / 64] |= std::uint64_t{bits[0]} << (i % 64);
    }
    for (std::size_t i = whole; i < points.size(); ++i)
        if (dot(direction, points[i]) > offset) words[i / 64] |= std::uint64_t{1} << (i % 64);
}

}  // namespace sqmap::fit::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::fit {

HWY_EXPORT(greatest_along);
HWY_EXPORT(mark_beyond);

double greatest_along(Vec3d direction, std::span<const Vec3d> points)
{
    return HWY_DYNAMIC_DISPATCH(greatest_along)(direction, points);
}
void mark_beyond(Vec3d direction, double offset, std::span<const Vec3d> points, std::span<std::uint64_t> words)
{
    HWY_DYNAMIC_DISPATCH(mark_beyond)(direction, offset, points, words);
}

}  // namespace sqmap::fit
#endif
