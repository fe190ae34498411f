// Small superquadrics that hold a part: the closed form of its boxes, and least volume by search.
#pragma once

#include "scaled_part.h"
#include "sqmap/shape/superquadric.h"

#include <limits>
#include <span>

namespace sqmap::fit {

/// A superquadric that holds a part's points, in the part's own coordinates.
struct Candidate {
    shape::Superquadricd sq;
    double volume = std::numeric_limits<double>::infinity();  ///< infinity: none was found
    bool converged = false;
    int iterations = 0;  ///< Levenberg-Marquardt steps that the search took
};

/// Best exponents for the box about the part's extreme points along a frame, in closed form.
[[nodiscard]] Candidate closed_form(const ScaledPart& part, const Mat3d& frame, const FitOptions& options);

/// Scales sq about its centre until it just holds the points. False where it cannot be made to.
[[nodiscard]] bool shrink_wrap(shape::Superquadricd& sq, std::span<const Vec3d> points);

/// Least bounding volume from one start, by so many rounds of the augmented Lagrangian at most. N: k_plain, k_tapered or k_bent.
template <int N>
[[nodiscard]] Candidate least_volume(const ScaledPart& part, shape::Superquadricd start, const FitOptions& options, int rounds);

/// True if a semi-axis is more than max_overhang times (and a tenth) the part's half extent along it.
[[nodiscard]] bool overhangs(const shape::Superquadricd& sq, const ScaledPart& part, double max_overhang);

/// Lengths of sq times s.
void scale_by(shape::Superquadricd& sq, double s);

}  // namespace sqmap::fit
