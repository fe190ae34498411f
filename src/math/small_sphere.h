// A small sphere about points (J. Ritter, "An efficient bounding sphere", Graphics Gems, 1990, repeated).
#pragma once

#include "sqmap/math/box.h"
#include "sqmap/math/pose.h"

#include <cmath>
#include <cstddef>

namespace sqmap {

/// How the centre moves towards the farthest point: steps times, at first by a share of the way, which then shrinks.
template <class Real>
struct SphereSearch {
    int steps;
    Real pull, shrink;
};

/// From the box's centre. at(i): point i of count, finite. @pre count > 0
template <class Real, class At>
[[nodiscard]] Sphere3<Real> small_sphere(std::size_t count, At&& at, SphereSearch<Real> search)
{
    Box3<Real> box;
    for (std::size_t i = 0; i < count; ++i) extend(box, at(i));
    Vec3<Real> c = centre(box);
    Sphere3<Real> best{c, std::numeric_limits<Real>::infinity()};  // its radius squared
    for (int step = 0; step < search.steps; ++step, search.pull *= search.shrink) {
        Real radius_sq = 0;
        Vec3<Real> farthest = c;
        for (std::size_t i = 0; i < count; ++i)
            if (const Real d_sq = norm_sq(at(i) - c); d_sq > radius_sq) {
                radius_sq = d_sq;
                farthest = at(i);
            }
        if (radius_sq < best.radius) best = {c, radius_sq};
        c += search.pull * (farthest - c);
    }
    return {best.centre, std::sqrt(best.radius)};
}

}  // namespace sqmap
