// Which sides of two triangles meet the other triangle, for many pairs at once.
#pragma once

#include "candidates.h"
#include "math/triangle_crossing.h"

#include <span>

namespace sqmap::query {

/// Fills crossings[i] with crossing_of the triangles of pairs[i], b's moved by b_in_a as apply() moves points, and returns a mask
/// whose bit i says that rounding leaves pair i open: crossings[i] is empty there, and the caller has crossing_of decide it.
/// @pre at most 64 pairs, crossings has as many elements
[[nodiscard]] std::uint64_t find_crossings(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a,
                                           std::span<const TrianglePair> pairs, Crossing* crossings) noexcept;

}  // namespace sqmap::query
