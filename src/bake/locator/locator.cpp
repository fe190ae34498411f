#include "locator.h"

#include "bake/budget.h"
#include "bake/locator/cells.h"
#include "bake/locator/divide.h"
#include "bake/locator/draft.h"
#include "parallel/for_each.h"

#include <algorithm>
#include <cmath>

namespace sqmap::bake {

namespace {

// Cells along the longest side of the object's box, for a target error of half a percent. A plane's error grows with the square
// of the cell.
constexpr double k_cells_along = 40;
constexpr double k_cells_target = 0.5;
constexpr double k_least_cells = 20, k_max_cells = 160;
// The maps come first: the locator makes do with larger cells where little of the budget is left, but for this share of it.
constexpr double k_least_share = 0.12;
// Bytes grow with about this power of the cells along a side: by the square but for parts of it that fine cells make flat.
constexpr double k_growth = 1.7;
// One in so many of the bricks near the surface is baked to estimate the bytes of all.
constexpr std::uint32_t k_sampled_brick = 6;
// The share of the locator's bytes for cells, before cells that are not flat are divided.
constexpr double k_undivided_share = 0.65;

/// Nothing is deeper than half the narrowest side; a plane is no farther below a cell's centre than a sample, and a cell.
float plane_reach(const Grid& grid)
{
    const auto narrowest = static_cast<int>(std::min({grid.bricks[0], grid.bricks[1], grid.bricks[2]}));
    return 0.5f * static_cast<float>(model::k_brick * narrowest) + 3;
}

/// A locator with cells of one size.
class LocatorBaker {
public:
    /// Sets data's grid. cells: along the longest side.
    LocatorBaker(const PartedSolid& surface, const LocatorOptions& options, double cells, model::ModelData& data)
        : data_(data),
          threads_(options.threads),
          grid_(grid_about(surface.solid.mesh(), cells)),
          subject_{surface.solid, surface.part_of_triangle, view_with(grid_, data),
                   flat_tolerance(options.target_error, data.header.r_max)},
          cells_(subject_, /*keeps_near=*/false)
    {
    }

    /// Bytes that all of it would take, told from a share of its bricks.
    double estimated_bytes()
    {
        const double sampled = bake_bricks(k_sampled_brick);
        const auto stored = static_cast<double>(std::count_if(
            bricks_.begin(), bricks_.end(), [](const BrickDraft& brick) { return brick.kind == BrickDraft::Kind::Stored; }));
        for (BrickDraft& brick : bricks_)
            if (brick.cells.empty()) brick = {BrickDraft::Kind::Free, {CellDraft{}}};
        pack(bricks_, data_);
        return static_cast<double>(packed_bytes(data_)) * stored / std::max(sampled, 1.0);
    }

    /// All bricks, undivided, packed; returns its bytes.
    double run()
    {
        bake_bricks(1);
        pack(bricks_, data_);
        return static_cast<double>(packed_bytes(data_));
    }

    /// After run: divides so many cells.
    void divide(std::size_t count)
    {
        bake::divide(cells_, grid_, {count, {}, threads_}, bricks_);
        pack(bricks_, data_);
    }

private:
    static model::ModelView view_with(const Grid& grid, model::ModelData& data)
    {
        store(grid, data.locator);
        data.locator.plane_reach = plane_reach(grid);
        return data.view();
    }

    /// One in so many of the bricks that are stored, and what all others are. Returns how many are stored in full.
    double bake_bricks(std::uint32_t one_in)
    {
        bricks_.assign(grid_.brick_count(), {});
        parallel::for_each(bricks_.size(), threads_, [&](std::size_t i) {
            // A multiplicative hash (Knuth): neither rows nor columns are left out.
            const bool chosen = (static_cast<std::uint32_t>(i) * 2654435761u >> 16) % one_in == 0;
            bricks_[i] = cells_.bake_brick(grid_, i, chosen);
        });
        return static_cast<double>(std::count_if(bricks_.begin(), bricks_.end(), [](const BrickDraft& brick) {
            return brick.kind == BrickDraft::Kind::Stored && !brick.cells.empty();
        }));
    }

    model::ModelData& data_;
    unsigned threads_;
    Grid grid_;
    LocatorSubject subject_;
    CellBaker cells_;
    std::vector<BrickDraft> bricks_;
};

}  // namespace

void bake_locator(const PartedSolid& surface, const LocatorOptions& options, model::ModelData& data)
{
    if (data.parts.size() >= model::k_no_part) return;
    for (const model::Part& part : data.parts)
        if (part.base == 0) return;
    const double all = byte_budget(surface.solid.mesh().triangles.size(), options.target_error);
    const auto maps = static_cast<double>(model::bytes_of<model::CentralArrays<model::ArrayData>>(data));
    const double budget = options.more * std::max(all - maps, k_least_share * all);
    const double undivided = k_undivided_share * budget;
    double cells = std::clamp(k_cells_along * std::sqrt(k_cells_target / options.target_error), k_least_cells, k_max_cells);
    const auto fewer = [&](double bytes) {
        cells = std::clamp(std::floor(cells * std::pow(undivided / bytes, 1 / k_growth)), k_least_cells, cells);
    };
    fewer(LocatorBaker(surface, options, cells, data).estimated_bytes());
    for (;;) {
        LocatorBaker baker(surface, options, cells, data);
        const double bytes = baker.run();
        if (bytes <= budget || cells <= k_least_cells) {
            baker.divide(static_cast<std::size_t>(std::max(0.0, budget - bytes) / k_division_bytes));
            return;
        }
        fewer(bytes);
    }
}

}  // namespace sqmap::bake
