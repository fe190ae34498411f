// The validated triangle mesh that everything offline works on, and its neighbours across edges.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace sqmap::mesh {

/// Indices of its vertices.
using Triangle = std::array<std::uint32_t, 3>;

/// A validated triangle mesh. Admission (mesh/admit.h) makes it and promises:
/// indices in range, coordinates finite, no repeated index in a triangle, no unused vertex, counter-clockwise outward.
/// Canonical: vertices sorted by (x, y, z), each triangle rotated to start at its least vertex, triangles sorted, so
/// that the order of faces and vertices in a file has no influence on anything that follows.
struct Mesh {
    std::vector<Vec3d> vertices;      ///< #vertices, mesh units
    std::vector<Triangle> triangles;  ///< #triangles
};

/// Sorts vertices and triangles into the canonical order described at Mesh.
[[nodiscard]] Mesh canonicalized(const Mesh& mesh);

/// Model space: the mesh moved to its area centroid and divided by a rotation-invariant size, in double, so that units
/// do not matter. model = (mesh - origin) / unit.
struct Normalization {
    Vec3d origin;  ///< area-weighted centroid of the surface, mesh units
    double unit;   ///< area-weighted root mean square distance of the surface from origin, mesh units, > 0
};

/// The normalization of a mesh. Linear.
[[nodiscard]] Normalization normalization_of(const Mesh& mesh);
/// The mesh in the model space of n. Linear.
[[nodiscard]] Mesh normalized(const Mesh& mesh, const Normalization& n);

/// 64-bit hash (FNV-1a over words) of vertices and triangles, to distinguish meshes: never 0, and not against malice.
[[nodiscard]] std::uint64_t content_hash(const Mesh& mesh);

/// Area of a triangle, mesh units squared.
[[nodiscard]] double triangle_area(const Mesh& mesh, std::uint32_t triangle);
/// Mean of a triangle's corners, mesh units.
[[nodiscard]] Vec3d triangle_centroid(const Mesh& mesh, std::uint32_t triangle);

/// Rows: the principal axes of the surface, largest second moment about the area centroid first, turned so that the
/// third moment along the first two is positive and the frame is right-handed. Turns with the mesh, up to the mesh's own
/// symmetries.
[[nodiscard]] Mat3d principal_frame(const Mesh& mesh);

/// Largest distance between two vertices (R_max of eq. 35), exact; near linear by way of extreme points.
[[nodiscard]] double largest_vertex_distance(const Mesh& mesh);

/// Across a border edge there is none.
inline constexpr std::uint32_t k_no_triangle = std::numeric_limits<std::uint32_t>::max();

/// Dual graph (paper section 3.1, after Lin, Liao and Lin, "Visual salience-guided mesh decomposition").
struct DualGraph {
    /// #triangles; entry e is the triangle across the edge from corner e to corner e + 1, k_no_triangle on a border.
    /// At an edge of more than two triangles, triangles are paired in order of their index.
    std::vector<std::array<std::uint32_t, 3>> neighbours;
};

/// Cost: O(#triangles log #triangles).
[[nodiscard]] DualGraph dual_graph(const Mesh& mesh);

}  // namespace sqmap::mesh
