// From a skinned mesh to the lattice that carries points back to the pose it was bound in.
#pragma once

#include "sqmap/mesh/skin.h"
#include "sqmap/query/skin.h"

namespace sqmap::bake {

struct SkinLatticeOptions {
    double cell = 1.0 / 64;  ///< share of the mesh's largest vertex distance
};

/// mesh: closed, bound, its own units; influences: of its vertices. Corners of cells take the weights of the nearest surface and
/// are then moved, bone by bone, so that the lattice carries the surface to where its vertices go, triangles being flat, in the
/// least squares: for every pose, since it is linear in the bones' maps.
/// @throw mesh::InvalidInput for a cell that is not in [1/512, 1/4], an empty mesh, or influences that are not of it
/// Cost: about half a second for 2,000 triangles and cells of 1/64.
[[nodiscard]] query::SkinLattice skin_lattice(const mesh::Mesh& mesh, const mesh::Influences& influences,
                                              const SkinLatticeOptions& options = {});

/// How far the lattice's surface is from the skinned mesh's in a pose at most, over its vertices, edges' and triangles' middles.
/// A verdict of query_skin is wrong at most that far from the surface, the bound model's own error aside, as far as these samples
/// tell. maps: #bones.
[[nodiscard]] double skin_deviation(const query::SkinLattice& lattice, const mesh::Mesh& mesh, const mesh::Influences& influences,
                                    std::span<const Affine> maps);

}  // namespace sqmap::bake
