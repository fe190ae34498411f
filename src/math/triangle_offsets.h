// Many points against many triangles, for every instruction set: what bake judges lists of triangles with.
#pragma once

#include "sqmap/math/vec.h"

#include <cstddef>
#include <span>

namespace sqmap {

/// Points in columns; a multiple of k_point_step of them.
struct PointColumns {
    const float *x, *y, *z;
    std::size_t count;
};
inline constexpr std::size_t k_point_step = 16;

/// From every point to the nearest point of every triangle, triangle after triangle: to.count values each. The same bits on every
/// instruction set. corners: three a triangle.
void triangle_offsets(std::span<const Vec3f> corners, const PointColumns& points, float* x, float* y, float* z,
                      float* distance) noexcept;

}  // namespace sqmap
