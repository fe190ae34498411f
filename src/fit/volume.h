// Volume of a superquadric and its slopes. Jaklic, Leonardis and Solina, Segmentation and Recovery of Superquadrics
// (2000), chapter 2.
#pragma once

#include "gradient.h"

namespace sqmap::fit {

/// log of the Gamma function and its derivative, x > 0; absolute error below 1e-13. Own code, as std::lgamma has no
/// derivative, writes a global and differs between C libraries.
[[nodiscard]] double log_gamma(double x);
[[nodiscard]] double digamma(double x);

[[nodiscard]] double log_volume(const shape::Superquadricd& sq);
/// Derivatives of log_volume.
[[nodiscard]] Gradient log_volume_gradient(const shape::Superquadricd& sq);

}  // namespace sqmap::fit
