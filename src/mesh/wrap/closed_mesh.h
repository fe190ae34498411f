// A closed manifold with flags, while it is made smaller.
#pragma once

#include "positions.h"

#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <vector>

namespace sqmap::mesh {

struct ClosedMesh {
    std::vector<Vec3d> vertices;
    std::vector<Triangle> triangles;
    std::vector<std::uint8_t> made_up;   ///< #triangles
    std::vector<Vec3d> samples;          ///< of the surface
    std::vector<std::uint32_t> carrier;  ///< #samples: a triangle on or near which it lies
};

/// The quadrilaterals cut into triangles, along the diagonal that is nearer to the crossing.
[[nodiscard]] ClosedMesh triangulated(const DualSurface& surface, const Positions& positions);

/// Leaves out components whose box has a shorter diagonal than that.
void drop_crumbs(ClosedMesh& mesh, double diagonal);

}  // namespace sqmap::mesh
