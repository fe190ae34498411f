// The boundary of a surface as loops of vertices.
#pragma once

#include "../surface.h"

namespace sqmap::mesh {

/// Loops that run along the boundary against the faces, each vertex once in a loop: where two holes touch in a vertex they come
/// apart there. Each starts at its least position, and they are sorted by it. @pre faces agree in orientation.
std::vector<std::vector<std::uint32_t>> boundary_loops(const Surface& surface);

}  // namespace sqmap::mesh
