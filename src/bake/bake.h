// From a validated mesh to a baked model: decompose, fit, map, and refine until the error is met.
#pragma once

#include "sqmap/bake/bake_types.h"
#include "sqmap/mesh/mesh.h"

namespace sqmap::bake {

/// Decomposes, fits, maps and refines until the target error is met or nothing more is gained.
/// mesh: admitted (mesh::admit), in mesh units. solid: it bounds a volume.
/// @throw mesh::InvalidInput for options out of range, or a partition that is none of this mesh
/// @throw mesh::RefusedMesh where a part exceeds the format's limits
/// Cost: seconds for some thousand triangles, on options.threads threads; the same bytes for any number of them. Thread-safe.
[[nodiscard]] BakeResult bake(const mesh::Mesh& mesh, bool solid, const BakeOptions& options);

}  // namespace sqmap::bake
