// A part's map unrolled (Fig. 4c). Central: the six faces of its cube as a cross, from what layer 3 answers. Normal: the stored
// grid, longitude omega across, latitude eta up.
#pragma once

#include "sqmap/model/model.h"
#include "sqmap/paper/model.h"
#include "sqmap/shape/surface.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace sqmap::app {

inline constexpr int k_cross_columns = 4, k_cross_rows = 3;  ///< faces of the cross
// Values of a pixel that are not distances.
inline constexpr float k_no_hit = -1, k_cap = -2, k_paper = -3;

/// One part's map as an image.
struct Unrolled {
    int width = 0, height = 0;
    std::vector<float> distance;   ///< below the superquadric, model units, or one of k_no_hit, k_cap, k_paper
    std::vector<Vec3f> surface{};  ///< beside distance: the point of the surface, model space
};

/// A position on the picture of a map: shares of its width and height, from the left and from above.
struct MapPosition {
    float x = 0, y = 0;
};

/// Four faces around z, and the two that z leaves through above and below the second: 4 side by 3 side pixels.
[[nodiscard]] Unrolled unrolled_central(const model::ModelView& model, std::uint32_t part, int side);
/// The position of the direction from the chart's centre to a point; nothing at the centre itself.
[[nodiscard]] std::optional<MapPosition> position_on_cross(const model::Part& part, Vec3f point);

/// The finest grid, thinned or repeated to a size. @pre the model is normal, width and height are above 0
[[nodiscard]] Unrolled unrolled_normal(const model::ModelView& model, std::uint32_t part, int width, int height);
[[nodiscard]] MapPosition position_on_grid(const paper::MapView& map, shape::SurfaceAnglesf angles);

/// Eq. 22 at a sample of the paper's map, model space; nothing where its ray meets no surface.
[[nodiscard]] std::optional<Vec3f> mapped_sample(const paper::MapView& map, std::uint32_t row, std::uint32_t column);

}  // namespace sqmap::app
