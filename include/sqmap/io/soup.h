// Polygons of a mesh file, not yet checked.
// Plain data: any number of threads may read it.
#pragma once

#include "sqmap/math/vec.h"

#include <cstdint>
#include <vector>

namespace sqmap::io {

/// Polygons as read: nothing is promised about indices, coordinates or topology.
struct PolygonSoup {
    std::vector<Vec3d> positions;
    std::vector<std::uint32_t> polygon_offsets{0};  ///< #polygons + 1: polygon i is indices[offsets[i] .. offsets[i+1])
    std::vector<std::int64_t> indices;              ///< zero-based, already resolved when the file counts from the end
};

}  // namespace sqmap::io
