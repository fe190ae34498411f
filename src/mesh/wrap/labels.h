// Which corners of a grid are inside.
#pragma once

#include "grid.h"
#include "winding.h"

#include "sqmap/mesh/bvh.h"

#include <cstdint>
#include <vector>

namespace sqmap::mesh {

/// The solid that a triangle bounds where the grid is too coarse for the winding number alone.
enum class Thin : std::uint8_t {
    No,
    Wall,   ///< a solid thinner than a cell, but not than a shell
    Sheet,  ///< no solid, or a thinner one: a shell is made about it
};

/// The input of a wrap, in units of the cells.
struct Source {
    const Mesh& soup;
    const Bvh& bvh;
    const WindingNumber& winding;
    double thickness;  ///< least thickness of a shell
};

struct Labels {
    std::vector<float> winding;        ///< #corners
    std::vector<std::uint8_t> inside;  ///< #corners: k_solid, k_shell or 0
    std::vector<Thin> thin;            ///< #triangles
};

inline constexpr std::uint8_t k_solid = 1;  ///< the winding number is above 1/2
inline constexpr std::uint8_t k_shell = 2;  ///< it is not, but a thin triangle is near

/// Labels all corners, and adds the cells without triangles that the solid's boundary passes through.
[[nodiscard]] Labels label_corners(Grid& grid, const Source& source);

}  // namespace sqmap::mesh
