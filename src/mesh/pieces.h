// A triangle cut where others pass through it or lie on it.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// Triangles that together are the given one, none of which any of the others crosses or partly covers, up to tolerance (a
/// length). Nothing where there would be more than max_pieces. Cost: others times pieces.
[[nodiscard]] std::optional<std::vector<std::array<Vec3d, 3>>> pieces_of(const Mesh& mesh, std::uint32_t triangle,
                                                                         std::span<const std::uint32_t> others, double tolerance,
                                                                         std::size_t max_pieces = 4096);

}  // namespace sqmap::mesh
