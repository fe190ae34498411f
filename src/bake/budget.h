// How many bytes a model's stages may take together.
#pragma once

#include <algorithm>
#include <cstddef>

namespace sqmap::bake {

/// The bytes allowed to maps and locator, for a target error in percent of R_max: 480 kB for ten thousand triangles or fewer at
/// half a percent. A plane's error grows with the square of its cell, so cells, as many as bytes, go with its inverse.
[[nodiscard]] inline double byte_budget(std::size_t triangles, double target_error)
{
    return 480e3 * (0.5 / target_error) * std::max(1.0, static_cast<double>(triangles) / 10e3);
}

/// The bytes allowed to a whole model, the exact layer with its triangles and their lists included.
[[nodiscard]] inline double model_byte_budget(std::size_t triangles, double target_error)
{
    return 2 * byte_budget(triangles, std::min(target_error, 0.5));
}

}  // namespace sqmap::bake
