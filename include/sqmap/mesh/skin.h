// A mesh that joints deform, and the rigid solids that stand in for it.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// Which joints move which vertex; weights sum to 1.
struct Influences {
    std::vector<std::array<std::uint16_t, 4>> joints;  ///< #vertices
    std::vector<std::array<double, 4>> weights;        ///< #vertices
};

/// Linear blend skinning: vertex v to the sum of weights times what its joints' maps make of it. maps: #joints, bound mesh ->
/// posed.
[[nodiscard]] std::vector<Vec3d> skinned(std::span<const Vec3d> vertices, const Influences& influences,
                                         std::span<const Affine> maps);

/// The solid that rides a joint: the triangles with a corner that the joint moves by at least least_weight, closed by caps across
/// the holes that cutting them out leaves. It overlaps the solids of the joints beside it where weights do. In the bound mesh's
/// frame, canonical; nothing if the joint moves nothing, or its part does not close.
/// mesh: closed, indexed as influences.
[[nodiscard]] std::optional<Mesh> joint_solid(const Mesh& mesh, const Influences& influences, std::uint16_t joint,
                                              double least_weight);

}  // namespace sqmap::mesh
