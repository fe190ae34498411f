// Fitting a bounding superquadric to a part (section 2, eq. 3) and proving that it bounds it.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/shape/superquadric.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::fit {

struct FitOptions {
    bool allow_taper = true;
    bool allow_bend = true;
    int max_iterations = 30;  ///< Levenberg-Marquardt steps of one start
    int max_samples = 256;    ///< surface points that enter eq. 3
    double min_exponent = 0.1;
    double max_exponent = 2.0;
};

/// A proof that a superquadric holds triangles.
struct Certificate {
    double largest_f = 0;  ///< proven upper bound of F (eq. 1) over every point of every triangle
    double tolerance = 0;  ///< how far above the true largest F the bound may lie; bounding means largest_f <= 1
    bool bounding = false;
};

struct FitReport {
    shape::Superquadricd superquadric;  ///< bounding; every parameter is exactly representable as float
    Certificate certificate;
    double rms = 0;  ///< root mean square of the radial distance between fit and samples, model units
    double volume = 0;
    int iterations = 0;
    bool converged = false;
    bool fallback = false;  ///< the closed-form bounding ellipsoid was used
};

/// Smallest superquadric found that holds every given triangle, caps included.
/// vertices: #vertices; triangles: the part's own ones, used for the fit and for containment; extra_triangles: caps
/// that must be contained but are not surface, as corner points.
[[nodiscard]] FitReport fit_bounding(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles,
                                     std::span<const std::array<Vec3d, 3>> cap_triangles, const FitOptions& options);

/// Proves F <= 1 on every point of the triangles: by convexity for undeformed shapes (corners suffice), by recursive
/// interval bounds for tapered and bent ones.
[[nodiscard]] Certificate certify(const shape::Superquadricd& superquadric, std::span<const std::array<Vec3d, 3>> triangles);

}  // namespace sqmap::fit
