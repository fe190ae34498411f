// The connectivity of the surface between inside and outside corners: a vertex for each sheet of it in a cell.
#pragma once

#include "grid.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// Four sheets about an edge of the grid, one end of which is inside.
struct DualQuad {
    std::array<std::uint32_t, 4> vertices{};  ///< counter-clockwise seen from outside
    /// Vertex k is joined to the next one by a vertex between them, or by KeyTable::k_absent directly: two sheets that meet
    /// across two stretches of one side need two different edges.
    std::array<std::uint32_t, 4> between{};
    std::uint32_t inside = 0, outside = 0;  ///< corners: the ends of the edge
    std::uint32_t cell = 0;                 ///< one of the four
};

/// Closed and manifold whatever the labels are.
struct DualSurface {
    std::vector<std::uint32_t> vertex_cell;  ///< #vertices of sheets
    std::uint32_t between_count = 0;         ///< vertices that follow those of sheets
    std::vector<DualQuad> quads;
};

/// inside: #corners, not zero where inside. @pre all cells that the boundary passes through are in the grid.
[[nodiscard]] DualSurface dual_surface(const Grid& grid, std::span<const std::uint8_t> inside);

}  // namespace sqmap::mesh
