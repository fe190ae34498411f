// A convex polytope beside the superquadric of a part: few half-spaces, each proven to hold the part's solid.
#pragma once

#include "sqmap/math/half_space.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/shape/superquadric.h"

#include <cstddef>
#include <span>
#include <vector>

namespace sqmap::fit {

/// The half-space of a direction that touches points, in float: what dot(normal, p) <= offset decides in float, in any order of
/// the sums and with or without fused multiply-add, is true of every float point p of the points' convex hull.
/// Proof: with u = 2^-24, float evaluation errs by at most 3 u / (1 - 3 u) times sum_k |n_k p_k|, and by less than 2^-122 where
/// numbers vanish, be they flushed to zero or not. |p_k| is at most the largest |coordinate k| of the points, because the hull is
/// convex. The offset is the points' greatest dot product plus 4 u times that sum plus 2^-120, rounded upwards; the double
/// evaluation of that greatest product errs by at most 4 * 2^-53 times the sum, which the fourth u exceeds by far. direction: not
/// zero, any length. points: not empty, finite, model units, below 1e30 in size. Cost: linear in the points.
[[nodiscard]] HalfSpacef touching_side(Vec3d direction, std::span<const Vec3d> points);

/// Points that fill the unit cube evenly, without chance: the additive recurrence of the plastic number (M. Roberts 2018).
[[nodiscard]] std::vector<Vec3d> spread_points(std::size_t count);

/// A point of a superquadric, and the volume for which it stands.
struct InteriorPoint {
    Vec3d point;  ///< model space
    double weight;
};

/// Points spread evenly over a superquadric's inside; their weights sum to its volume. tries: points of the box around
/// the undeformed shape, of which some half are inside. The same arguments give the same points, which turn with the
/// superquadric.
[[nodiscard]] std::vector<InteriorPoint> interior_points(const shape::Superquadricd& superquadric, std::size_t tries);

/// Every default is free of units.
struct PolytopeOptions {
    std::size_t max_sides = 20;  ///< from 6 on
    std::size_t samples = 1500;  ///< of the superquadric, and as many of the box around the hull: what the sides are to cut off
};

/// Half-spaces that together bound a solid, hold every point of the hull, and cut off as much of the superquadric as so few can:
/// chosen greedily among tangent planes of the hull by the volume that each cuts off, then turned while that cuts off more. The
/// last fifth cuts off the corners farthest from the hull, for the sake of support excess.
/// hull: mesh::convex_hull of points; where it has no triangles (all points in one plane) the sides are those of a thin slab.
/// points: corners of a part and its caps, model space. By convexity the half-spaces hold every triangle and hence, as the
/// complement of a convex polytope is connected, the solid that patch and caps enclose (docs/algorithms/fit.md).
/// Cost: some 3 ms. Thread-safe; the result does not depend on earlier calls and turns with the part up to rounding.
[[nodiscard]] std::vector<HalfSpacef> bounding_polytope(const mesh::Mesh& hull, std::span<const Vec3d> points,
                                                        const shape::Superquadricd& beside, const PolytopeOptions& options = {});

/// True where half-spaces of these directions have no ray in common: the origin is inside the directions' hull.
[[nodiscard]] bool is_bounded(std::span<const Vec3d> directions);

/// The polytope with its sides turned, one by one, until no turn brings its farthest corners nearer to the hull, and a few sides
/// given up for others: a small support excess from the sides that are given. Empty where none comes nearer. hull: with
/// triangles; points: as bounding_polytope takes them. frame: its rows turn with the part. Cost: some 0.1 s for 20 sides.
/// Thread-safe; no call depends on earlier ones.
[[nodiscard]] std::vector<HalfSpacef> nearer_polytope(const mesh::Mesh& hull, std::span<const Vec3d> points,
                                                      std::span<const HalfSpacef> sides, const Mat3d& frame);

}  // namespace sqmap::fit
