// A part's map as a displacement texture: eq. 11 on its superquadric, sampled as the paper samples (eqs. 8 and 9).
#pragma once

#include "viewer/server/scene/object.h"

#include <string>
#include <vector>

namespace sqmap::viewer {

/// Texel (column, row): its middle is at omega = -pi + 2 pi (column + 1/2) / width, eta = pi / 2 - pi (row + 1/2) / height.
struct Displacement {
    int width = 0, height = 0;
    std::vector<float> below;  ///< m from the superquadric along its inward normal to the part's own surface; below 0: none there
    float max = 0;             ///< m, the largest
};

/// Cost: a ray a texel. @pre part < #superquadrics of parts
[[nodiscard]] Displacement displacement_of(const Object& object, const Parts& parts, std::uint32_t part, int width, int height);

/// A PNG of grey and alpha, 16 bits each. Grey: 65535 is map.max; alpha: 0 where there is no surface.
[[nodiscard]] std::string displacement_png(const Displacement& map);

/// The superquadric as a grid over the same angles: positions and normals in the world, m; texture coordinates.
struct Sheet {
    std::vector<Vec3f> positions, normals;
    std::vector<float> uv;
    std::vector<std::uint32_t> corners;
};
[[nodiscard]] Sheet superquadric_sheet(const Object& object, const shape::Superquadricd& superquadric, int along, int around);

}  // namespace sqmap::viewer
