#include "viewer/server/scene/displacement.h"

#include "common/render/png.h"
#include "sqmap/math/assert.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/shape/surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::viewer {
namespace {

constexpr double k_pi = std::numbers::pi;

}  // namespace

Displacement displacement_of(const Object& object, const Parts& parts, std::uint32_t part, int width, int height)
{
    SQMAP_ASSERT(part < parts.superquadrics.size());
    Displacement out{.width = width, .height = height, .below = {}};
    out.below.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), -1.f);
    const mesh::Mesh own = part_mesh(object, parts, part);
    if (own.triangles.empty()) return out;
    const mesh::Bvh bvh(own);
    const double metres = object.metres_per_model_unit();
    std::vector<mesh::Bvh::Crossing> crossings;
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            // A ray within rounding of an edge is computed again beside it, within its texel.
            for (const double nudge : {0.5, 0.43, 0.59}) {
                const auto at = shape::surface_point(parts.superquadrics[part],
                                                     shape::SurfaceAngles<double>{k_pi / 2 - k_pi * (row + nudge) / height,
                                                                                  -k_pi + 2 * k_pi * (column + nudge) / width});
                if (!bvh.ray_crossings(at.point, -1.0 * at.normal, crossings)) continue;
                if (!crossings.empty()) {
                    const auto below = static_cast<float>(metres * crossings.front().t);
                    out.below[static_cast<std::size_t>(row * width + column)] = below;
                    out.max = std::max(out.max, below);
                }
                break;
            }
        }
    return out;
}

std::string displacement_png(const Displacement& map)
{
    std::vector<unsigned char> texels(4 * map.below.size());
    for (std::size_t i = 0; i < map.below.size(); ++i) {
        const bool there = map.below[i] >= 0;
        const auto grey = static_cast<unsigned>(
            there && map.max > 0 ? std::lround(65535.0 * static_cast<double>(map.below[i]) / static_cast<double>(map.max)) : 0);
        texels[4 * i] = static_cast<unsigned char>(grey >> 8);
        texels[4 * i + 1] = static_cast<unsigned char>(grey & 255);
        texels[4 * i + 2] = texels[4 * i + 3] = there ? 255 : 0;
    }
    return app::png_bytes({.width = static_cast<std::uint32_t>(map.width),
                           .height = static_cast<std::uint32_t>(map.height),
                           .format = app::PngFormat::GreyAlpha16,
                           .bytes = texels});
}

Sheet superquadric_sheet(const Object& object, const shape::Superquadricd& superquadric, int along, int around)
{
    Sheet out;
    for (int row = 0; row <= along; ++row)
        for (int column = 0; column <= around; ++column) {
            const auto at = shape::surface_point(
                superquadric, shape::SurfaceAngles<double>{k_pi / 2 - k_pi * row / along, -k_pi + 2 * k_pi * column / around});
            out.positions.push_back(object.world(at.point));
            out.normals.push_back(cast<float>(at.normal));
            out.uv.insert(out.uv.end(), {static_cast<float>(column) / static_cast<float>(around),
                                         static_cast<float>(row) / static_cast<float>(along)});
        }
    const auto index = [&](int row, int column) { return static_cast<std::uint32_t>(row * (around + 1) + column); };
    for (int row = 0; row < along; ++row)
        for (int column = 0; column < around; ++column) {
            // Counter-clockwise from outside: rows go down, columns eastwards. Poles have no width.
            if (row > 0)
                out.corners.insert(out.corners.end(), {index(row, column), index(row + 1, column), index(row, column + 1)});
            if (row + 1 < along)
                out.corners.insert(out.corners.end(),
                                   {index(row, column + 1), index(row + 1, column), index(row + 1, column + 1)});
        }
    return out;
}

}  // namespace sqmap::viewer
