// What else a projection asks of a normal map.
#pragma once

#include "sqmap/query/normal_projection.h"

namespace sqmap::query {

/// Step 4 of section 4.2: Layer 3 is worth its time while the base grid has fewer samples than k_L times the vertices.
[[nodiscard]] bool reads_base_grid(const NormalMapView& map, const ProjectionOptions& options);

/// Openings of the nearest sample's ray. Sets distance to where the solid is entered again if the point at foot distance s lies
/// in one or behind one; false where none matters.
[[nodiscard]] bool behind_first_surface(const NormalMapView& map, shape::SurfaceAnglesf angles, float s, float& distance);

}  // namespace sqmap::query
