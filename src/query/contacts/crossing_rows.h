// The sides of two triangles that meet the other triangle, for many pairs at once.
#pragma once

#include "candidates.h"
#include "math/triangle_crossing.h"

#include <cstdint>
#include <span>

namespace sqmap::query {

/// How triangles of many pairs meet, and how deep they are in each other.
struct CrossingRows {
    static constexpr std::size_t k_max = 64;  ///< pairs
    Crossing crossings[k_max];
    /// depth_along_normals of pairs that meet or are open; void of others.
    double depths[k_max];
    /// Bit i: rounding leaves pair i open; its crossing is empty, and the caller has crossing_of decide it.
    std::uint64_t open = 0;
};

/// Fills the rows by crossing_of and depth_along_normals of the pairs' triangles, b's moved by b_in_a as apply() moves points.
/// @pre at most CrossingRows::k_max pairs
void find_crossings(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a, std::span<const TrianglePair> pairs,
                    CrossingRows& rows) noexcept;

}  // namespace sqmap::query
