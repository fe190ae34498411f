// Admission, which every mesh passes: polygons as they come in, a validated mesh or a reasoned refusal out.
// Pure functions: any number of threads.
#pragma once

#include "sqmap/mesh/admission.h"

namespace sqmap::mesh {

/// Judges, repairs and normalises polygons into a Mesh. When several codes apply, the first of this order is given:
/// Index, NonFinite, Empty, Range, Limit (components, corners of a polygon), then repairs, then NonManifold, Orient, Flat, Open.
/// Repair::None refuses with the one of the last that names what would have been repaired, Repair where none does. Polygons are
/// split into triangles; equal positions are made one vertex unless the mesh is closed as it is indexed; faces are oriented alike
/// by propagation, shells outward by volume; vertices where shells touch are split. Shells that intersect are accepted: the solid
/// is where the winding number is positive. Never throws but std::bad_alloc. Cost: n log n in the number of corners, plus the
/// intersecting pairs.
[[nodiscard]] AdmitResult admit(const PolygonView& polygons, const AdmitOptions& options = {});

}  // namespace sqmap::mesh
