// Where the vertices of a dual surface lie: on the input, on its sharp edges and corners, or where nothing was.
#pragma once

#include "dual_surface.h"
#include "labels.h"
#include "sqmap/mesh/bvh.h"

#include <vector>

namespace sqmap::mesh {

/// What a grid's edge crosses.
enum class Crossed : std::uint8_t { Input, Level, Shell };

struct Positions {
    std::vector<Vec3d> vertices;   ///< #vertices of sheets, then those between
    std::vector<Vec3d> crossings;  ///< #quads
    std::vector<Crossed> kinds;    ///< #quads
    bool has_shells = false;
};

/// What positions are computed from, all in units of the cells.
struct Wrapped {
    const Mesh& soup;
    const Bvh& bvh;
    const WindingNumber& winding;
    const Grid& grid;
    const Labels& labels;
    double thickness;  ///< of shells
};

[[nodiscard]] Positions positions_of(const DualSurface& surface, const Wrapped& wrapped);

}  // namespace sqmap::mesh
