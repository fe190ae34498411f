// Closed meshes the project makes itself, with closed-form or independently checkable answers.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/shape/superquadric.h"

#include <span>
#include <vector>

namespace sqmap::mesh {

// Every function returns a closed manifold mesh, counter-clockwise outward, in canonical order, with its vertices on
// the exact surface and no degenerate triangle. Lengths are in the caller's units.
// @throw std::invalid_argument for a size that is not positive or a resolution too low to close the shape.

/// Sphere about the origin from an icosahedron split into 20 * 4^subdivisions triangles.
[[nodiscard]] Mesh sphere(double radius, int subdivisions);

/// Axis-aligned ellipsoid about the origin: the sphere above, scaled.
[[nodiscard]] Mesh ellipsoid(Vec3d semi_axes, int subdivisions);

/// Box of the given half sizes whose edges and corners are rounded: every point within `radius` of the inner box.
/// segments: quads across a rounded edge and, at the same size, across the flats.
/// @throw std::invalid_argument unless 0 < radius < every half size
[[nodiscard]] Mesh rounded_box(Vec3d half_size, double radius, int segments);

/// A torus, in any unit of length.
struct TorusOptions {
    double major_radius = 1;     ///< from the axis (z) to the middle of the tube
    double minor_radius = 0.25;  ///< of the tube, < major_radius
    int major_segments = 96;     ///< around the axis, >= 3
    int minor_segments = 24;     ///< around the tube, >= 3
};
/// Torus about z.
[[nodiscard]] Mesh torus(const TorusOptions& options = {});

/// A dumbbell, in any unit of length.
struct DumbbellOptions {
    double ball_radius = 1;
    double bar_radius = 0.35;    ///< < ball_radius
    double half_distance = 1.8;  ///< from the origin to each ball's centre along z, > ball_radius
    int segments = 48;           ///< around the axis, >= 3
};
/// Two balls joined by a round bar.
[[nodiscard]] Mesh dumbbell(const DumbbellOptions& options = {});

/// Surface of a superquadric (eq. 1), tapered and bent where it is so, sampled along rays from its centre: no poles.
/// segments: quads along each edge of the cube that the rays pass through; 12 segments^2 triangles.
[[nodiscard]] Mesh superquadric_surface(const shape::Superquadricd& superquadric, int segments);

/// A capsule whose radius changes linearly from end to end (a sphere swept from a to b).
struct Capsule {
    Vec3d a, b;
    double radius_a = 1, radius_b = 1;
};

/// A solid given by capsules that melt into each other.
struct CapsuleSolid {
    std::vector<Capsule> capsules;
    double blend = 0.01;  ///< length over which two capsules melt; > 0
};

/// Below zero inside, about the distance from the surface near it; smooth except on the capsules' axes.
/// -blend log(sum exp(-d_i / blend)).
[[nodiscard]] double field(const CapsuleSolid& solid, Vec3d p);

/// A relaxed right hand: palm, four fingers of three phalanges bent at their joints, a thumb of two, and a wrist; about 0.9
/// units from wrist to tip.
[[nodiscard]] CapsuleSolid hand_capsules();

/// Surface field = 0 by marching tetrahedra on a grid of the given spacing; vertices are then spread evenly along the
/// surface. A watertight mesh for any solid; details thinner than the spacing may be missed.
/// Cost: grid points times capsules.
[[nodiscard]] Mesh polygonized(const CapsuleSolid& solid, double spacing);

/// Loop subdivision of a closed mesh, `times` over: four triangles for one, smooth limit surface (Loop 1987).
/// @throw std::invalid_argument where an edge has not exactly two triangles.
[[nodiscard]] Mesh loop_subdivided(const Mesh& mesh, int times);

/// Signed volume by the divergence theorem; positive for a closed mesh that faces outward.
[[nodiscard]] double volume(const Mesh& mesh);
/// Sum of the triangles' areas, mesh units squared.
[[nodiscard]] double surface_area(const Mesh& mesh);

}  // namespace sqmap::mesh
