// Cells whose rays do not all meet the same surfaces: a certified band, planes in it, and perhaps a line that divides them.
#pragma once

#include "bake/central/cell.h"
#include "bake/central/central_options.h"
#include "model/central_cells.h"

#include <array>
#include <cstdint>
#include <map>
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

/// The mixed cells of one part's maps for several bases, whose squares coincide: what describes a square is found once. Not
/// thread-safe.
class MixedCells {
public:
    /// projection, options: outlive it. w_step: of the stored samples.
    MixedCells(const Projection& projection, const CentralOptions& options, double w_step)
        : projection_(projection), options_(options), w_step_(w_step)
    {
    }

    /// @pre some footprint of the cell is not buried
    [[nodiscard]] const MixedCell& at(const Cell& cell);

private:
    using Square = std::array<long, 4>;  ///< face, squares of that size along it, column and row

    const Projection& projection_;
    const CentralOptions& options_;
    double w_step_;
    std::map<Square, MixedCell> known_;
};

}  // namespace sqmap::bake
