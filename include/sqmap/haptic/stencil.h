// A point, or a ball, that feels with samples on a sphere: the smoothing of the force field, with its kernel and radius.
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

/// Smoothing of the field about a point. A turn of the surface is spread over a way of 2 radius. Felt depth stays within
/// `tolerance` of the true one, and is it for tolerance 0; the direction is that of a surface rounded by about radius tan(turn /
/// 2) / 4.
struct Smoothing {
    Kernel kernel = Kernel::Ball;
    double radius = 0.0025;     ///< m; Averaging::Ball: the ball's own
    std::uint32_t points = 48;  ///< samples on the sphere
    double tolerance = 0.0002;  ///< m
};

/// What a ball that touches is made of: its samples are 0.8 mm apart on one of 5 mm.
[[nodiscard]] constexpr Smoothing ball_of(double radius) noexcept
{
    return {.radius = radius, .points = 500, .tolerance = 0.0003};
}

/// Samples about the origin: smoothing.points on the sphere, and last the centre. Allocates.
[[nodiscard]] std::vector<Vec3d> stencil_points(const Smoothing& smoothing);

/// What samples on a sphere of radius r feel on flat ground, as a function of the depth t of its centre: the mean of the
/// squares of their depths, where what is outside has depth zero.
[[nodiscard]] double mean_square_depth(double r, double t) noexcept;

/// Its inverse, and the slope of that: the depth of the centre that the samples stand for, at least -r.
struct StencilDepth {
    double depth = 0, slope = 0;  ///< m, and d depth / d mean_square, 1/m; zero where nothing is inside
};
[[nodiscard]] StencilDepth depth_of_stencil(double r, double mean_square) noexcept;

}  // namespace sqmap::haptic
