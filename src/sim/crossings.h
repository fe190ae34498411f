// Counts how often a cloth goes through itself.
#pragma once

#include "sqmap/math/vec.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::sim {

/// Pairs of an edge and a triangle without a vertex in common, where the edge goes through the triangle's interior; an edge of
/// two triangles counts once. Pairs that merely touch or lie in one plane do not count.
/// positions: #vertices by 3, m. triangles: #triangles by 3, each index less than #vertices.
/// same: #vertices, vertices with equal numbers are one (a sewn seam's pairs lie on each other); empty: each is its own.
/// Cost: O(n log n) in the triangles for cloth that is not heaped up, on Bullet's trees; allocates. Any thread.
[[nodiscard]] std::size_t crossings(std::span<const Vec3d> positions, std::span<const std::array<std::uint32_t, 3>> triangles,
                                    std::span<const std::uint32_t> same = {});

}  // namespace sqmap::sim
