// A filling while it is made: a triangulated disc in a loop, with the surface around it.
#pragma once

#include "edge_set.h"
#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <vector>

namespace sqmap::mesh {

/// Points: the loop's, then those of the rim, then those made up within.
struct Patch {
    std::vector<Vec3d> points;
    std::uint32_t loop_size = 0;
    std::uint32_t first_inner = 0;    ///< of the points that are made up
    std::vector<Triangle> triangles;  ///< turned as the loop runs
    std::vector<Triangle> rim;        ///< faces of the surface with a corner in the loop
    std::vector<double> spacing;      ///< #points: length of the edges about one
    EdgeSet taken;                    ///< edges of the surface between points of the loop
};

/// Puts points into the patch until its triangles are as small as those about it, and turns edges so that they are well shaped.
/// At most max_triangles: beyond, the patch stays coarser. After Liepa.
void refine(Patch& patch, std::size_t max_triangles);

/// How a patch goes on from the surface around it.
enum class Fairing {
    Taut,    ///< of least area: its Laplacian is zero
    Smooth,  ///< its bi-Laplacian is zero: it goes on in the surface's direction
};

/// Moves the points within. False, and nothing moved, where the equations cannot be solved.
bool fair(Patch& patch, Fairing fairing);

/// Share of the loop's length where the patch goes on from the surface, bending by less than 60 degrees.
[[nodiscard]] double smooth_share(const Patch& patch);

}  // namespace sqmap::mesh
