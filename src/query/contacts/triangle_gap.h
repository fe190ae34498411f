// The distance of two triangles.
#pragma once

#include "math/triangle_crossing.h"

namespace sqmap::query {

/// Positions on two triangles.
struct TriangleGap {
    Vec3d on_a{}, on_b{};
    double distance_sq = 0;
};

/// The nearest positions of two triangles among those of which one is on a side or at a corner: the nearest of all where they
/// have no point in common. Total: triangles may be without area.
[[nodiscard]] TriangleGap gap_of(const TriangleCorners& a, const TriangleCorners& b) noexcept;

/// How far b is beyond a along a direction, about a position that both are near to; the direction's length is a factor.
[[nodiscard]] double gap_along(const TriangleCorners& a, const TriangleCorners& b, Vec3d direction, Vec3d about) noexcept;

/// The gap of two triangles that some direction proves: that between the nearest positions, and where that is too short for its
/// direction to be known, a normal of either or of two sides.
[[nodiscard]] double certain_gap(const TriangleCorners& a, const TriangleCorners& b, const TriangleGap& gap) noexcept;

/// A position of both triangles. @pre they meet as the crossing says
[[nodiscard]] Vec3d common_position(const TriangleCorners& a, const TriangleCorners& b, const Crossing& crossing) noexcept;

}  // namespace sqmap::query
