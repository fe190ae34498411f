// A cell of a face while it is baked.
#pragma once

#include "bake/central/project.h"

#include <array>
#include <cstddef>
#include <vector>

namespace sqmap::bake {

/// A square of a face.
struct CellSquare {
    int face = 0;
    double s = 0, t = 0;  ///< its corner of least s and t
    double size = 0;

    /// u, v: in the cell, from 0 to 1.
    [[nodiscard]] FacePoint at(double u, double v) const { return {face, s + size * u, t + size * v}; }
    [[nodiscard]] FacePoint middle() const { return {face, s + 0.5 * size, t + 0.5 * size}; }
};

/// A cell and what is known of it before it is encoded.
struct Cell {
    CellSquare square;
    int depth = 0;                    ///< how often a base cell was halved
    std::size_t base_cells_left = 0;  ///< base cells that are baked after this one's
    std::vector<Polygon> footprints;  ///< clipped to the cell, with a border
    std::array<RaySample, 4> corner;  ///< rays at its corners, shared with its neighbours: s fastest
};

}  // namespace sqmap::bake
