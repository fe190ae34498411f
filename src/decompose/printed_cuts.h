// Step 3 of section 3 as printed: both tests at each locale, from each salient feature on.
#pragma once

#include "cut.h"
#include "geodesic.h"

#include <span>

namespace sqmap::decompose {

/// The input of the printed cuts.
struct PrintedCuts {
    const CutSurface& surface;
    GeodesicSolver& geodesics;
    std::span<const double> curvature;        ///< #triangles
    std::span<const std::uint32_t> features;  ///< salient vertices, the most protruding first
    double least_area, width;                 ///< of a piece; of a locale
};

/// Cuts the partition wherever a locale passes one of the tests.
void cut_as_printed(const PrintedCuts& input, const DecomposeOptions& options, Partition& partition);

}  // namespace sqmap::decompose
