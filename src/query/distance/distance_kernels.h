// Distances in model space: what the vector kernels leave to be said of each point.
#pragma once

#include "sqmap/model/model.h"

#include <cstdint>
#include <span>

namespace sqmap::query {

/// The side of a point, as told by the triangles that tie for the nearest.
enum SeenSide : std::uint32_t { k_seen_outside = 1, k_seen_inside = 2, k_seen_unclear = 4 };

/// The nearest surface of a point, or a bound, which has a distance and a side.
struct NearestSurface {
    Vec3f offset{};           ///< from the point to the surface
    float distance = 0;       ///< of bounds: at least; they may be negative
    std::int32_t entry = -1;  ///< triangle, or #triangles + piece; -1: no triangle was found
    std::uint32_t sides = 0;  ///< bits of SeenSide
};

inline constexpr std::size_t k_bounded_at_once = 256, k_searched_at_once = 4096;

/// The triangles of a point that float cannot tell from the nearest: leaves of the hierarchy, each with its eight triangles.
struct NearTriangles {
    static constexpr std::uint32_t k_capacity = 5;
    static constexpr std::uint32_t k_too_many = 0xffffffffu;
    std::int32_t entry;                ///< the nearest in float; -1: none was found
    std::uint32_t count;               ///< of leaves; k_too_many: they are not all here
    std::uint32_t leaves[k_capacity];  ///< leaf << 8, with a bit for each of its triangles
    float least_sq[k_capacity];        ///< squared distances of these
};

/// Bounds for up to k_bounded_at_once points; near: the indices of those that are not known to be farther
/// than within, whose bounds do not count. Returns how many. Outside the root of the tree of bounds they may be less than half of
/// the distance. @pre found.size() and near.size() >= points.size(); there is a tree
[[nodiscard]] std::size_t bound_surfaces(const model::ModelView& model, float within, std::span<const Vec3f> points,
                                         std::span<NearestSurface> found, std::span<std::uint16_t> near) noexcept;

/// The nearest triangles of up to k_searched_at_once points, together: the more, the less time each takes.
/// @pre found.size() >= points.size()
void search_surfaces(const model::ModelView& model, std::span<const Vec3f> points, std::span<NearestSurface> found) noexcept;

/// The same, with all triangles that boxes and triangles in float do not exclude from being the nearest. Float errs by no more
/// than k_box_rounding of the sum of a point's coordinates, those of the object's sphere and its radius; of a triangle without
/// area by its height over its longest side, k_flat_height of it at most.
/// @pre near.size() >= points.size()
void search_near_triangles(const model::ModelView& model, std::span<const Vec3f> points, std::span<NearTriangles> near) noexcept;

/// Called with a leaf of the hierarchy; returns how far leaves may be from then on.
using LeafVisit = float (*)(void* context, std::uint32_t leaf);

/// Visits the leaves whose boxes are within reach of a point, model space, in float: boxes are farther than they seem by no more
/// than k_box_rounding of the sum of the point's coordinates, those of the object's sphere and its radius.
/// @pre the model has a hierarchy
void visit_leaves(const model::ModelView& model, Vec3f point, float reach, LeafVisit visit, void* context) noexcept;
/// A coordinate's difference, scaled and squared, takes eight roundings at most; turning into a leaf's axes, which are 6 off, ten
/// more. Rounded up to a power of two.
inline constexpr float k_box_rounding = 0x1p-19f;
inline constexpr float k_flat_height = 3.2e-6f;  ///< TriangleFrames' limit, and some more

}  // namespace sqmap::query
