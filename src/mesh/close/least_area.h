// Triangles of least total area over a loop of points.
#pragma once

#include "edge_set.h"
#include "sqmap/mesh/mesh.h"

#include <span>
#include <vector>

namespace sqmap::mesh {

/// Triangles of positions in the loop, turned as it runs, of least total area without a side that is in taken; of loops longer
/// than about 200 points each piece of such length is. Empty where none avoids what is taken. Cost: at most 1e4 areas a point.
[[nodiscard]] std::vector<Triangle> least_area(std::span<const Vec3d> loop, const EdgeSet& taken);

}  // namespace sqmap::mesh
