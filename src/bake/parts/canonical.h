// The frame in which parts are fitted: the mesh's own.
#pragma once

#include "sqmap/math/vec.h"
#include "sqmap/mesh/mesh.h"

namespace sqmap::bake {

/// The mesh in its principal frame: vertices turned and sorted there, every triangle in its old order but starting at its least
/// vertex. What is computed from it depends on the mesh's frame through rounding only.
struct CanonicalMesh {
    mesh::Mesh mesh;
    Mat3d frame;  ///< turns model space into the canonical frame
};
[[nodiscard]] CanonicalMesh canonical_mesh(const mesh::Mesh& mesh);

}  // namespace sqmap::bake
