// Edges with more than two faces, and faces that cannot agree, taken apart.
#pragma once

#include "../surface.h"

namespace sqmap::mesh {

/// Counts of resolve_edges.
struct Resolved {
    std::uint64_t turned_faces = 0;
    std::uint64_t wall_faces = 0;   ///< dropped: walls within the solid, seen from neither side
    std::uint64_t cut_edges = 0;    ///< sides of faces that found no partner: boundary now
    std::uint64_t fin_faces = 0;    ///< dropped: they hang on a surface that goes on without them
    std::uint64_t stuck_faces = 0;  ///< dropped: without a partner, and not to be cut off
};

/// Leaves faces that agree with their neighbours, two at most at an edge. It turns regions towards the side from which they are
/// seen, drops walls that are seen from neither side, and at an edge with more faces joins those with solid between them, then
/// those whose sides differ most in visibility; it cuts off the rest. Cost: n log n, and rays at edges with more than two faces.
Resolved resolve_edges(Surface& surface);

/// Turns faces to agree with their neighbours, and regions that are clearly seen from behind; nothing is cut or dropped. Returns
/// how many faces were turned.
std::uint64_t orient_outward(Surface& surface);

}  // namespace sqmap::mesh
