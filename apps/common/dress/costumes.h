// Garments that fit the figure of person.h at 1.75 m; examples/garments has the same. Pure functions: any number of threads.
#pragma once

#include "sqmap/sim/garment.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace sqmap::app {

/// Steps a second of cloth that is played, the shares that each is solved in (ClothOptions::iterations), and how many steps a
/// frame has at 30 a second.
constexpr double k_cloth_rate = 120;
constexpr int k_cloth_shares = 16, k_steps_a_frame = 4;

struct Costume {
    sim::Garment garment;
    std::string waist_bone;  ///< that its waist rides; empty: none
};

/// skirt, poncho, or (any other name) shirt.
[[nodiscard]] Costume costume(std::string_view name, std::uint32_t vertices);

}  // namespace sqmap::app
