// Convex hulls of points, and convex polytopes between their two descriptions: corners and half-spaces.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/half_space.h"
#include "sqmap/mesh/mesh.h"

#include <span>
#include <vector>

namespace sqmap::mesh {

/// The convex hull of points as a closed mesh, triangles counter-clockwise seen from outside; facets of more than three
/// corners are several triangles in one plane. The signs that decide are exact: no point lies on the outer side of any
/// triangle's plane, whatever the rounding, and no triangle is without area. Vertices are points of the input, in its order;
/// a point in the middle of a flat facet may be one. The same points give the same mesh.
/// points: finite, in any frame and unit; coordinates zero or between 1e-70 and 1e70 in size.
/// Without triangles where all points lie in one plane (there is no solid) or there are fewer than four.
/// Cost: about n log n; some 5 ms for 10,000 points of a surface.
[[nodiscard]] Mesh convex_hull(std::span<const Vec3d> points);

/// The point where three planes meet, by Cramer's rule; false where two of them are parallel or all contain one direction.
[[nodiscard]] bool meet(const HalfSpaced& a, const HalfSpaced& b, const HalfSpaced& c, Vec3d& point);

/// True where a half-space holds a point, up to rounding (1e-9 of both).
[[nodiscard]] bool nearly_holds(const HalfSpaced& side, Vec3d p);

/// Corners of the convex polytope that half-spaces have in common: every point where three planes meet that all others hold,
/// each once or several times, up to rounding (some 1e-9 of its size). convex_hull of them is the polytope as a mesh.
/// Empty where the half-spaces have no point in common.
/// @pre together they bound a solid, as the tangent planes of a polytope that bounding_polytope gives (not checked)
/// Cost: the fourth power of their number at most; 0.1 ms for 20.
[[nodiscard]] std::vector<Vec3d> polytope_corners(std::span<const HalfSpaced> sides);

/// Corners that lie on the plane of one more half-space. sides: the others, which need not bound a solid.
/// Cost: the third power of their number at most.
[[nodiscard]] std::vector<Vec3d> corners_on(const HalfSpaced& side, std::span<const HalfSpaced> sides);

/// Distance of the farthest point from a convex hull, zero where it holds them all. For the corners of a convex body that
/// holds the hull this is the support excess, max over directions u of h_body(u) - h_hull(u): the excess over one direction
/// is at most that distance, and the direction from the hull to the farthest corner attains it.
/// hull: as convex_hull gives it, with triangles. Cost: a visit of every triangle for each point that is outside.
[[nodiscard]] double farthest_from_hull(const Mesh& hull, std::span<const Vec3d> points);

}  // namespace sqmap::mesh
