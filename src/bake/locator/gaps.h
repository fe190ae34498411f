// How far a point lies below the planes that a bake puts into cells.
#pragma once

#include "model/locator_cells.h"

#include <cmath>
#include <cstddef>

namespace sqmap::bake {

/// How far a point is below a seed's plane, model units. offset: from the centre of the seed's cell, model units.
inline float seed_gap(const model::Locator& locator, model::Seed seed, Vec3f offset)
{
    return static_cast<float>(seed_distance(seed)) * (model::k_seed_distance_step * locator.cell) -
           dot(seed_normal(seed), offset);
}

/// How far a point is below the planes of a flat cell: the lowest of the groups' highest (see LocatorPlane), which plane that is,
/// and where its group ends.
struct FlatGap {
    float gap = INFINITY;
    std::size_t plane = 0, group_end = 0;
};
/// gap(k): below plane k; is_joined(k): it goes on with the group of the plane before it.
template <class Gap, class IsJoined>
FlatGap flat_gap(std::size_t planes, Gap&& gap, IsJoined&& is_joined)
{
    FlatGap lowest;
    for (std::size_t k = 0; k < planes;) {
        FlatGap highest{-INFINITY};
        do {
            const float below = gap(k);
            if (below > highest.gap) highest = {below, k};
        } while (++k < planes && is_joined(k));
        if (highest.gap < lowest.gap) lowest = {highest.gap, highest.plane, k};
    }
    return lowest;
}

}  // namespace sqmap::bake
