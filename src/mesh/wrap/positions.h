// Positions of the vertices of a dual surface: on the input, on its sharp edges and corners, or in empty space.
#pragma once

#include "dual_surface.h"
#include "labels.h"

#include <vector>

namespace sqmap::mesh {

/// The surface that an edge of the grid crosses.
enum class Crossed : std::uint8_t { Input, Level, Shell };

struct Positions {
    std::vector<Vec3d> vertices;   ///< #vertices of sheets, then those between
    std::vector<Vec3d> crossings;  ///< #quads
    std::vector<Crossed> kinds;    ///< #quads
    bool has_shells = false;
};

/// The input of the positions.
struct Labelled {
    const Source& source;
    const Grid& grid;
    const Labels& labels;
};

[[nodiscard]] Positions positions_of(const DualSurface& surface, const Labelled& labelled);

}  // namespace sqmap::mesh
