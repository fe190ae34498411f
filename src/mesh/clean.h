// Repairs of a polygon soup that leave no doubt about the surface that was meant.
#pragma once

#include "sqmap/math/box.h"

#include "surface.h"

namespace sqmap::mesh {

/// Counts of cleaning.
struct Cleaned {
    std::uint64_t degenerate_faces = 0, duplicate_faces = 0, welded_vertices = 0;
};

/// Drops faces that say nothing about a surface and makes one vertex of equal ones: faces with a repeated corner, duplicates,
/// faces without area that no neighbour needs; where the mesh is not closed as it is indexed, positions that are equal, then
/// those closer than a file's rounding if the mesh closes by that. box: of the points.
Cleaned clean(Surface& surface, const Box& box);

/// Faces without area that have a neighbour at each side.
struct TightSlivers {
    std::uint64_t removed = 0, left = 0;
};

/// Joins the corner of such a face that lies on the opposite edge to the corner beyond, so that nothing opens and nothing
/// moves. diagonal: of the box of the points.
TightSlivers remove_tight_slivers(Surface& surface, double diagonal);

}  // namespace sqmap::mesh
