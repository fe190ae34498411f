#include "paper/bake/cells.h"

#include "model/locator_cells.h"

#include <utility>

namespace sqmap::paper {

namespace {

using model::LocatorBrick;
using model::LocatorCell;
using model::LocatorCellKind;

/// A cell that is divided or whose planes were the surface is mixed to triangles.
LocatorCell bare(LocatorCell cell)
{
    if (cell.is_free()) return cell;
    return LocatorCell::seeded(cell.kind() == LocatorCellKind::Inside ? LocatorCellKind::Inside : LocatorCellKind::Mixed, 0, 0);
}

}  // namespace

void take_cells(model::ModelData& from, model::ModelData& to)
{
    to.locator = from.locator;
    to.bricks.clear();
    to.locator_cells.clear();
    for (const std::uint32_t word : from.bricks) {
        const LocatorBrick brick{word};
        const auto first = static_cast<std::uint32_t>(to.locator_cells.size());
        to.bricks.push_back(brick.is_free() ? word
                                            : (brick.is_deep() ? LocatorBrick::deep(first) : LocatorBrick::stored(first)).word);
        if (brick.is_free()) continue;
        for (std::uint32_t k = 0; k < brick.cell_count(); ++k)
            to.locator_cells.push_back(bare({from.locator_cells[brick.first() + k]}).word);
    }
    to.near_bricks = std::move(from.near_bricks);
    to.near = std::move(from.near);
}

}  // namespace sqmap::paper
