// Updates the locator's cells whose nearest surface may have changed or whose parts have new maps.
#include "bake/locator/cells.h"
#include "bake/locator/divide.h"
#include "bake/locator/domains.h"
#include "bake/locator/draft.h"
#include "bake/locator/locator.h"
#include "parallel/for_each.h"

#include <algorithm>
#include <utility>

namespace sqmap::bake {

using model::LocatorCellKind;

namespace {

// The factor by which dividing cells may make a locator's bytes grow in an update.
constexpr double k_growth_limit = 1.1;

/// Updates drafts, one brick at a time. Const members are thread-safe.
class DraftUpdater {
public:
    DraftUpdater(const LocatorSubject& subject, const Grid& grid, const Change& change)
        : subject_(subject), grid_(grid), change_(change), cells_(subject, /*keeps_near=*/true)
    {
    }

    const CellBaker& cells() const { return cells_; }

    /// The cells of a brick that have another nearest surface than before, a bit each. fresh: the brick is new.
    std::uint64_t update(BrickDraft& brick, std::size_t number, bool fresh) const
    {
        const CellCube cube = grid_.brick_cube(number);
        const auto anew = [&] {
            brick = cells_.bake_brick(grid_, number, true);
            return ~std::uint64_t{0};
        };
        if (fresh) return anew();
        if (brick.kind == BrickDraft::Kind::Free) return reaches_free(brick.cells.front(), cube.centre) ? anew() : 0;
        const mesh::ClosestPoint nearest = subject_.solid.closest_boundary(cube.centre);
        const bool reached = change_.reaches_box(cube.centre, cube.half(), nearest.distance);
        if (brick.kind == BrickDraft::Kind::Deep) {
            if (reached) return anew();
            return update_parts(brick.cells.front(), cube) ? 1 : 0;
        }
        std::uint64_t bits = 0;
        Search search{nearest.point, {}};
        for (std::size_t k = 0; k < brick.cells.size(); ++k) {
            const CellCube cell = grid_.cell_cube(number, k);
            if (reached ? update_cell(brick.cells[k], cell, search) : update_parts(brick.cells[k], cell))
                bits |= std::uint64_t{1} << k;
        }
        return bits;
    }

private:
    /// A known surface point, which shortens the search for the nearest.
    struct Search {
        Vec3d known;                          ///< some point of the boundary; the nearest one, where that was looked for
        std::span<const std::uint32_t> near;  ///< of a cell that is divided: the triangles near it
    };

    bool reaches_free(const CellDraft& cell, Vec3d centre) const
    {
        return change_.reaches(centre, cell.gap + static_cast<double>(model::k_gap_step) * grid_.cell);
    }

    /// True where the nearest surface may have changed.
    bool update_cell(CellDraft& cell, const CellCube& cube, Search& search) const
    {
        if (cell.kind == LocatorCellKind::Free) {
            if (!reaches_free(cell, cube.centre)) return false;
            cell = cells_.bake(cube, subject_.solid.closest_boundary(cube.centre), search.near);
            return true;
        }
        if (!change_.reaches_box(cube.centre, cube.half(), norm(search.known - cube.centre))) return update_parts(cell, cube);
        const mesh::ClosestPoint nearest = closest_from(subject_.solid, search.known, cube.centre);
        search.known = nearest.point;
        if (!change_.reaches_box(cube.centre, cube.half(), nearest.distance)) return update_parts(cell, cube);
        if (cell.eighths.empty()) {
            cell = cells_.bake(cube, nearest, search.near);
            return true;
        }
        cell.near = triangles_near(subject_.solid, cube, nearest.distance);
        Search within{search.known, cell.near};
        for (std::size_t e = 0; e < 8; ++e) (void)update_cell(cell.eighths[e], cube.eighth(e), within);
        search.known = within.known;
        return true;
    }

    /// Updates the parts that a cell names. Returns true where its planes changed.
    bool update_parts(CellDraft& cell, const CellCube& cube) const
    {
        if (cell.kind == LocatorCellKind::Free) return false;
        if (!cell.eighths.empty()) {
            bool other = false;
            for (std::size_t e = 0; e < 8; ++e) other = update_parts(cell.eighths[e], cube.eighth(e)) || other;
            return other;
        }
        if (std::any_of(cell.seeds.begin(), cell.seeds.end(),
                        [&](const model::Seed& seed) { return change_.remade(model::seed_part(seed)); })) {
            cell = cells_.bake(cube);
            return true;
        }
        if (cell.kind == LocatorCellKind::Inside) return false;
        for (std::uint32_t i = 0; i < subject_.model.parts.size(); ++i) {
            if (!change_.remade(i) || test_domain(change_.before(i), cube) == test_domain(subject_.model.parts[i], cube))
                continue;
            cell.kind = LocatorCellKind::Mixed;
            cell.parts.fill(model::k_no_part);
            const std::uint32_t nearest = subject_.solid.closest_boundary(cube.centre).triangle;
            list_parts(subject_, cube, subject_.part_of_triangle[nearest], cell);
            break;
        }
        return false;
    }

    const LocatorSubject& subject_;
    const Grid& grid_;
    const Change& change_;
    CellBaker cells_;
};

/// Drafts in a grid that encloses theirs.
std::vector<BrickDraft> moved_into(const EnclosingGrid& enclosing, std::vector<BrickDraft> before)
{
    std::vector<BrickDraft> bricks(enclosing.brick_before.size());
    for (std::size_t i = 0; i < bricks.size(); ++i)
        if (const std::uint32_t was = enclosing.brick_before[i]; was != EnclosingGrid::k_no_brick)
            bricks[i] = std::move(before[was]);
    return bricks;
}

}  // namespace

LocatorUpdate update_locator(const PartedSolid& surface, const LocatorOptions& options, const Change& change,
                             model::ModelData& data)
{
    const std::size_t bytes = packed_bytes(data);
    std::vector<BrickDraft> before = unpack(data);
    EnclosingGrid enclosing = enclose(grid_of(data.locator), surface.solid.mesh());
    const Grid& grid = enclosing.grid;
    store(grid, data.locator);
    std::vector<BrickDraft> bricks = moved_into(enclosing, std::move(before));
    const LocatorSubject subject{surface.solid, surface.part_of_triangle, data.view(),
                                 flat_tolerance(options.target_error, data.header.r_max)};
    const DraftUpdater updater(subject, grid, change);
    LocatorUpdate update;
    update.reached.assign(bricks.size(), 0);
    parallel::for_each(bricks.size(), options.threads, [&](std::size_t i) {
        const bool fresh = enclosing.brick_before[i] == EnclosingGrid::k_no_brick;
        update.reached[i] = updater.update(bricks[i], i, fresh);
    });
    pack(bricks, data);
    const double left = k_growth_limit * static_cast<double>(bytes) - static_cast<double>(packed_bytes(data));
    const auto count = static_cast<std::size_t>(std::max(0.0, left) / k_division_bytes);
    (void)divide(updater.cells(), grid, {count, update.reached, options.threads}, bricks);
    pack(bricks, data);
    update.near.resize(bricks.size());
    for (std::size_t i = 0; i < bricks.size(); ++i)
        for (CellDraft& cell : bricks[i].cells)
            if (update.reached[i] != 0) update.near[i].push_back(std::move(cell.near));
    update.brick_before = std::move(enclosing.brick_before);
    return update;
}

}  // namespace sqmap::bake
