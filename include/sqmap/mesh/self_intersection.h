// Triangles of a mesh that cut each other, decided exactly.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// The self-intersections of a mesh.
struct SelfIntersections {
    std::uint64_t pair_count = 0;
    bool is_complete = true;            ///< false: counting stopped at max_pairs
    std::vector<std::uint8_t> crossed;  ///< #triangles: 1 where another triangle cuts, touches or overlaps it
};

/// Pairs of triangles that have more in common than the vertices they share: disjoint ones that meet at all (in one point,
/// too: a vertex split in two touches itself), neighbours that fold onto or pass through each other. Exact for the coordinates as
/// given (no tolerance). among: #triangles, only pairs of which one is non-zero; empty for all. Cost: n log n + pairs whose boxes
/// overlap.
[[nodiscard]] SelfIntersections find_self_intersections(const Mesh& mesh,
                                                        std::uint64_t max_pairs = std::numeric_limits<std::uint64_t>::max(),
                                                        std::span<const std::uint8_t> among = {});

}  // namespace sqmap::mesh
