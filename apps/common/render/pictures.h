// The pictures of `sqmap render`, one function a kind.
#pragma once

#include "common/render/raycast.h"
#include "common/render/subject.h"

#include <string>

namespace sqmap::app {

/// The triangles alone.
[[nodiscard]] Image plain_picture(const Subject& subject, const View& view);
/// A colour a part, with lines between parts.
[[nodiscard]] Image parts_picture(const Subject& subject, const View& view);
/// The same, paler, under its translucent superquadrics.
[[nodiscard]] Image superquadrics_picture(const Subject& subject, const View& view);
/// The same with what layer 1 holds: superquadrics cut by the polytopes of their parts.
[[nodiscard]] Image bounds_picture(const Subject& subject, const View& view);
/// A picture of a field of section 3: protrusion (p of eq. 4 over its mean), features (the same with the salient features),
/// locales (bands about the nearest of them), strength (Boundary Strength of these), curvature (of eq. 6, times R_max squared,
/// capped at the 95th percentile) or hyperbolic (where it is negative). @pre kind is one of these, the subject's section_three is
/// there
[[nodiscard]] Image section_three_picture(const Subject& subject, const std::string& kind, const View& view);
/// Convex surface, Q1 and Q2 of section 5. @pre the subject has regions
[[nodiscard]] Image regions_picture(const Subject& subject, const View& view);
/// Error of Layer 3 just below the surface: of the depth at points 1 % of R_max inside, or along the projection (eq. 35)
/// where the model is a surface without inside. @pre the subject has a model
[[nodiscard]] Image error_picture(const Subject& subject, const View& view);
/// Every part's map unrolled (Fig. 4c). @pre the subject has a model
[[nodiscard]] Image map_picture(const Subject& subject, int width, int height);

}  // namespace sqmap::app
