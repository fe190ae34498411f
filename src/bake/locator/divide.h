// Cells that are not flat, divided in eight.
#pragma once

#include "bake/locator/cells.h"
#include "bake/locator/draft.h"
#include "bake/locator/grid.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

inline constexpr double k_division_bytes = 60;  ///< what a division takes, about

/// The cells that may be divided.
struct DivisionLimit {
    std::size_t count;                          ///< so many: those with the longest chains first
    std::span<const std::uint64_t> among = {};  ///< #bricks: bits of cells that are considered; all, where it is empty
    unsigned threads = 0;                       ///< 0: one per core; the result does not depend on it
};

/// Divides cells of the bricks; returns how many. baker: of the same locator.
std::size_t divide(const CellBaker& baker, const Grid& grid, const DivisionLimit& limit, std::vector<BrickDraft>& bricks);

}  // namespace sqmap::bake
