// What stands for no value in the arrays of a normal map.
#pragma once

#include <cstdint>

namespace sqmap::model {

inline constexpr std::uint16_t k_map_largest = 65533;  ///< distance; what is above is none
inline constexpr std::uint16_t k_map_cap = 65534;      ///< MapRay::Cap
inline constexpr std::uint16_t k_map_miss = 65535;     ///< MapRay::Miss; of a gap: it never ends
inline constexpr std::int16_t k_not_smoothed = -32768;

}  // namespace sqmap::model
