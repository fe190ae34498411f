// The tree of bounds: an octree about the object whose leaves say how far the surface is from their centres.
#pragma once

#include "model/hierarchy.h"

#include <algorithm>
#include <cmath>

namespace sqmap::model {

/// A node is 16 bits: the index of the eight nodes of a divided cell, x fastest, or k_bound_leaf. The root is divided; its
/// eighths come first.
inline constexpr std::uint32_t k_bound_leaf = 0x8000;
inline constexpr std::uint32_t k_bound_inside = 0x4000;  ///< the leaf's centre is in the solid
inline constexpr std::uint32_t k_bound_code = 0x3fff;    ///< 0: too near for a bound
inline constexpr float k_bound_step = 1.f / 256;         ///< of half of the cell's side
/// From this code on the bound is at least half of the truth in all of the cell.
inline constexpr std::uint32_t k_least_bound = 1380;
inline constexpr int k_max_bound_depth = 16;
inline constexpr std::size_t k_max_bounds = std::size_t{8} * k_bound_leaf;

/// The code of a lower bound of the distance from a leaf's centre to the surface; half: half the leaf's side.
inline std::uint16_t encode_bound(double distance, double half, bool inside)
{
    const double steps = std::floor(distance * (1 - 1e-6) / (half * static_cast<double>(k_bound_step)));
    const auto code = static_cast<std::uint32_t>(std::clamp(steps, 0.0, static_cast<double>(k_bound_code)));
    return static_cast<std::uint16_t>(k_bound_leaf | (inside ? k_bound_inside : 0) | code);
}

inline constexpr double k_sample_steps = 65535;
inline SurfaceSample encode_sample(const DistanceHeader& header, Vec3d point, Vec3d normal)
{
    SurfaceSample sample{};
    for (int k = 0; k < 3; ++k) {
        const double share = (point[k] - static_cast<double>(header.root[k])) / (2 * static_cast<double>(header.half)) + 0.5;
        sample.point[k] = static_cast<std::uint16_t>(std::clamp(std::round(share * k_sample_steps), 0.0, k_sample_steps));
    }
    encode_axis(normal, sample.normal[0], sample.normal[1]);
    return sample;
}
inline Vec3f sample_point(const DistanceHeader& header, const SurfaceSample& sample)
{
    const float step = 2 * header.half / static_cast<float>(k_sample_steps);
    return {header.root[0] - header.half + step * static_cast<float>(sample.point[0]),
            header.root[1] - header.half + step * static_cast<float>(sample.point[1]),
            header.root[2] - header.half + step * static_cast<float>(sample.point[2])};
}

}  // namespace sqmap::model
