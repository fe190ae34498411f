// Fills holes of any size: least area, refined to the spacing around, fair, and without crossings where one of its shapes has
// none.
#pragma once

#include "../surface.h"

#include <cstdint>

namespace sqmap::mesh {

/// Closes every loop of the boundary; the faces made have no polygon. Returns how many loops were closed.
/// max_triangles: about how many are made; past that, fillings are coarse; 0: only between the points there are. @pre faces agree
/// in orientation, every edge has at most two of them. Cost: 1e4 areas a boundary edge, and of each filling a sparse system.
std::uint32_t fill_holes(Surface& surface, std::size_t max_triangles);

}  // namespace sqmap::mesh
