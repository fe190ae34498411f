// Garments that fit the figure of person.h at 1.75 m; examples/garments has the same. Pure functions: any number of threads.
#pragma once

#include "sqmap/sim/garment.h"

#include <cstdint>
#include <string>
#include <string_view>

namespace sqmap::app {

struct Costume {
    sim::Garment garment;
    std::string waist_bone;  ///< that its waist rides; empty: none
};

/// skirt, poncho, or (any other name) shirt.
[[nodiscard]] Costume costume(std::string_view name, std::uint32_t vertices);

}  // namespace sqmap::app
