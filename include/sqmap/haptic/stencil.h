// A point that feels with a small sphere about it: the smoothing of the force field, with its kernel and radius.
#pragma once

#include "sqmap/math/vec.h"

#include <cstdint>
#include <vector>

namespace sqmap::haptic {

enum class Kernel : std::uint8_t {
    Shell,  ///< the sphere's surface: across any edge a box filter, the smallest step for its width
    Ball,   ///< the whole ball: rounder, for the same step a third wider
};

/// Smoothing of the field about a point. A turn of the surface is spread over a way of 2 radius; what the point feels stays on
/// flat ground exactly what it was, and moves inwards on edges by about radius tan(turn / 2) / 4.
struct Smoothing {
    Kernel kernel = Kernel::Shell;
    double radius = 0.00075;    ///< m
    std::uint32_t points = 48;  ///< samples: steps are no smaller than one in so many
};

/// The samples about the origin, of equal weight: points of the probe of a zone with Averaging::Stencil. Allocates.
/// Fibonacci lattice: no plane holds many of them, so that they cross an edge one after the other.
[[nodiscard]] std::vector<Vec3d> stencil_points(const Smoothing& smoothing);

/// What the samples of a stencil feel on flat ground, as a function of the depth t of its centre: the mean of the squares of
/// their depths, where what is outside has depth zero.
[[nodiscard]] double mean_square_depth(const Smoothing& smoothing, double t) noexcept;

/// Its inverse, and the slope of that: the depth that the samples stand for. At least minus the radius.
struct StencilDepth {
    double depth = 0, slope = 0;  ///< m, and d depth / d mean_square, 1/m; zero where nothing is inside
};
[[nodiscard]] StencilDepth depth_of_stencil(const Smoothing& smoothing, double mean_square) noexcept;

}  // namespace sqmap::haptic
