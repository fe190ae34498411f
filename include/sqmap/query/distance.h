// Signed distance on both sides of the surface: how far, which direction, where the nearest surface is, and how that is known.
#pragma once

#include "sqmap/query/body.h"
#include "sqmap/query/contact.h"
#include "sqmap/query/probe.h"

#include <cstdint>
#include <limits>
#include <span>

namespace sqmap::query {

/// How a distance is known.
enum class DistanceKind : std::uint8_t {
    Exact,         ///< of the mesh's own triangles
    Approximate,   ///< by layer 3: models baked without the exact layer
    LowerBound,    ///< the truth has this sign, is no nearer, and at most twice as far
    ExactInFloat,  ///< of exact_distances: of the triangles, but in float, as the model does not keep its input
};

/// Stands for the band that a model was baked with: what is quickest, and a bound beyond it.
inline constexpr double k_baked_band = -1;
/// The band of a caller who wants no bounds, at any distance.
inline constexpr double k_everywhere = std::numeric_limits<double>::infinity();

/// The answer for one point, in the frame in which the touched body's pose is given, and its units.
struct [[nodiscard]] SignedDistance {
    double distance = 0;     ///< to the nearest surface, negative inside; of a surface that bounds no solid never negative
    Vec3d gradient{};        ///< of the distance, unit: away from the surface outside, towards it inside; zero of a bound
    Vec3d witness{};         ///< the nearest surface point; the queried point itself of a bound
    std::int32_t part = -1;  ///< that owns the surface there; -1 of a bound, or where it is not known
    DistanceKind known = DistanceKind::LowerBound;
    std::uint8_t status = k_ok;  ///< bits of Status; k_made_up: a cure made the surface there up
    std::int32_t triangle = -1;  ///< of the model, that holds the witness point; -1 of a bound, and without triangles
};

/// The signed distance at a point in the frame of the touched body's pose, computed in float: errors are 1e-7 of R_max, more
/// where the point is farther away than the object is large. band: how far on either side it is to be exact; beyond, a lower
/// bound suffices, but an exact distance may be given. Real-time callers pass k_baked_band. Farther than 1e15 model units it is a
/// bound whatever the band. Without the exact layer it is approximate within the baked band (status k_no_exact). A paper model
/// knows distances by its triangles; without them all it gives is a lower bound by the object's sphere, with a status bit
/// of its own. A point or a pose that is not finite: distance 0, LowerBound, k_not_finite. A body without a model is nowhere: the
/// greatest double, LowerBound. Total, noexcept, no allocation, the same bits on every instruction set; thread-safe. Cost: about
/// a microsecond within the band, a fifth of it beyond.
/// @pre touched.model came from model::parse (not checked)
[[nodiscard]] SignedDistance distance(const Body& touched, Vec3d point, double band = k_everywhere) noexcept;

/// The same in the mesh's own frame and units.
[[nodiscard]] SignedDistance distance(const model::ModelView& model, Vec3d point, double band = k_everywhere) noexcept;

/// A batch: answers[i] is that of points[i], the same bits as one by one. Four thousand at a time share the work, and of 4,096
/// points on up to 65,536 are put in order first: four times quicker than one by one, and more. Uses 1 MB of stack.
/// Thread-safe: give each thread a part of the spans, a large one.
/// @pre answers.size() >= points.size(), else the rest is left out
void distances(const Body& touched, std::span<const Vec3d> points, std::span<SignedDistance> answers,
               double band = k_everywhere) noexcept;

/// The same in the mesh's own frame and units.
void distances(const model::ModelView& model, std::span<const Vec3d> points, std::span<SignedDistance> answers,
               double band = k_everywhere) noexcept;

/// The exact signed distance in double: every triangle that boxes in float do not exclude is evaluated on the coordinates that
/// the caller gave, and the nearest answers, named by its angle to the point, then by its number in the input. Errors are some
/// 1e-16 of the coordinates' size, so that finite differences are derivatives. Across the edges where triangles cut each other
/// the surface is stored in float. A model without its input answers in float, and its answer says so (ExactInFloat); one without
/// triangles as distance() does. Everything else is as there. Cost: half as much again as distance(). At concave edges beyond
/// the surface, and on the medial axis within, the nearest point is one of several and the gradient jumps.
[[nodiscard]] SignedDistance exact_distance(const Body& touched, Vec3d point) noexcept;
/// The same in the mesh's own frame and units.
[[nodiscard]] SignedDistance exact_distance(const model::ModelView& model, Vec3d point) noexcept;
/// A batch: as distances().
void exact_distances(const Body& touched, std::span<const Vec3d> points, std::span<SignedDistance> answers) noexcept;
/// The same in the mesh's own frame and units.
void exact_distances(const model::ModelView& model, std::span<const Vec3d> points, std::span<SignedDistance> answers) noexcept;

/// Distances of the points of the collider's probe: answers[i] is that of point i, in the frame of both poses. Exact within the
/// baked band.
/// @pre touched has a model, collider a probe, and answers.size() >= collider.probe->size(), else nothing is written
void distances(const Body& touched, const Body& collider, std::span<SignedDistance> answers) noexcept;

/// True where some point of the collider's probe is inside the touched body or nearer to its surface than reach, in the poses'
/// units. Clusters of points whose sphere is farther by the tree of bounds cost next to nothing, and the first point that is near
/// ends it. False without a model or a probe, for a pose that is not finite, or reach that is not above zero. Without the exact
/// layer it is as right as the approximate distance, and beyond the baked band true may be said of what is up to twice as far.
/// Total, noexcept, no allocation; thread-safe.
[[nodiscard]] bool is_nearer(const Body& touched, const Body& collider, double reach) noexcept;

}  // namespace sqmap::query
