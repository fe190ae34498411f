// Flat cells: a few planes that are the surface.
#pragma once

#include "bake/locator/samples.h"

#include <optional>
#include <vector>

namespace sqmap::bake {

/// Planes that miss the surface by no more than the cell's tolerance, in groups, those of a group marked but for its first:
/// depth is the minimum over groups of the maximum over planes. A surface that bends away takes several groups, one that bends
/// towards the point several planes in a group. Nothing where k_max_planes do not suffice.
/// samples: those of the cell; what is checked beside them is appended.
[[nodiscard]] std::optional<std::vector<PartPlane>> flat_planes(const SurfaceCell& cell, CellSampler& sampler,
                                                                std::vector<Sample>& samples);

}  // namespace sqmap::bake
