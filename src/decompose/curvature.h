// Gaussian curvature of a triangle mesh (section 3.2).
#pragma once

#include "sqmap/mesh/mesh.h"

#include <vector>

namespace sqmap::decompose {

/// Gaussian curvature at every triangle, 1 / mesh units squared: signed area of the spherical image of the geodesic
/// window of radius window * sqrt(area), over the window's area. area is that of the triangle, but not less than
/// least_area. Sign: negative where the surface is hyperbolic.
[[nodiscard]] std::vector<double> gaussian_curvature(const mesh::Mesh& mesh, const mesh::DualGraph& graph, double window,
                                                     double least_area);

}  // namespace sqmap::decompose
