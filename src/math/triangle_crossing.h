// Segments and triangles that meet, decided by exact orientations alone: no tolerance.
// Pure functions and plain data: any number of threads.
#pragma once

#include "math/predicates.h"

#include <cstdint>

namespace sqmap {

/// The corners of a triangle.
struct TriangleCorners {
    Vec3d a, b, c;

    constexpr Vec3d operator[](int i) const { return i == 0 ? a : (i == 1 ? b : c); }
};

/// Coordinates with one axis left out: turns in a plane keep their sense, all or none reversed.
constexpr Vec2d projected(Vec3d p, int axis) { return {p[(axis + 1) % 3], p[(axis + 2) % 3]}; }

/// An axis along which the triangle is not seen edge-on; -1 if it has no area.
[[nodiscard]] int open_axis(const TriangleCorners& t) noexcept;

/// True where the closed segment from p to q has a point in common with the closed triangle. A triangle without area is met by
/// nothing that crosses its line: the other triangle's segments are met by its sides instead.
[[nodiscard]] bool segment_meets(Vec3d p, Vec3d q, const TriangleCorners& t) noexcept;

/// How two triangles meet. Side k of a triangle runs from its corner k to the next one.
struct Crossing {
    std::uint8_t sides_a = 0;  ///< bit k: side k of a meets b
    std::uint8_t sides_b = 0;  ///< bit k: side k of b meets a

    [[nodiscard]] constexpr bool meets() const { return (sides_a | sides_b) != 0; }
};
/// The closed triangles a and b: they have a point in common exactly where a side of one meets the other.
[[nodiscard]] Crossing crossing_of(const TriangleCorners& a, const TriangleCorners& b) noexcept;

}  // namespace sqmap
