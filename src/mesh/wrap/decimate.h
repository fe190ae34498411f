// Fewer triangles for the same surface.
#pragma once

#include "closed_mesh.h"

#include "sqmap/mesh/bvh.h"

#include <cstdint>

namespace sqmap::mesh {

struct DecimateLimits {
    double max_error = 0;  ///< distance of any sample from the result
    std::uint32_t max_triangles = 0;
};

/// Collapses edges while every sample stays within max_error of the surface, and farther, by doubling it, until the triangles
/// are few enough. Vertices that lie on the input stay on it. Returns the error that was allowed in the end. Closed and
/// manifold stay as they are.
double decimate(ClosedMesh& mesh, const Bvh& bvh, const DecimateLimits& limits);

}  // namespace sqmap::mesh
