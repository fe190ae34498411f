// The plane about which a surface is its own mirror image.
#pragma once

#include "sqmap/decompose/decompose.h"
#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace sqmap::decompose {

/// A plane of reflection, and where it takes each triangle.
struct Mirror {
    Vec3d normal;                            ///< of length one
    double offset;                           ///< dot(normal, p) of the plane's points, mesh units
    std::vector<std::uint32_t> of_triangle;  ///< #triangles: that at the mirror image; k_no_triangle: the surface is not near it
};

/// The plane about which a surface is symmetric, if there is one: at least k_symmetric_share of its area, mirrored, lies within
/// k_symmetric_distance of the surface and faces as it does. It is sought near the planes through the centroid across the
/// principal axes. None of a mesh without area. Any units and frame; it turns with the mesh. Cost: that of some 5,000 closest
/// points, with a mirror n more.
[[nodiscard]] std::optional<Mirror> find_mirror(const mesh::Mesh& mesh);

/// The partition of one half of a mesh, and on the other half its mirror image. A part that reaches across the plane stays one.
/// It is the half whose borders are longer and more concave; the other, if that makes more than max_parts; nothing is changed, if
/// both do. mirror, partition: of the mesh. Cost: O(n). Thread-safe. @throw std::bad_alloc
[[nodiscard]] Partition symmetrised(const mesh::Mesh& mesh, const Mirror& mirror, Partition partition, std::uint32_t max_parts);

inline constexpr double k_symmetric_distance = 0.01;  ///< of R_max
inline constexpr double k_symmetric_share = 0.97;     ///< of the area

}  // namespace sqmap::decompose
