// Cells whose rays do not all meet the same surfaces: a certified band, planes in it, and perhaps a line that divides them.
#pragma once

#include "bake/central/cell.h"
#include "bake/central/central_options.h"
#include "model/central_cells.h"

#include <array>
#include <cstdint>
#include <optional>

namespace sqmap::bake {

/// Planes through a ray's crossings, each w at (s, t) and its slopes.
struct RayPlanes {
    int count = 0;
    double s = 0, t = 0;
    std::array<model::ChartPlane<double>, model::k_max_sheets> plane{};

    [[nodiscard]] double w_at(int j, FacePoint at) const
    {
        const model::ChartPlane<double>& p = plane[static_cast<std::size_t>(j)];
        return p.w + (at.s - s) * p.ws + (at.t - t) * p.wt;
    }
};

/// A line across a cell, and the planes on the other side of it.
struct Division {
    std::uint32_t from = 0, to = 0;  ///< codes of border points; the first planes hold left of the direction between them
    RayPlanes second;
};

struct MixedCell {
    double lo = 0, hi = 0;  ///< w of every surface over the cell, without room for rounding
    RayPlanes first;
    std::optional<Division> division;
};

/// w_step: of the stored samples. @pre some footprint of the cell is not buried
[[nodiscard]] MixedCell mixed_cell(const Projection& projection, const Cell& cell, const CentralOptions& options, double w_step);

}  // namespace sqmap::bake
