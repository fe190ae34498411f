// Eq. 3 on a part's samples, and where its searches start.
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

}  // namespace sqmap::fit
