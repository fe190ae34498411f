#include "locator.h"

#include "bake/budget.h"
#include "bake/locator/cells.h"
#include "bake/locator/divide.h"
#include "bake/locator/draft.h"
#include "parallel/for_each.h"

#include <algorithm>
#include <cmath>
#include <optional>

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
        std::vector<BrickDraft> some = bricks_;
        for (BrickDraft& brick : some)
            if (brick.cells.empty()) brick = {BrickDraft::Kind::Free, {CellDraft{}}};
        pack(some, data_);
        return static_cast<double>(packed_bytes(data_)) * stored / std::max(sampled, 1.0);
    }

    /// All bricks, undivided, packed; returns its bytes.
    double run()
    {
        bake_bricks(1);
        pack(bricks_, data_);
        return static_cast<double>(packed_bytes(data_));
    }

    /// After run: divides so many cells in all, no fewer than before, if there are so many. Returns how many more were divided.
    std::size_t divide(std::size_t count)
    {
        const std::size_t more = bake::divide(cells_, grid_, {count - divided_, {}, threads_}, bricks_);
        divided_ += more;
        pack(bricks_, data_);
        return more;
    }

private:
    static model::ModelView view_with(const Grid& grid, model::ModelData& data)
    {
        store(grid, data.locator);
        data.locator.plane_reach = plane_reach(grid);
        return data.view();
    }

    /// One in so many of the bricks that are stored, and what all others are; those that are baked stay. Returns how many are
    /// stored in full.
    double bake_bricks(std::uint32_t one_in)
    {
        bricks_.resize(grid_.brick_count());
        parallel::for_each(bricks_.size(), threads_, [&](std::size_t i) {
            // A multiplicative hash (Knuth): neither rows nor columns are left out.
            const bool chosen = (static_cast<std::uint32_t>(i) * 2654435761u >> 16) % one_in == 0;
            if (bricks_[i].cells.empty()) bricks_[i] = cells_.bake_brick(grid_, i, chosen);
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
    std::size_t divided_ = 0;  ///< cells
};

bool has_charts(const model::ModelData& data)
{
    return data.parts.size() < model::k_no_part &&
           std::all_of(data.parts.begin(), data.parts.end(), [](const model::Part& part) { return part.base != 0; });
}

}  // namespace

struct GrowingLocator::State {
    PartedSolid surface;
    LocatorOptions options;
    model::ModelData& data;
    std::optional<LocatorBaker> baker;
    double cells;            ///< of the baker, along the longest side
    double undivided = 0;    ///< its bytes; 0: not run
    double first_cells = 0;  ///< with these the bytes of all are estimated
    double estimated = 0;

    void begin(double along)
    {
        if (baker && cells == along) return;
        baker.emplace(surface, options, cells = along, data);
        undivided = 0;
    }
};

GrowingLocator::GrowingLocator(const PartedSolid& surface, const LocatorOptions& options, model::ModelData& data)
    : state_(new State{surface, options, data, {}, 0})
{
    const double fine = std::sqrt(k_cells_target / options.target_error);
    state_->first_cells = std::clamp(k_cells_along * fine, k_least_cells, k_max_cells);
}

GrowingLocator::~GrowingLocator() = default;

bool GrowingLocator::bake(double more)
{
    State& s = *state_;
    if (!has_charts(s.data)) return false;
    const double all = byte_budget(s.surface.solid.mesh().triangles.size(), s.options.target_error);
    const auto maps = static_cast<double>(model::bytes_of<model::CentralArrays<model::ArrayData>>(s.data));
    const double budget = more * std::max(all - maps, k_least_share * all);
    double cells = s.first_cells;
    const auto fewer = [&](double bytes) {
        const double share = k_undivided_share * budget / bytes;
        cells = std::clamp(std::floor(cells * std::pow(share, 1 / k_growth)), k_least_cells, cells);
    };
    if (s.estimated == 0) {
        s.begin(cells);
        s.estimated = s.baker->estimated_bytes();
    }
    fewer(s.estimated);
    bool other = false;
    for (;;) {
        s.begin(cells);
        if (s.undivided == 0) {
            s.undivided = s.baker->run();
            other = true;
        }
        if (s.undivided <= budget || cells <= k_least_cells) {
            const auto count = static_cast<std::size_t>(std::max(0.0, budget - s.undivided) / k_division_bytes);
            return s.baker->divide(count) > 0 || other;
        }
        fewer(s.undivided);
    }
}

void bake_locator(const PartedSolid& surface, const LocatorOptions& options, model::ModelData& data)
{
    GrowingLocator(surface, options, data).bake();
}

}  // namespace sqmap::bake
