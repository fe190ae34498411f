// From polygons as read to triangles over the vertices in use.
#pragma once

#include "sqmap/math/box.h"
#include "sqmap/mesh/admit.h"

#include "surface.h"

namespace sqmap::mesh {

struct Soup {
    Surface surface;
    Box box;  ///< of the vertices in use
    std::uint64_t unused_vertices = 0, cut_polygons = 0;
    std::uint64_t degenerate_polygons = 0;  ///< that repeat a corner
};

/// Judges the numbers and cuts polygons into triangles.
/// @throw Refused for what the numbers say: Index, NonFinite, Empty, Range, Limit
[[nodiscard]] Soup soup_of(const PolygonView& polygons);

}  // namespace sqmap::mesh
