// Pictures of coloured meshes by ray casting.
#pragma once

#include "common/render/image.h"
#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace sqmap::app {

/// One mesh of a picture.
struct Layer {
    mesh::Mesh mesh;
    std::vector<Rgb> colours{};           ///< #triangles * detail^2, linear light
    std::uint32_t detail = 1;             ///< each triangle has detail^2 cells with a colour each, see cell_centre
    std::vector<std::uint32_t> groups{};  ///< #triangles, or empty: a line is drawn where the number changes
    bool translucent = false;
};

/// Barycentric coordinates of a cell's centre, for triangles with detail^2 cells.
[[nodiscard]] std::array<double, 3> cell_centre(std::uint32_t detail, std::uint32_t cell);

struct View {
    double azimuth =
        35;  ///< degrees about the up axis; 0 looks at the front (from +z where up is y, +x where it is z, +y where it is x)
    double elevation = 15;  ///< degrees above the horizon
    Vec3d up{0, 1, 0};      ///< the mesh's upward axis: one of +-x, +-y, +-z
    int width = 900;
    int height = 700;
    int margin = 0;        ///< pixels along the right edge that the subject keeps free
    bool shadows = true;   ///< cast by the key light; off where colours carry numbers
    int samples = 3;       ///< rays a pixel along each side
    int sky_rays = 96;     ///< a vertex, for the light from the sky: less noise, more time
    unsigned threads = 0;  ///< 0: one a core; the picture does not depend on it
};

/// Azimuth from which the mesh looks broadest, turned by 25 degrees so that a side view does not hide its far half.
[[nodiscard]] double broad_azimuth(const mesh::Mesh& mesh, Vec3d up);

/// Shaded picture of the layers, framed to hold them all. Deterministic.
/// @throw std::invalid_argument for no triangles or an empty picture
[[nodiscard]] Image render(const std::vector<Layer>& layers, const View& view);

}  // namespace sqmap::app
