// Foot points on a superquadric: a search on the map's grid, or Newton's method from a table of starts.
#pragma once

#include "sqmap/query/normal_projection.h"

namespace sqmap::query {

/// A query point as both projectors need it.
struct FootQuery {
    Vec3f local;                        ///< in the superquadric's frame
    Vec3f unit;                         ///< undeformed, divided by the semi-axes
    float gauge;                        ///< F^(1/2)
    shape::SurfacePosition<float> own;  ///< where its own ray leaves the surface
};

/// False where the point is outside the superquadric or not a number; most points are so before any power is raised.
[[nodiscard]] bool enters(const NormalMapView& map, Vec3f p, FootQuery& query);

/// Layer 2: the sample of the base grid itself. Layer 3 (subdivide): the search goes on through the subdivided levels, and one
/// Newton step leads from the finest sample to the position between samples that linear interpolation is for.
[[nodiscard]] shape::Foot<float> pyramid_foot(const NormalMapView& map, Vec3f p, const FootQuery& query, bool subdivide,
                                              std::uint8_t& flags);
[[nodiscard]] shape::Foot<float> newton_foot(const NormalMapView& map, Vec3f p, const FootQuery& query, std::uint8_t& flags);

}  // namespace sqmap::query
