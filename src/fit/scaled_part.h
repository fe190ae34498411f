// A part in coordinates of its own, as the searches of a fit read it.
#pragma once

#include "problems.h"
#include "sqmap/fit/fit.h"
#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::fit {

using Corners = std::array<Vec3d, 3>;

/// Coordinates about the middle of the part's principal box, with greatest distance 1 from it.
struct ScaledPart {
    std::vector<Corners> triangles;     ///< model space: surface, then caps
    std::vector<Vec3d> corners;         ///< model space: of the surface, each once, and of the caps
    std::vector<mesh::Triangle> faces;  ///< triangles, by corners
    Mat3d frame;                        ///< rows: principal axes, longest first
    Vec3d middle;                       ///< model space: origin of the scaled coordinates
    double size = 1;                    ///< model units
    std::vector<Vec3d> points;          ///< all corners
    std::vector<Vec3d> extreme;         ///< those of them that lie farthest in some of many directions
    std::vector<Vec3d> points_inner;    ///< points, and some within triangles large enough to leave a shape that is not convex
    std::vector<Vec3d> extreme_inner;   ///< extreme, and some of those
    std::vector<Vec3d> check;           ///< points_inner, thinned to a few hundred
    std::vector<Sample> samples;        ///< of the surface, without caps
    double min_a = 1e-3;
};

/// Cost: linear in the triangles and caps.
[[nodiscard]] ScaledPart scaled_part(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles,
                                     std::span<const Corners> caps, const FitOptions& options);

/// The smallest box about points whose sides lie along a frame's rows.
struct OrientedBox {
    Vec3d middle, half;
};
[[nodiscard]] OrientedBox box_of(const Mat3d& frame, std::span<const Vec3d> points);

/// The coordinates that searches vary, within the options' limits.
[[nodiscard]] Chart chart_of(const ScaledPart& part, const FitOptions& options);

}  // namespace sqmap::fit
