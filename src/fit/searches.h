// The searches of a fit: eq. 3 on a part's samples, and small superquadrics that hold a part.
#pragma once

#include "chart.h"
#include "scaled_part.h"
#include "sqmap/shape/superquadric.h"

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace sqmap::fit {

/// The least squares of eq. 3 from some start, in the part's own coordinates.
struct DataFit {
    shape::Superquadricd sq;
    double cost = std::numeric_limits<double>::infinity();  ///< half the sum of squares of eq. 3, in the part's units
    bool converged = false;
    int iterations = 0;  ///< Levenberg-Marquardt steps of all starts together
};

/// A few steps from each start on a part of the samples, then the best `finalists` on all. N: k_plain, k_tapered or k_bent.
/// @pre starts is not empty
template <int N>
[[nodiscard]] DataFit fit_data(const ScaledPart& part, std::span<const shape::Superquadricd> starts, const FitOptions& options,
                               std::size_t finalists);

/// A frame whose z axis is the axis of that number; turned, not mirrored.
[[nodiscard]] Mat3d with_z_axis(const Mat3d& frame, int axis);

/// A little taper, so that its sign can be found: at 0 exactly it counts as absent and has no slope.
void seed_taper(std::vector<shape::Superquadricd>& starts);

/// Bent starts with their axis along the part's longest, and where thorough along its second too; none where the part is
/// straight.
[[nodiscard]] std::vector<shape::Superquadricd> bent_starts(const ScaledPart& part, const FitOptions& options, bool thorough);

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

/// Least bounding volume from one start, by `rounds` rounds of the augmented Lagrangian at most. N: k_plain, k_tapered or k_bent.
template <int N>
[[nodiscard]] Candidate least_volume(const ScaledPart& part, shape::Superquadricd start, const FitOptions& options, int rounds);

/// True if a semi-axis is more than max_overhang times (and a tenth) the part's half extent along it.
[[nodiscard]] bool overhangs(const shape::Superquadricd& sq, const ScaledPart& part, double max_overhang);

/// Lengths of sq times s.
void scale_by(shape::Superquadricd& sq, double s);

}  // namespace sqmap::fit
