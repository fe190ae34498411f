// A part's chart: its centre and the domain in which it answers, in the superquadric's frame divided by its axes.
#pragma once

#include "model/chart.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/shape/superquadric.h"

#include <cstdint>
#include <span>

namespace sqmap::bake {

/// The domain of a chart: bounds of model::domain_coordinates in the superquadric's frame divided by its axes, relative to the
/// projection centre.
struct ChartDomain {
    float lo[model::k_domain_directions], hi[model::k_domain_directions];
};

/// The part whose map is baked.
struct PartChart {
    shape::Superquadricd superquadric;
    Vec3f centre;                                  ///< of the projection, model space
    ChartDomain domain;                            ///< where the chart must answer: all of the solid that is the part's
    std::span<const std::uint32_t> own_triangles;  ///< the part's
};

/// Projection centre of a part: inside the solid, with large clearance from the part's own surface in the chart's
/// metric (a centre close to the surface would spread a few triangles over half the chart). Candidates are points of a
/// lattice in the superquadric's box and the depth centres below the part's triangles.
[[nodiscard]] Vec3f choose_centre(const mesh::Solid& solid, const shape::Superquadricd& superquadric,
                                  std::span<const std::uint32_t> own_triangles);

/// The smallest domain that holds the points and the centre, and a hair more.
[[nodiscard]] ChartDomain chart_domain(const shape::Superquadricd& superquadric, Vec3f centre, std::span<const Vec3d> points);

}  // namespace sqmap::bake
