// Points that stand for the surface of a tool, whatever its mesh: what Averaging::Patch sums over.
#pragma once

#include "sqmap/math/vec.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::haptic {

/// One weight a point: the area about it, in the square of the points' unit.
struct PatchPoints {
    std::vector<Vec3d> points;
    std::vector<float> weights;
};

/// The corners of a mesh's triangles, each divided in four, again and again, while its longest edge exceeds `spacing`: finer
/// meshes of one surface then come to the same points where their triangles are larger than that. spacing 0: the vertices as
/// they are; first in any case, in their order. At most `most` points: the spacing is widened by a fifth until that holds or
/// nothing is divided. Allocates. @pre triangles index vertices
[[nodiscard]] PatchPoints patch_points(std::span<const Vec3d> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                                       double spacing, std::size_t most = 100000);

}  // namespace sqmap::haptic
