// The smoothed map.
#pragma once

#include "paper/bake/grid.h"

namespace sqmap::paper {

/// The base grid convolved with a kernel (section 6: force fields are smoothed by smoothing the map), and the normals of what
/// comes out, by eq. 26. Samples next to a jump, a cap or a miss, and the poles, stay as they are. Nothing is
/// added for the radius 0: force then has the map's own samples.
void add_smoothing(const Caster& caster, const Grid& finest, const MapOptions& options, Map& map);

}  // namespace sqmap::paper
