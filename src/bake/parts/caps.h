// Closing the parts: caps that turn every part's patch of surface into a closed one, so that the parts tile the solid.
#pragma once

#include "sqmap/decompose/decompose.h"
#include "sqmap/mesh/mesh.h"

#include <array>
#include <vector>

namespace sqmap::bake {

using CapTriangle = std::array<Vec3d, 3>;

/// Caps of every part of a closed mesh. For two parts A and B the caps of A towards B are those of B towards A turned
/// round, so as chains: sum over parts of (patch + caps) = the whole surface, and every patch + caps is closed.
/// Hence winding(solid) = sum of winding(part + caps) at every point: a point of the solid has a non-zero winding number
/// in at least one part, and lies in that part's superquadric if it holds the patch and the caps (its outside is
/// connected and reaches infinity without crossing them). This is the certificate that the superquadrics cover the
/// solid; it holds for any partition, any number of components, and self-intersecting meshes.
///
/// How: the cut between A and B is an edge chain. Where it ends at junctions of three or more parts, it is closed along
/// a tree that joins the junctions of its network; the tree's share of all cuts around one part cancels. Each closed
/// chain is then coned to the mean of its vertices. Edges without a partner (open meshes) get no cap.
[[nodiscard]] std::vector<std::vector<CapTriangle>> cap_parts(const mesh::Mesh& mesh, const decompose::Partition& partition);

}  // namespace sqmap::bake
