// Pictures of coloured meshes by ray casting.
#pragma once

#include "image.h"
#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace sqmap::app {

/// One mesh of a picture.
struct Layer {
    mesh::Mesh mesh;
    std::vector<Rgb> colours{};           ///< #triangles, linear light
    std::vector<std::uint32_t> groups{};  ///< #triangles, or empty: a line is drawn where the number changes
    bool translucent = false;
};

struct View {
    double azimuth = 35;    ///< degrees about the up axis; 0 looks at the front (from +z where up is y)
    double elevation = 15;  ///< degrees above the horizon
    char up = 'y';          ///< the mesh's upward axis: x, y or z
    int width = 900;
    int height = 700;
    int samples = 3;  ///< rays a pixel along each side
};

/// Shaded picture of the layers, framed to hold them all. Deterministic.
/// @throw std::invalid_argument for no triangles or an empty picture
[[nodiscard]] Image render(const std::vector<Layer>& layers, const View& view);

}  // namespace sqmap::app
