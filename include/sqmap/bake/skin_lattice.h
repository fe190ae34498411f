// From a skinned mesh to the lattice that carries points back to the pose it was bound in.
#pragma once

#include "sqmap/mesh/skin.h"
#include "sqmap/query/skin.h"

namespace sqmap::bake {

/// How fine a lattice is.
struct SkinLatticeOptions {
    double cell = 1.0 / 64;  ///< share of the mesh's largest vertex distance
};

/// mesh: closed, bound, its own units; influences: of its vertices. Corners of cells take the weights of the nearest surface and
/// are then moved, bone by bone, so that the lattice carries the surface to where its vertices go, triangles being flat, in the
/// least squares: for every pose, since it is linear in the bones' maps.
/// @throw mesh::InvalidInput for a cell that is not in [1/512, 1/4], an empty mesh, or influences that are not of it
/// Cost: about half a second for 2,000 triangles and cells of 1/64. Thread-safe.
[[nodiscard]] query::SkinLattice skin_lattice(const mesh::Mesh& mesh, const mesh::Influences& influences,
                                              const SkinLatticeOptions& options = {});

/// Largest distance between the lattice's surface and the skinned mesh's in a pose, over its vertices and the middles of edges
/// and triangles, the mesh's units. A verdict of query_skin is wrong at most that far from the surface, the bound model's own
/// error aside, as far as these samples show. maps: #bones, from the bound pose to the pose.
/// @throw mesh::InvalidInput where maps are not of this lattice
[[nodiscard]] double skin_deviation(const query::SkinLattice& lattice, const mesh::Mesh& mesh, const mesh::Influences& influences,
                                    std::span<const Affine> maps);

}  // namespace sqmap::bake
