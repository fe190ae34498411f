// A coarse copy of a fine mesh, for what depends on its shape alone.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <vector>

namespace sqmap::mesh {

struct Simplified {
    Mesh mesh;                           ///< not canonical
    std::vector<std::uint32_t> carrier;  ///< #vertices of the fine mesh: the triangle of the coarse one that each lies near
};

/// Collapses edges until there are so many triangles, or no edge may go: a manifold stays one, components stay apart, and a
/// border is no longer than it was. Vertices stay within a few sides of a coarse triangle of their carriers, most within a
/// twentieth. Cost: some 5 us a triangle.
[[nodiscard]] Simplified simplified(const Mesh& mesh, std::uint32_t triangles);

}  // namespace sqmap::mesh
