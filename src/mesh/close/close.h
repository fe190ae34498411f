// The third rung of the ladder of admission: an open or tangled surface closed by as little new surface as possible.
#pragma once

#include "../surface.h"
#include "sqmap/mesh/admission.h"

#include <string>
#include <vector>

namespace sqmap::mesh {

struct CloseOptions {
    double diagonal = 1;       ///< of the box of the points
    double max_filled = 0.25;  ///< share of the closed surface's area
    bool refine = true;        ///< put points into fillings
};

struct Closing {
    Surface surface;  ///< faces that are made up have no polygon
    std::vector<RepairNote> notes;
    std::string failure;  ///< why it is not closed; empty where it is
};

/// Stitches cracks, resolves edges with more than two faces, fills all holes, and drops loose sheets that bound nothing. The
/// faces of the result agree; edges have two of them but for tangles that no cut resolves. Cost: see fill_holes, resolve_edges.
[[nodiscard]] Closing close(const Surface& surface, const CloseOptions& options);

}  // namespace sqmap::mesh
