// The locator's grid: bricks of four by four by four cells.
#pragma once

#include "model/locator_cells.h"
#include "sqmap/math/vec.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/model/model.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sqmap::bake {

/// The cube of a cell or a brick, model space.
struct CellCube {
    Vec3d centre;
    double side = 0;

    [[nodiscard]] double half() const { return 0.5 * side; }
    /// e: 1 upper x, 2 upper y, 4 upper z.
    [[nodiscard]] CellCube eighth(std::size_t e) const
    {
        return {centre + 0.25 * side * Vec3d{e & 1 ? 1. : -1., e & 2 ? 1. : -1., e & 4 ? 1. : -1.}, 0.5 * side};
    }
};

/// Coordinates are representable as float: the runtime sees the very same grid.
struct Grid {
    Vec3d origin;
    double cell = 0;
    std::uint32_t bricks[3] = {};  ///< along x, y, z

    [[nodiscard]] std::size_t brick_count() const { return std::size_t{bricks[0]} * bricks[1] * bricks[2]; }
    [[nodiscard]] double brick_side() const { return model::k_brick * cell; }
    /// The cube of the brick of that number, x fastest.
    [[nodiscard]] Vec3d brick_corner(std::size_t brick) const
    {
        return origin + brick_side() * Vec3d{double(brick % bricks[0]), double(brick / bricks[0] % bricks[1]),
                                             double(brick / (std::size_t{bricks[0]} * bricks[1]))};
    }
    [[nodiscard]] CellCube brick_cube(std::size_t brick) const
    {
        return {brick_corner(brick) + 0.5 * brick_side() * Vec3d{1, 1, 1}, brick_side()};
    }
    /// The cube of the cell of that number in its brick, x fastest.
    [[nodiscard]] CellCube cell_cube(std::size_t brick, std::size_t number) const
    {
        constexpr int k_n = model::k_brick;
        const auto i = static_cast<int>(number);
        return {brick_corner(brick) + cell * Vec3d{i % k_n + 0.5, i / k_n % k_n + 0.5, i / (k_n * k_n) + 0.5}, cell};
    }
};

/// About a mesh, with so many cells along its longest side.
[[nodiscard]] Grid grid_about(const mesh::Mesh& mesh, double cells);

[[nodiscard]] Grid grid_of(const model::Locator& locator);
/// Sets the locator's origin, cell and bricks.
void store(const Grid& grid, model::Locator& locator);

/// A grid with bricks added where a mesh is beyond it.
struct EnclosingGrid {
    static constexpr std::uint32_t k_no_brick = 0xffffffffu;
    Grid grid;
    std::vector<std::uint32_t> brick_before;  ///< #bricks: which one of the given grid it is, or k_no_brick
};
[[nodiscard]] EnclosingGrid enclose(const Grid& grid, const mesh::Mesh& mesh);

}  // namespace sqmap::bake
