// Cells that are not flat: seeds from which the nearest surface is found in a chart.
#pragma once

#include "bake/locator/samples.h"

#include <cstdint>
#include <vector>

namespace sqmap::bake {

/// A cell's seeds as stored.
struct SeedChain {
    std::vector<model::Seed> seeds;
    std::uint32_t choices = 0;  ///< of several: which one comes first in each octant
    double miss = 0;            ///< the greatest error of depth at inside samples, model units
};

/// Enough seeds that every sample of the cell finds its nearest surface from one of them: outside too, for the side is told by
/// the surface found.
[[nodiscard]] SeedChain seed_chain(const SurfaceCell& cell, const std::vector<Sample>& samples);

}  // namespace sqmap::bake
