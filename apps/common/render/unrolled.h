// A part's central map unrolled (Fig. 4c): the six faces of its cube as a cross, from what layer 3 answers.
#pragma once

#include "sqmap/model/model.h"

#include <cstdint>
#include <vector>

namespace sqmap::app {

inline constexpr int k_cross_columns = 4, k_cross_rows = 3;  ///< faces of the cross
// Values of a pixel that are not distances.
inline constexpr float k_no_hit = -1, k_cap = -2, k_paper = -3;

/// One part's map as an image.
struct Unrolled {
    int width = 0, height = 0;
    std::vector<float> distance;   ///< below the superquadric, model units, or one of k_no_hit, k_cap, k_paper
    std::vector<Vec3f> surface{};  ///< beside distance: the point of the surface, model space; central maps alone
};

/// Four faces around z, and the two that z leaves through above and below the second: 4 side by 3 side pixels.
[[nodiscard]] Unrolled unrolled_central(const model::ModelView& model, std::uint32_t part, int side);

}  // namespace sqmap::app
