// Distances in model space: what the vector kernels leave to be said of each point.
#pragma once

#include "sqmap/model/model.h"

#include <cstdint>
#include <span>

namespace sqmap::query {

/// What the triangles as near as the nearest say of the side that a point is on.
enum SeenSide : std::uint32_t { k_seen_outside = 1, k_seen_inside = 2, k_seen_unclear = 4 };

/// The nearest surface of a point, or a bound.
struct NearestSurface {
    Vec3f offset{};           ///< from the point to the surface
    float distance = 0;       ///< not negative
    std::int32_t entry = -1;  ///< triangle, or #triangles + piece; -1: no triangle was found
    std::uint32_t sides = 0;  ///< bits of SeenSide
    bool bound = false;       ///< distance is a lower bound
};

/// within: up to where exact answers are sought; -INFINITY: bounds for all, which may be negative. Outside the root of the tree
/// of bounds they may be less than half of the distance. @pre found.size() >= points.size()
void nearest_surfaces(const model::ModelView& model, float within, std::span<const Vec3f> points,
                      std::span<NearestSurface> found) noexcept;

}  // namespace sqmap::query
