// Protrusion, salient features and locales (section 3.1).
#pragma once

#include "geodesic.h"
#include "sqmap/decompose/decompose.h"
#include "sqmap/mesh/mesh.h"

#include <span>
#include <vector>

namespace sqmap::decompose {

/// Degree of protrusion of eq. 4 at every vertex, over its mean in the vertex's component (0 for a lone triangle).
[[nodiscard]] std::vector<double> protrusion_at_vertices(const mesh::Mesh& mesh, GeodesicSolver& geodesics,
                                                         const DecomposeOptions& options);

/// When a local maximum of the protrusion is salient.
struct SalientLimits {
    double window;      ///< radius of the geodesic window in which it is greatest (eq. 5), mesh units
    double prominence;  ///< least rise from the pass to a higher peak
};

/// Vertices that are salient, the most protruding first.
[[nodiscard]] std::vector<std::uint32_t> salient_vertices(const mesh::Mesh& mesh, GeodesicSolver& geodesics,
                                                          const std::vector<double>& protrusion, const SalientLimits& limits);

/// Locales of a part from a salient feature: bands of equal geodesic width.
struct Locales {
    double width = 0;                          ///< geodesic width of a band
    std::vector<double> area;                  ///< area of each band
    std::vector<double> hyperbolic_area;       ///< of its points with negative curvature
    std::vector<double> hyperbolic_curvature;  ///< their mean curvature (area-weighted), <= 0
    std::vector<double> elliptic_curvature;    ///< integral of the positive curvature

    /// Radius of the circle that a band would be around: area / (2 pi width).
    [[nodiscard]] double radius(std::size_t k) const;
    /// Mean radius of the bands that start in [first, last).
    [[nodiscard]] double mean_radius(std::ptrdiff_t first, std::ptrdiff_t last) const;
};

/// Fields from which locales are made.
struct LocaleFields {
    std::span<const double> vertex_distance;  ///< #vertices of the mesh: geodesic distance from the feature
    std::span<const double> curvature;        ///< #triangles of the mesh
};

/// Bands of the given geodesic width over the triangles of a part.
[[nodiscard]] Locales locales_of(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, const LocaleFields& fields,
                                 double width);

}  // namespace sqmap::decompose
