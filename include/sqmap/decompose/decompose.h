// Decomposition of a mesh into quasi-convex parts by visual salience and curvature (section 3).
#pragma once

#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <vector>

namespace sqmap::decompose {

/// Why a boundary between two parts exists. Salient and curvature cuts passed a test of section 3.
enum class CutKind : std::uint8_t { Salient, Curvature, Error };

/// Parts of a mesh: one label a triangle; every part is connected through edges.
struct Partition {
    std::vector<std::uint32_t> part_of_triangle;  ///< #triangles, values in [0, part_count)
    std::uint32_t part_count = 0;
};

}  // namespace sqmap::decompose
