#include "divide.h"

#include "parallel/for_each.h"

#include <algorithm>
#include <utility>

namespace sqmap::bake {

namespace {

constexpr std::size_t k_cells = model::k_brick_cells;

/// Flags of the cells that are to be divided, brick by brick.
std::vector<std::uint8_t> chosen_cells(const DivisionLimit& limit, const std::vector<BrickDraft>& bricks)
{
    std::vector<std::pair<std::size_t, std::size_t>> candidates;  // seeds, and which cell
    for (std::size_t i = 0; i < bricks.size(); ++i) {
        if (bricks[i].kind != BrickDraft::Kind::Stored) continue;
        for (std::size_t k = 0; k < k_cells; ++k) {
            const CellDraft& cell = bricks[i].cells[k];
            if (!cell.eighths.empty() || (!limit.among.empty() && (limit.among[i] >> k & 1u) == 0)) continue;
            if (!cell.seeds.empty()) candidates.emplace_back(cell.seeds.size(), i * k_cells + k);
        }
    }
    std::stable_sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    candidates.resize(std::min(limit.count, candidates.size()));
    std::vector<std::uint8_t> chosen(bricks.size() * k_cells, 0);
    for (const auto& [seeds, which] : candidates) chosen[which] = 1;
    return chosen;
}

}  // namespace

std::size_t divide(const CellBaker& baker, const Grid& grid, const DivisionLimit& limit, std::vector<BrickDraft>& bricks)
{
    const std::vector<std::uint8_t> chosen = chosen_cells(limit, bricks);
    parallel::for_each(bricks.size(), limit.threads, [&](std::size_t i) {
        if (bricks[i].kind != BrickDraft::Kind::Stored) return;
        for (std::size_t k = 0; k < k_cells; ++k) {
            CellDraft& cell = bricks[i].cells[k];
            if (chosen[i * k_cells + k] != 0) cell.eighths = baker.bake_eighths(grid.cell_cube(i, k), cell.near);
        }
    });
    return static_cast<std::size_t>(std::count(chosen.begin(), chosen.end(), 1));
}

}  // namespace sqmap::bake
