// Where a part's chart stands and answers: its centre and its domain, in the superquadric's frame divided by its axes.
#pragma once

#include "sqmap/mesh/solid.h"
#include "sqmap/shape/superquadric.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace sqmap::bake {

/// What the parts of a model share.
struct SurfaceContext {
    const mesh::Mesh& mesh;  ///< model space, every coordinate representable as float
    const mesh::Bvh& bvh;
    std::span<const std::uint16_t> flags;  ///< #triangles: model::SurfaceFlag bits
    double r_max;
};

/// Where a chart answers: bounds of model::domain_coordinates in the superquadric's frame divided by its axes, relative to the
/// projection centre.
struct ChartDomain {
    float lo[9], hi[9];
};

/// Projection centre of a part: inside the solid, with large clearance from the part's own surface in the chart's
/// metric (a centre close to the surface would spread a few triangles over half the chart). Candidates are points of a
/// lattice in the superquadric's box and the depth centres below the part's triangles.
[[nodiscard]] Vec3f choose_centre(const mesh::Solid& solid, const shape::Superquadricd& superquadric,
                                  std::span<const std::uint32_t> own_triangles);

/// The smallest domain that holds the points and the centre, and a hair more.
[[nodiscard]] ChartDomain chart_domain(const shape::Superquadricd& superquadric, Vec3f centre, std::span<const Vec3d> points);

}  // namespace sqmap::bake
