// Samples on a sphere for a point or a ball as tool: the smoothing of the force field, with its kernel and radius.
#pragma once

#include "sqmap/math/vec.h"

#include <cstdint>
#include <vector>

namespace sqmap::haptic {

/// How the direction of the force follows from the samples.
enum class Kernel : std::uint8_t {
    Ball,   ///< the mean of depth times normal over the ball, from the depths on its surface alone (divergence theorem): nothing
            ///< jumps
    Shell,  ///< the mean of depth times normal over the samples: for maps whose normals are better than their depths
};

/// Smoothing of the field about a point. A turn of the surface is spread over a path of 2 radius. The depth stays within
/// `tolerance` of the true one (equal for 0); the direction is that of a surface rounded by about radius tan(turn / 2) / 4.
struct Smoothing {
    Kernel kernel = Kernel::Ball;
    double radius = 0.0025;     ///< m; Averaging::Ball: the ball's own
    std::uint32_t points = 48;  ///< samples on the sphere
    double tolerance = 0.0002;  ///< m
};

/// Samples for a ball as tool, radius in metres; on a ball of 5 mm they are 0.8 mm apart.
[[nodiscard]] constexpr Smoothing ball_of(double radius) noexcept
{
    return {.radius = radius, .points = 500, .tolerance = 0.0003};
}

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
