// An order of many points in which neighbours follow one another, so that a batch of distances reads what caches hold.
#pragma once

#include "sqmap/math/vec.h"
#include "sqmap/query/body.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::query {

inline constexpr std::size_t k_ordered_at_once = 65536;  ///< more leave the caches while they wait

/// The points' numbers in an order in which points of one cell of a grid follow one another, and cells that are near to one
/// another too. Total, no allocation, 17 kB of stack. @pre touched.model != nullptr; at most k_ordered_at_once points, and
/// order.size() >= points.size()
void put_near_together(const Body& touched, std::span<const Vec3d> points, std::span<std::uint16_t> order) noexcept;

}  // namespace sqmap::query
