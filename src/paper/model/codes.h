// Values in the arrays of a paper map that are not plain numbers.
#pragma once

#include "sqmap/paper/model.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace sqmap::paper {

inline constexpr std::uint16_t k_map_largest = 65533;  ///< distance; what is above is none
inline constexpr std::uint16_t k_map_cap = 65534;      ///< MapRay::Cap
inline constexpr std::uint16_t k_map_miss = 65535;     ///< MapRay::Miss; of a gap: it never ends

/// Offsets are words: the sample above, four bits below, whose square counts. They rise, and these end them.
inline constexpr std::uint32_t k_offset_bits = 4, k_no_offset = 0x7fffffff;
inline constexpr std::uint32_t k_largest_offset_code = 15, k_largest_offset = k_largest_offset_code * k_largest_offset_code;
/// Rounded up. offset: times offset_scale.
inline std::uint32_t offset_code(double offset)
{
    return std::min(k_largest_offset_code, static_cast<std::uint32_t>(std::ceil(std::sqrt(offset))));
}

/// A smoothed sample's bits: its change below, its normal above. Two take five bytes.
inline constexpr std::uint32_t k_change_bits = 6, k_smoothed_bits = 20;
inline constexpr int k_smoothed_normal_bits = 7;  ///< along each axis
inline constexpr std::int32_t k_not_smoothed = -32, k_largest_change_code = 31,
                              k_largest_change = k_largest_change_code * k_largest_change_code;
/// SmoothedSample::change, whose square counts: most changes are small beside the largest. steps: times change_scale.
inline std::int32_t change_code(double steps)
{
    const auto root = static_cast<std::int32_t>(std::lround(std::sqrt(std::abs(steps))));
    return steps < 0 ? -std::min(root, k_largest_change_code) : std::min(root, k_largest_change_code);
}
/// Bytes of so many samples, and those that a query reads behind the last.
constexpr std::size_t smoothed_bytes(std::size_t hits) { return ((hits + k_hit_padding) * k_smoothed_bits + 7) / 8; }

constexpr std::size_t base_rows(const MapGrid& grid) { return ((grid.eta_count - 1) >> grid.subdivisions) + 1; }
constexpr std::size_t base_columns(const MapGrid& grid) { return grid.omega_count >> grid.subdivisions; }
inline constexpr std::size_t k_rank_samples = 32;  ///< of a HitRank
constexpr std::size_t rank_count(std::size_t samples) { return (samples + k_rank_samples - 1) / k_rank_samples; }
/// The HitRank that the distances give. before: the hits that come before its samples.
[[nodiscard]] HitRank hits_in(const MapView& map, std::size_t rank, std::uint32_t before) noexcept;

}  // namespace sqmap::paper
