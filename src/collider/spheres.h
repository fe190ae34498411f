// Balls that together hold a solid, as sphere-based planners want it.
#pragma once

#include "sqmap/collider/shape.h"
#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::collider {

/// Balls whose union holds the whole solid, inside and all, chosen so that the one that reaches farthest out of the solid reaches
/// out little. Proof: a grid cuts the solid into pieces; the corners of a piece are those of the triangles clipped to its cell,
/// and the cell's own corners within the solid. Each piece is within one ball, since that holds all its corners. surface: closed,
/// counter-clockwise outward; crossed: as for mesh::Solid. held: triangles that the balls hold as well, wherever they are.
/// count: the most balls, 1 to 4096; fewer where the solid has fewer pieces, or where more balls would protrude more.
/// Deterministic. Thread-safe. Cost: some 4 s for 64 balls, 10 s where cells fill the box about the solid.
/// @throw mesh::InvalidInput for a surface without triangles or a count of 0
[[nodiscard]] std::vector<Shape> covering_spheres(const mesh::Mesh& surface, std::span<const std::uint8_t> crossed,
                                                  std::size_t count, std::span<const std::array<Vec3d, 3>> held = {});

}  // namespace sqmap::collider
