// How close shapes are to a thing: volume, support excess, coverage and protrusion.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/collider/pieces.h"
#include "sqmap/collider/shape.h"

#include <span>

namespace sqmap::collider {

/// Figures of shapes that stand together for a solid. Lengths in its units; a figure that needs a solid is -1 without one.
struct Figures {
    double volume = 0;         ///< of the shapes, summed: what two of them share counts twice
    double volume_ratio = -1;  ///< volume over the solid's
    /// max over directions u of h_shapes(u) - h_solid(u): exact for hulls, boxes, balls and capsules; of others at most 0.2 % of
    /// the solid's extent too small
    double support_excess = 0;
    double protrusion =
        -1;  ///< greatest distance from the solid of a point that some shape holds; at most 1 % of its extent too small
    double coverage = 1;  ///< share of the solid that the shapes hold: 1 by their certificate
};

/// points: of the solid, whose convex hull counts for the support. solid: distances to it, or null; closed.
/// Cost: some 50 ms for twenty shapes.
struct Measured {
    std::span<const Vec3d> points;
    double volume = 0;  ///< of the solid; 0: none
    const mesh::Mesh* solid = nullptr;
    std::span<const std::uint8_t> crossed{};
};
/// The figures of shapes that together enclose the solid. Cost: linear in the shapes and in the solid's triangles.
[[nodiscard]] Figures figures_of(std::span<const Shape> shapes, const Measured& solid);

}  // namespace sqmap::collider
