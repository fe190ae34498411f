// The offset of eq. 12, against triangles that pass between samples.
#pragma once

#include "paper/bake/grid.h"

namespace sqmap::paper {

/// Of each sample of the base grid, every stride-th of the finest: delta of eq. 12, model units. At local minima alone, whose own
/// gradient is next to nothing (errata 8): the greatest within options.offset_radius counts.
[[nodiscard]] std::vector<double> offsets(const Caster& caster, const Grid& finest, int stride, const MapOptions& options);

}  // namespace sqmap::paper
