// Nearest points of triangles in double, for as many pairs of a point and a triangle as a vector holds.
#pragma once

#include "sqmap/math/vec.h"

#include <array>
#include <cstddef>

namespace sqmap::query {

/// Pairs of a point and a triangle in columns, and what measure says of each.
struct alignas(64) DoubleFeet {
    static constexpr std::size_t k_capacity = 320;
    double point[3][k_capacity], corner[3][3][k_capacity];
    double offset[3][k_capacity];  ///< from the point to the nearest point of the triangle
    double distance_sq[k_capacity], distance[k_capacity];
    double height[k_capacity];   ///< of the point above the triangle's plane; 0 for a triangle without area
    double facing[k_capacity];   ///< the height's size as a share of the distance; 0 without a distance
    double corners[k_capacity];  ///< that span the feature with the nearest point: see TriangleFoot

    void put(std::size_t pair, const Vec3d& p, const std::array<Vec3d, 3>& t)
    {
        put_vector(point, pair, p);
        for (std::size_t k = 0; k < 3; ++k) put_vector(corner[k], pair, t[k]);
    }
    [[nodiscard]] Vec3d offset_of(std::size_t pair) const { return vector(offset, pair); }
    [[nodiscard]] std::array<Vec3d, 3> triangle_of(std::size_t pair) const
    {
        return {vector(corner[0], pair), vector(corner[1], pair), vector(corner[2], pair)};
    }

    /// Fills in the results of some pairs, to the bit as foot_on_triangle has them. @pre pairs were put there, count > 0
    void measure(std::size_t first, std::size_t count);

private:
    using Columns = double[3][k_capacity];
    static void put_vector(Columns& columns, std::size_t pair, const Vec3d& v)
    {
        columns[0][pair] = v.x;
        columns[1][pair] = v.y;
        columns[2][pair] = v.z;
    }
    static Vec3d vector(const Columns& columns, std::size_t pair)
    {
        return {columns[0][pair], columns[1][pair], columns[2][pair]};
    }
};

}  // namespace sqmap::query
