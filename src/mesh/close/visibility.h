// How much of a surface is seen from outside.
#pragma once

#include "../surface.h"

#include <vector>

namespace sqmap::mesh {

/// Shares of the rays from either side of a region that meet nothing.
struct Seen {
    double front = 0, back = 0;
};

/// For each region, at its least face; region: of every face, its least face. About 20,000 rays a side, at least eight a region,
/// always the same ones. Cost: rays times log n.
[[nodiscard]] std::vector<Seen> seen_from_outside(const Surface& surface, std::span<const std::uint32_t> region);

}  // namespace sqmap::mesh
