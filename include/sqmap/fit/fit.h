// Fitting a bounding superquadric to a part (section 2, eq. 3) and proving that it bounds it.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/shape/superquadric.h"

#include <array>
#include <cstdint>
#include <span>

namespace sqmap::fit {

/// Residual that the data term of the fit sums over the samples; both kinds weigh by area.
enum class Residual : std::uint8_t {
    Radial,    ///< |q| (1 - F^-1/2), the distance along the ray from the centre; without the bias of eq. 3
    Equation3  ///< (a1 a2 a3)^1/4 (F - 1): eq. 3 as printed
};

/// Every default is free of units; lengths are relative to the part.
struct FitOptions {
    bool allow_taper = true;
    bool allow_bend = true;  ///< the bent model has taper too, whatever allow_taper says
    Residual residual = Residual::Radial;
    int max_iterations = 30;  ///< Levenberg-Marquardt steps of one start
    int max_samples = 200;    ///< surface points that enter eq. 3
    double min_exponent = 0.1;
    double max_exponent = 2.0;
    double max_overhang = 1.4;  ///< greatest semi-axis, as a multiple of the part's half extent along it
    double taper_gain = 0.04;   ///< a taper stays if it saves this share of the volume
    double bend_gain = 0.08;    ///< a bend stays if it saves this share of the volume
};

/// A proof that a superquadric holds triangles.
struct Certificate {
    double largest_f = 0;   ///< proven upper bound of F (eq. 1) over every point of every triangle
    double tolerance = 0;   ///< how far above the true largest F the bound may lie
    bool bounding = false;  ///< largest_f <= 1
};

/// A part's superquadric, and how it was found.
struct FitReport {
    shape::Superquadricd superquadric;  ///< bounding; every parameter is exactly representable as float
    Certificate certificate;            ///< over the part's triangles and the caps
    double rms = 0;                     ///< area-weighted root mean square radial distance of the samples, model units
    double volume = 0;                  ///< of the superquadric, model units cubed
    int iterations = 0;                 ///< Levenberg-Marquardt steps, all starts together
    bool converged = false;             ///< the data term and the volume of the chosen start both settled
    bool fallback = false;              ///< no optimised start won; the closed-form bound of the principal frame is given
};

/// Smallest superquadric found that holds every given triangle, caps included.
/// mesh: model space; triangles: the part's own, used for the fit and for containment; cap_triangles: must be held, but
/// are no surface and do not enter eq. 3. Corners in model units.
/// The deformation is injective on the shape (taper > -1, bend below its fold), so the shape is the homeomorphic image of
/// a ball: where part and caps form a closed surface, the solid within is held too.
/// Never throws for finite vertices and valid indices, however degenerate: flat, needle, a single triangle, one point.
/// Thread-safe; the result does not depend on earlier calls. Cost: about 5 ms a part for plain shapes, 12 ms
/// with taper and 25 ms with bend; one linear pass and the certificate grow with the triangles, nothing else does.
[[nodiscard]] FitReport fit_bounding(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles,
                                     std::span<const std::array<Vec3d, 3>> cap_triangles, const FitOptions& options = {});

/// Least squares on the samples alone (eq. 3), without containment: the paper's "mean square error" fit. Same input,
/// caps are left out; certificate is that of the part's triangles and as a rule not bounding.
[[nodiscard]] FitReport fit_surface(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles,
                                    const FitOptions& options = {});

/// Proves F <= 1 on every point of the triangles: by convexity for undeformed shapes (corners suffice), by recursive
/// subdivision with second-order bounds for tapered and bent ones. Sound for any parameters: what cannot be proven
/// gives largest_f = infinity. The proof is about the real F; float_margin() covers the runtime's rounding.
[[nodiscard]] Certificate certify(const shape::Superquadricd& superquadric, std::span<const std::array<Vec3d, 3>> triangles);
/// The same for triangles that share corners: faster. Every point counts, in a triangle or not.
[[nodiscard]] Certificate certify(const shape::Superquadricd& superquadric, std::span<const Vec3d> points,
                                  std::span<const mesh::Triangle> triangles);

/// How far F, evaluated in float as the runtime does, may exceed its real value at points of the shape.
/// fit_bounding leaves this much room: largest_f <= 1 - float_margin.
[[nodiscard]] double float_margin(const shape::Superquadricd& superquadric);

/// Volume of the superquadric, closed form (Beta functions); taper enters by its second moment, bend not at all.
[[nodiscard]] double volume(const shape::Superquadricd& superquadric);

}  // namespace sqmap::fit
