// Convex bodies that stand for a part in engines and files of others: boxes, balls, ellipsoids, capsules, cylinders, hulls,
// with how close they are to the thing: volume, support excess, coverage and protrusion.
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/vec.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/shape/superquadric.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::collider {

/// Kinds of shapes.
enum class Kind : std::uint8_t { Box, Sphere, Ellipsoid, Capsule, Cylinder, Hull, Superquadric };

/// "box", "sphere", "ellipsoid", "capsule", "cylinder", "hull" or "superquadric". Never null.
[[nodiscard]] const char* name_of(Kind kind) noexcept;

/// A shape in the frame and units of the points that it holds. Every number is one that a file writes: positions and angles have
/// nine significant digits, lengths too, rounded up. So the shape that a reader finds is this one, to the last bit.
struct Shape {
    Kind kind = Kind::Box;
    Vec3d xyz{};   ///< the shape's centre
    Vec3d rpy{};   ///< its attitude, radians: about the fixed axes x, then y, then z, as URDF and SDF have it
    Vec3d size{};  ///< half lengths along the shape's own axes: box, ellipsoid; radius three times: ball; radius twice, then half
                   ///< the length of the axis, caps not counted: capsule, cylinder. Hull, superquadric: unused
    mesh::Mesh hull{};                    ///< Kind::Hull: closed, convex, counter-clockwise outward
    shape::Superquadricd superquadric{};  ///< Kind::Superquadric
};

/// The matrix Rz(yaw) Ry(pitch) Rx(roll): shape's axes -> those of the frame.
[[nodiscard]] Mat3d rotation_of_rpy(Vec3d rpy) noexcept;
/// Angles of a rotation. Where pitch is a right angle, roll is 0.
[[nodiscard]] Vec3d rpy_of(const Mat3d& rotation) noexcept;
/// The quaternion w, x, y, z of the same rotation: unit, w not negative.
struct Quaternion {
    double w = 1, x = 0, y = 0, z = 0;
};
/// The quaternion of a rotation by roll, pitch and yaw, rad, as URDF has them.
[[nodiscard]] Quaternion quaternion_of_rpy(Vec3d rpy) noexcept;

/// The volume that the shape holds.
[[nodiscard]] double volume(const Shape& shape);
/// Support: the greatest dot product of a unit direction and a point of the shape. Of a tapered or bent superquadric it is that
/// of 900 points of its surface, some 0.3 % of its size too small. Prepared once, since hulls and superquadrics need more than
/// arithmetic.
class Support {
public:
    /// Copies what it needs of the shape.
    explicit Support(const Shape& shape);
    [[nodiscard]] double operator()(Vec3d direction) const noexcept;

private:
    Shape shape_;
    Mat3d axes_;
    std::vector<Vec3d> corners_;  ///< hulls and deformed superquadrics
};

/// A lower bound of a point's distance from the shape, 0 within it. Exact of a ball, a box, a capsule and a cylinder.
class Outside {
public:
    /// Copies what it needs of the shape.
    explicit Outside(const Shape& shape);
    [[nodiscard]] double operator()(Vec3d p) const noexcept;

private:
    struct Plane {
        Vec3d on, normal;
    };
    Shape shape_;
    Mat3d axes_;
    std::vector<Plane> planes_;  ///< of a hull
};

/// The shape of a kind that holds all points, of nearly the least volume: box, ball, ellipsoid and capsule within 2 % of it. The
/// hull holds them exactly; the lengths of others have a margin of 1e-12 of the greatest coordinate for a reader's rounding. So
/// the shape as written holds every point, and by convexity all between them. Points in one plane, on one line or all at one
/// position get a shape that is 1e-6 of their extent thick.
/// kind: any but Superquadric, which is fitted to more than points. points: not empty, finite.
/// Cost: 1 ms (ball) to some 30 ms (box) for a hull of 500 corners. Thread-safe.
[[nodiscard]] Shape enclosing(Kind kind, std::span<const Vec3d> points);

/// Numbers of a file's meshes.
enum class Precision : std::uint8_t { Double, Float };

/// A convex mesh that holds the points and keeps near a shape that does: the hull of points of the shape's surface, enlarged from
/// the shape's centre by as little as holds the points, exactly, in the numbers of the file. For files that lack the shape.
/// Without points it holds the shape itself, a ball. A hull stays as it is in double.
[[nodiscard]] Shape as_hull(const Shape& shape, std::span<const Vec3d> points, Precision precision = Precision::Double);

/// The surface of a shape as triangles, for pictures: corners lie on it.
[[nodiscard]] mesh::Mesh surface_of(const Shape& shape);

/// Figures of shapes that stand together for a solid. Lengths in its units; a figure that needs a solid is -1 without one. A
/// single ball of those that hold a solid together has a volume alone, the rest is -1.
struct Figures {
    double volume = 0;         ///< of the shapes, summed: what two of them share counts twice
    double volume_ratio = -1;  ///< volume over the solid's
    /// max over directions u of h_shapes(u) - h_solid(u): exact for hulls, boxes, balls and capsules; of others at most 0.2 % of
    /// the solid's extent too small
    double support_excess = 0;
    double protrusion =
        -1;  ///< greatest distance from the solid of a point that some shape holds; at most 1 % of its extent too small
    double coverage = 1;  ///< share of the solid that the shapes hold: 1 by their certificate
};

/// points: of the solid, whose convex hull counts for the support. solid: distances to it, or null; closed.
/// Cost: some 50 ms for twenty shapes.
struct Measured {
    std::span<const Vec3d> points;
    double volume = 0;  ///< of the solid; 0: none
    const mesh::Mesh* solid = nullptr;
    std::span<const std::uint8_t> crossed{};
};
/// The figures of shapes that together enclose the solid. Cost: linear in the shapes and in the solid's triangles.
[[nodiscard]] Figures figures_of(std::span<const Shape> shapes, const Measured& solid);

}  // namespace sqmap::collider
