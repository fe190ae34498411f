// Half-spaces: the sides of convex polytopes.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

namespace sqmap {

/// The points p with dot(normal, p) <= offset. normal: outward, not zero; unit and frame are those of the points.
template <class Real>
struct HalfSpace {
    Vec3<Real> normal;
    Real offset;

    friend constexpr bool operator==(const HalfSpace&, const HalfSpace&) = default;
};
/// In float.
using HalfSpacef = HalfSpace<float>;
/// In double.
using HalfSpaced = HalfSpace<double>;

/// In another number type, each number rounded to it.
template <class To, class From>
constexpr HalfSpace<To> cast(const HalfSpace<From>& side)
{
    return {cast<To>(side.normal), static_cast<To>(side.offset)};
}

/// True where all half-spaces hold p, in the arithmetic of Real; true without any.
template <class Sides, class Real>
[[nodiscard]] constexpr bool holds(const Sides& sides, Vec3<Real> p) noexcept
{
    for (const HalfSpace<Real>& side : sides)
        if (!(dot(side.normal, p) <= side.offset)) return false;
    return true;
}

}  // namespace sqmap
