// The two arrays beside a central map's base samples: offsets against tunnelling, and terms that smooth the map.
#pragma once

#include "bake/central/central_map.h"
#include "bake/central/central_options.h"
#include "bake/central/project.h"

namespace sqmap::bake {

/// Eq. 12, corrected: where the distance map has a local minimum the surface may stick into a face of a probe whose corners are
/// all outside. The gradient vanishes at a smooth minimum, so the largest slope of the ring around it is taken:
/// delta = a_N d |grad D| = a_N |D(neighbour) - D|. Sets map's offsets. @pre its samples are there
void add_offsets(const Projection& projection, const CentralOptions& options, CentralMapData& map);

/// The map convolved with a binomial kernel on each face, less the map. Rays without surface take no part. Sets map's smoothing.
/// radius: of the kernel, in base samples. @pre map's samples are there
void add_smoothing(int radius, CentralMapData& map);

}  // namespace sqmap::bake
