// The dual graph of a mesh: a dual vertex is a triangle, a dual edge links two triangles that share an edge.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace sqmap::mesh {

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
