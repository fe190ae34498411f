// One part on its way to the model.
#pragma once

#include "bake/central_map.h"
#include "bake/parts/caps.h"
#include "sqmap/fit/fit.h"

#include <cstdint>
#include <vector>

namespace sqmap::bake {

struct PartWork {
    std::vector<std::uint32_t> triangles;
    std::vector<std::uint32_t> ordered;  ///< the same, by place in the canonical frame: no sample depends on the file's frame
    std::vector<CapTriangle> caps;
    fit::FitReport fit;
    double area = 0;
    double solid_volume = 0;  ///< enclosed by patch and caps, model units cubed
    Vec3f centre;             ///< of the central projection
    double q2_share = 0;      ///< of the area: hidden from the projection by other surface
    CentralMapData map;
};

/// Corners of the patch and its caps.
[[nodiscard]] inline std::vector<Vec3d> corners_of(const mesh::Mesh& mesh, const PartWork& part)
{
    std::vector<Vec3d> points;
    for (const std::uint32_t t : part.triangles)
        for (const std::uint32_t v : mesh.triangles[t]) points.push_back(mesh.vertices[v]);
    for (const CapTriangle& t : part.caps) points.insert(points.end(), t.begin(), t.end());
    return points;
}

}  // namespace sqmap::bake
