#include "grid.h"

#include "sqmap/math/box.h"

#include <algorithm>
#include <cmath>

namespace sqmap::bake {

namespace {

constexpr double k_margin = 0.01;  ///< about the mesh, in cells

double as_float(double v) { return static_cast<double>(static_cast<float>(v)); }

}  // namespace

Grid grid_about(const mesh::Mesh& mesh, double cells)
{
    const auto [lo, hi] = box_of(mesh.vertices);
    Grid grid;
    grid.cell = as_float(std::max({hi.x - lo.x, hi.y - lo.y, hi.z - lo.z}) / cells);
    for (int k = 0; k < 3; ++k) {
        const double margin = k_margin * grid.cell;
        const int bricks = std::max(static_cast<int>(std::ceil((hi[k] - lo[k] + 2 * margin) / (model::k_brick * grid.cell))), 1);
        grid.bricks[k] = static_cast<std::uint32_t>(bricks);
        grid.origin[k] = as_float(0.5 * (lo[k] + hi[k]) - 0.5 * grid.cell * (model::k_brick * bricks));
    }
    return grid;
}

Grid grid_of(const model::Locator& locator)
{
    Grid grid;
    grid.cell = static_cast<double>(locator.cell);
    for (int k = 0; k < 3; ++k) {
        grid.origin[k] = static_cast<double>(locator.origin[k]);
        grid.bricks[k] = locator.bricks[k];
    }
    return grid;
}

void store(const Grid& grid, model::Locator& locator)
{
    locator.cell = static_cast<float>(grid.cell);
    for (int k = 0; k < 3; ++k) {
        locator.origin[k] = static_cast<float>(grid.origin[k]);
        locator.bricks[k] = grid.bricks[k];
    }
}

EnclosingGrid enclose(const Grid& grid, const mesh::Mesh& mesh)
{
    const auto [lo, hi] = box_of(mesh.vertices);
    const double side = grid.brick_side(), margin = k_margin * grid.cell;
    EnclosingGrid out{grid, {}};
    std::uint32_t below[3] = {};
    for (int k = 0; k < 3; ++k) {
        const auto missing = [&](double by) { return static_cast<std::uint32_t>(std::ceil(std::max(by, 0.0) / side)); };
        const double length = grid.cell * (model::k_brick * static_cast<int>(grid.bricks[k]));
        below[k] = missing(grid.origin[k] + margin - lo[k]);
        out.grid.bricks[k] = grid.bricks[k] + below[k] + missing(hi[k] + margin - grid.origin[k] - length);
        out.grid.origin[k] = as_float(grid.origin[k] - side * below[k]);
    }
    out.brick_before.assign(out.grid.brick_count(), EnclosingGrid::k_no_brick);
    const auto *before = grid.bricks, *now = out.grid.bricks;
    for (std::uint32_t z = 0; z < before[2]; ++z)
        for (std::uint32_t y = 0; y < before[1]; ++y)
            for (std::uint32_t x = 0; x < before[0]; ++x) {
                const std::size_t from = (std::size_t{z} * before[1] + y) * before[0] + x;
                const std::size_t to = (std::size_t{z + below[2]} * now[1] + y + below[1]) * now[0] + x + below[0];
                out.brick_before[to] = static_cast<std::uint32_t>(from);
            }
    return out;
}

}  // namespace sqmap::bake
