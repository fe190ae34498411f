// Joins boundaries that lie on each other up to a tolerance: cracks, and vertices on the edges of others.
#pragma once

#include "../surface.h"

namespace sqmap::mesh {

/// Joins vertices of the boundary nearer than tolerance, and splits edges of the boundary at vertices that near, in steps from a
/// thousandth of it; a step that does not make the boundary shorter is taken back. Returns how many edges of the boundary were
/// joined. Cost: n log n.
std::uint64_t stitch(Surface& surface, double tolerance);

}  // namespace sqmap::mesh
