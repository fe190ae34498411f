// The tree of bounds: an octree about the object whose leaves say how far the surface is from their centres.
#pragma once

#include "sqmap/model/distance.h"

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

/// Of a leaf whose surface is no nearer to its centre; half: of its side.
inline std::uint16_t encode_bound(double distance, double half, bool inside)
{
    const double steps = std::floor(distance * (1 - 1e-6) / (half * static_cast<double>(k_bound_step)));
    const auto code = static_cast<std::uint32_t>(std::clamp(steps, 0.0, static_cast<double>(k_bound_code)));
    return static_cast<std::uint16_t>(k_bound_leaf | (inside ? k_bound_inside : 0) | code);
}

/// The slope of the signed distance at a leaf's centre, octahedral, 8 + 8 bits, for models without the exact layer: x in the low
/// byte.
constexpr std::uint16_t bound_slope(std::uint8_t u, std::uint8_t v) { return static_cast<std::uint16_t>(u | v << 8); }

}  // namespace sqmap::model
