// How two features that meet are separated: along which direction the least translation does it.
#pragma once

#include "math/triangle_crossing.h"
#include "sqmap/query/contacts.h"

#include <optional>

namespace sqmap::query {

/// A translation of b by depth along normal after which two features only touch. The frame of their positions.
struct Separation {
    Vec3d on_a{}, on_b{};  ///< witness points: on_b = on_a - depth normal
    Vec3d normal{};        ///< unit
    double depth = 0;      ///< >= 0
    Feature feature_a = Feature::Face, feature_b = Feature::Face;
    int corner_a = 0, corner_b = 0;  ///< of the triangles: a vertex, or where an edge begins
};

/// An edge and the corners of its two triangles that are not on it.
struct Wedge {
    Vec3d from, to;
    Vec3d beside[2];
};

/// True where separate() surely finds nothing: along the lines' common normal the faces fall off both ways, by more than double
/// rounds. Most pairs of edges that cross are such ones; this takes a fraction of separate()'s time.
[[nodiscard]] bool surely_lack_support(const Wedge& a, const Wedge& b) noexcept;

/// Nothing where the edges do not support each other: no direction is normal to both from which a's faces fall off one way and
/// b's the other way, or the lines are not nearest to each other within both edges, or four times as deep as one of the edges
/// goes on from there. Its features are edges.
[[nodiscard]] std::optional<Separation> separate(const Wedge& a, const Wedge& b) noexcept;

/// The least translation along a normal of one of the two that separates triangles that meet: no less than the least of all.
[[nodiscard]] double depth_along_normals(const TriangleCorners& a, const TriangleCorners& b) noexcept;

/// The least translation that separates two triangles that meet, b to the outer side of a where one is. By the theorem of the
/// separating axis it is along a triangle's normal or normal to two edges.
[[nodiscard]] Separation separate(const TriangleCorners& a, const TriangleCorners& b) noexcept;

}  // namespace sqmap::query
