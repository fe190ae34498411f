// The search for a foot step by step (section 4.2.2, Figs. 6 and 7): for pictures and for teaching.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/query/normal_projection.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::query {

/// A position of the superquadric that a search has looked at.
struct FootSearchStep {
    shape::SurfaceAnglesf angles;
    float distance = 0;        ///< to the point, model units
    float collinearity = 0;    ///< I_S of eq. 19
    std::uint32_t stride = 0;  ///< samples of the finest grid between neighbours of this level; 0: a step of Newton's method
    bool better = false;       ///< the best so far
};

/// Every step of the search that project() makes for a point, in order; the last one that was better is where it ends, to the
/// bit. options: the projector counts; layer Three. Returns how many there were, of which as many as the span holds are written:
/// 0 where the superquadric does not hold the point. Total. @pre is_consistent(map)
std::size_t record_foot_search(const NormalMapView& map, Vec3f p, Projector projector, std::span<FootSearchStep> steps) noexcept;

}  // namespace sqmap::query
