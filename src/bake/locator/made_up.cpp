#include "made_up.h"

#include "grid.h"
#include "model/flags.h"
#include "model/locator_cells.h"
#include "sqmap/mesh/bvh.h"

#include <algorithm>
#include <cmath>

namespace sqmap::bake {
namespace {

class CellMarker {
public:
    CellMarker(const mesh::Mesh& all, const mesh::Mesh& made_up, model::ModelData& data)
        : all_(all), made_up_(made_up), data_(data)
    {
        data.made_up_cells.assign((data.locator_cells.size() + 31) / 32, 0);
    }

    void mark(std::size_t index, const CellCube& cube)
    {
        const model::LocatorCell cell{data_.locator_cells[index]};
        if (cell.is_divided()) {
            for (std::size_t e = 0; e < 8; ++e) mark(cell.first() + e, cube.eighth(e));
            return;
        }
        if (cell.is_free()) return;
        // A point within r of the centre is nearest to nothing beyond the centre's own distance and 2 r.
        const double radius = 1.001 * std::sqrt(3.0) * cube.half();
        const double reach = all_.closest_point(cube.centre).distance + 2 * radius;
        if (made_up_.closest_point(cube.centre, reach).distance < reach) data_.made_up_cells[index / 32] |= 1u << (index % 32);
    }

private:
    mesh::Bvh all_, made_up_;
    model::ModelData& data_;
};

}  // namespace

void mark_made_up(const mesh::Mesh& mesh, std::span<const std::uint8_t> made_up, model::ModelData& data)
{
    mesh::Mesh part{mesh.vertices, {}};
    for (std::size_t t = 0; t < made_up.size(); ++t) {
        if (made_up[t] == 0) continue;
        part.triangles.push_back(mesh.triangles[t]);
        if (!data.triangle_part.empty()) data.triangle_part[t] |= model::k_made_up;
    }
    data.made_up_cells.clear();
    if (part.triangles.empty() || data.bricks.empty()) return;
    CellMarker marker(mesh, part, data);
    const Grid grid = grid_of(data.locator);
    for (std::size_t b = 0; b < data.bricks.size(); ++b) {
        const model::LocatorBrick brick{data.bricks[b]};
        if (brick.is_free()) continue;
        if (brick.is_deep())
            marker.mark(brick.first(), grid.brick_cube(b));
        else
            for (std::uint32_t k = 0; k < model::k_brick_cells; ++k) marker.mark(brick.first() + k, grid.cell_cube(b, k));
    }
}

}  // namespace sqmap::bake
