// Axis-aligned boxes.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <type_traits>

namespace sqmap {

/// The points p with lo <= p <= hi along each axis; empty as made. Any frame and unit, that of its corners.
template <class Real>
struct Box3 {
    Vec3<Real> lo{std::numeric_limits<Real>::infinity(), std::numeric_limits<Real>::infinity(),
                  std::numeric_limits<Real>::infinity()};
    Vec3<Real> hi{-std::numeric_limits<Real>::infinity(), -std::numeric_limits<Real>::infinity(),
                  -std::numeric_limits<Real>::infinity()};

    friend constexpr bool operator==(const Box3&, const Box3&) = default;
};
/// In float.
using Boxf = Box3<float>;
/// In double.
using Box = Box3<double>;

/// Makes the box hold p as well. A coordinate that is not a number changes nothing.
template <class Real>
constexpr void extend(Box3<Real>& box, Vec3<Real> p) noexcept
{
    for (int k = 0; k < 3; ++k) {
        box.lo[k] = std::min(box.lo[k], p[k]);
        box.hi[k] = std::max(box.hi[k], p[k]);
    }
}

/// Makes the box hold the other as well; an empty one changes nothing.
template <class Real>
constexpr void extend(Box3<Real>& box, const Box3<Real>& other) noexcept
{
    for (int k = 0; k < 3; ++k) {
        box.lo[k] = std::min(box.lo[k], other.lo[k]);
        box.hi[k] = std::max(box.hi[k], other.hi[k]);
    }
}

/// The smallest box that holds the points; empty without any. Linear.
template <class Points>
[[nodiscard]] constexpr auto box_of(const Points& points) noexcept
{
    Box3<std::remove_cvref_t<decltype(std::begin(points)->x)>> box;
    for (const auto& p : points) extend(box, p);
    return box;
}

/// True if the box holds no point.
template <class Real>
[[nodiscard]] constexpr bool is_empty(const Box3<Real>& box) noexcept
{
    return !(box.lo.x <= box.hi.x && box.lo.y <= box.hi.y && box.lo.z <= box.hi.z);
}

/// Lengths of the sides. Of an empty box: minus infinity.
template <class Real>
[[nodiscard]] constexpr Vec3<Real> size(const Box3<Real>& box) noexcept
{
    return box.hi - box.lo;
}

/// Its middle, to one rounding a coordinate. Of an empty box: not a number.
template <class Real>
[[nodiscard]] constexpr Vec3<Real> centre(const Box3<Real>& box) noexcept
{
    return Real(0.5) * (box.lo + box.hi);
}

/// True if p is in the box or on its sides.
template <class Real>
[[nodiscard]] constexpr bool contains(const Box3<Real>& box, Vec3<Real> p) noexcept
{
    return box.lo.x <= p.x && p.x <= box.hi.x && box.lo.y <= p.y && p.y <= box.hi.y && box.lo.z <= p.z && p.z <= box.hi.z;
}

/// True if two boxes have a point in common, also if they only touch.
template <class Real>
[[nodiscard]] constexpr bool overlap(const Box3<Real>& a, const Box3<Real>& b) noexcept
{
    return a.lo.x <= b.hi.x && b.lo.x <= a.hi.x && a.lo.y <= b.hi.y && b.lo.y <= a.hi.y && a.lo.z <= b.hi.z && b.lo.z <= a.hi.z;
}

/// The axis along which the box is longest, the first of equals.
template <class Real>
[[nodiscard]] constexpr int longest_axis(const Box3<Real>& box) noexcept
{
    const Vec3<Real> s = size(box);
    return s.x >= s.y && s.x >= s.z ? 0 : (s.y >= s.z ? 1 : 2);
}

}  // namespace sqmap
