// Loose sheets: pieces of a surface that bound nothing.
#pragma once

#include "../surface.h"

namespace sqmap::mesh {

/// Counts of drop_sheets.
struct Sheets {
    std::uint64_t dropped_faces = 0;
    double outside_area = 0;  ///< of the dropped ones that lie neither in the rest's solid nor on it
    bool all = false;         ///< there is nothing but sheets: nothing was dropped
};

/// Drops the components that consist of a sheet and a filling over it. surface: every component closed, faces made up have no
/// polygon; tolerance: how near a doubled sheet lies to the surface.
Sheets drop_sheets(Surface& surface, double tolerance);

}  // namespace sqmap::mesh
