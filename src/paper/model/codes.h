// Values in the arrays of a paper map that are not plain numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace sqmap::paper {

inline constexpr std::uint16_t k_map_largest = 65533;  ///< distance; what is above is none
inline constexpr std::uint16_t k_map_cap = 65534;      ///< MapRay::Cap
inline constexpr std::uint16_t k_map_miss = 65535;     ///< MapRay::Miss; of a gap: it never ends
inline constexpr std::int16_t k_not_smoothed = -32768;

/// Offsets are four bits each, the low ones first; their squares count.
inline constexpr std::uint32_t k_largest_offset_code = 15, k_largest_offset = k_largest_offset_code * k_largest_offset_code;
constexpr std::size_t offset_bytes(std::size_t samples) { return (samples + 1) / 2; }
/// Rounded up. offset: times offset_scale.
inline std::uint32_t offset_code(double offset)
{
    return std::min(k_largest_offset_code, static_cast<std::uint32_t>(std::ceil(std::sqrt(offset))));
}

}  // namespace sqmap::paper
