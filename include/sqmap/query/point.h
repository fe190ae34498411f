// The layered query of a point (section 4.2): is it inside the body, penetration depth, direction out.
#pragma once

#include "sqmap/query/body.h"
#include "sqmap/query/contact.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace sqmap::query {

/// The answer for one point, in the frame and units of the body's pose.
struct PointResult {
    bool contact = false;  ///< the point is inside
    bool certain = false;  ///< the verdict is proven (by the map's bounds or by exact geometry), not approximated
    std::uint8_t status = k_ok;
    std::int32_t part = -1;  ///< that owns the witness point; -1 where free
    double depth = 0;        ///< penetration depth, >= 0; zero where free
    Vec3d witness{};         ///< the nearest surface point; the queried point where free
    Vec3d normal{};          ///< unit, outward, at the witness point; zero where free
};

/// One point, in the frame and units of the body's pose. In a model with a locator (and central maps, or layer Exact) the answer
/// has the same bits as query_probe's of that position; on layer Two a probe may leave out what its clusters prove free. A free
/// point is certain where its locator cell is free, and on layer Exact beyond the rounding of float (4e-6 of the object's radius
/// from the surface, as a contact is). With offset or margin, points up to that far outside the surface are in contact too, and
/// depth is measured from the moved surface; with offset, margin or smoothing no verdict is called certain. A body without a
/// model: free. Total, noexcept, no allocation; thread-safe. Cost: with a locator 0.1 to 1 microseconds; without one, a sphere
/// and a box test a part, and where the point is inside, a search bounded by the part's cells.
/// @pre the model came from model::parse (not checked)
[[nodiscard]] PointResult query_point(const Body& touched, Vec3d point, const QueryOptions& options = {}) noexcept;

/// The same in the mesh's own frame.
[[nodiscard]] PointResult query_point(const model::ModelView& model, Vec3d point, const QueryOptions& options = {}) noexcept;

/// A batch: results[i] answers points[i], with the bits of one by one. Returns the number of contacts. Thread-safe: for several
/// threads give each a part of the spans.
/// @pre results.size() >= points.size(), else the rest is left out
std::size_t query_points(const Body& touched, std::span<const Vec3d> points, const QueryOptions& options,
                         std::span<PointResult> results) noexcept;

/// A point of the mesh's own triangles.
struct SurfacePoint {
    Vec3d point{};           ///< in the frame and units of the body's pose
    Vec3d normal{};          ///< unit, outward: the triangle's own
    double distance = 0;     ///< to the queried point
    std::int32_t part = -1;  ///< that owns it
};

/// The nearest surface point to a point on either side of it, sought downhill from another surface point (from: its point and
/// normal are read): what is near in space but not from there is not seen. Nothing where none was found, as for a point that is
/// not finite. Total, noexcept, no allocation; thread-safe.
/// @pre model::has_exact(*touched.model)
/// Cost: two or three lists of 10 to 50 triangles.
[[nodiscard]] std::optional<SurfacePoint> nearest_surface(const Body& touched, Vec3d point, const SurfacePoint& from) noexcept;

/// Distance to the surface along the projection of one part at a point (eq. 35): signed, positive outwards, to the nearest
/// crossing on its ray; the mesh's frame and units. Nothing where the part's map has none on that ray.
/// Total, noexcept, no allocation; thread-safe. @pre the model came from model::parse (not checked), and the part exists
[[nodiscard]] std::optional<double> distance_along_projection(const model::ModelView& model, std::uint32_t part, Vec3d point,
                                                              Layer layer) noexcept;

}  // namespace sqmap::query
