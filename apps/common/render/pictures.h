// The pictures of `sqmap render`, one function a kind.
#pragma once

#include "common/render/raycast.h"
#include "common/render/subject.h"

namespace sqmap::app {

/// The triangles alone.
[[nodiscard]] Image plain_picture(const Subject& subject, const View& view);
/// A colour a part, with lines between parts.
[[nodiscard]] Image parts_picture(const Subject& subject, const View& view);
/// The same, paler, under its translucent superquadrics.
[[nodiscard]] Image superquadrics_picture(const Subject& subject, const View& view);
/// p of eq. 4 over its mean.
[[nodiscard]] Image protrusion_picture(const Subject& subject, const View& view);
/// Gaussian curvature of eq. 6 times R_max squared, capped at the 95th percentile.
[[nodiscard]] Image curvature_picture(const Subject& subject, const View& view);
/// Error of Layer 3 just below the surface: of the depth at points 1 % of R_max inside, or along the projection (eq. 35)
/// where the model is a surface without inside. @pre the subject has a model
[[nodiscard]] Image error_picture(const Subject& subject, const View& view);
/// Every part's map unrolled (Fig. 4c). @pre the subject has a model
[[nodiscard]] Image map_picture(const Subject& subject, int width, int height);

}  // namespace sqmap::app
