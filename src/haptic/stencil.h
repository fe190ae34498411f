// Samples on a sphere for a point or a ball as tool, and the depth that they stand for.
#pragma once

#include "sqmap/haptic/zone.h"
#include "sqmap/math/vec.h"

#include <vector>

namespace sqmap::haptic {

/// Samples about the origin, m: smoothing.points (at least 8) on the sphere, and last the centre. Deterministic. Any thread.
/// @throw std::bad_alloc
[[nodiscard]] std::vector<Vec3d> stencil_points(const Smoothing& smoothing);

/// Mean of the squares of the depths of samples on a sphere of radius r, m, whose centre is t metres deep in flat ground;
/// samples outside count as depth zero. m^2. Any thread.
[[nodiscard]] double mean_square_depth(double r, double t) noexcept;

/// A depth and its derivative.
struct StencilDepth {
    double depth = 0, slope = 0;  ///< m, and d depth / d mean_square, 1/m; zero if nothing is inside
};
/// The inverse of mean_square_depth and its slope: the depth of the centre, at least -r. Any thread.
[[nodiscard]] StencilDepth depth_of_stencil(double r, double mean_square) noexcept;

}  // namespace sqmap::haptic
