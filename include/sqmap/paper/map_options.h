// What the paper lets one choose of a map along normals (section 4.1). Plain data: any number of threads may read it.
#pragma once

#include "sqmap/model/normal_map.h"

#include <cstdint>

namespace sqmap::bake {

/// How a map is smoothed, weights over samples within the radius: binomial coefficients, all alike, or a Gaussian whose standard
/// deviation is half the radius.
enum class SmoothingKernel { Binomial, Box, Gaussian };

/// Samples of layer 2 a part, along eta and along omega.
struct GridSize {
    int rows = 0, columns = 0;  ///< eta_d and omega_d; 0: as many as the target error needs

    /// False: the grid follows from the target error.
    [[nodiscard]] constexpr bool is_chosen() const { return rows > 0; }
};

/// Lengths are relative to the superquadric's largest semi-axis.
struct NormalMapOptions {
    double target_error = 2e-3;  ///< bounds the 99th percentile of what linear interpolation misses within one sheet
    int min_level = 4;           ///< finest grid at least 2^level + 1 by 2^(level + 1)
    int max_level = 7;           ///< and at most
    GridSize grid{};             ///< instead of levels: 5 to 4097 rows, 8 to 8192 columns; see is_storable
    /// A_S of section 4.2, 0 to 5: layer 2 is coarser than layer 3 by 2^A_S along each axis. Maps of few samples, whose grid is
    /// not chosen, take less: the base grid keeps 5 rows at least.
    int subdivisions = 1;
    double offset_constant = 1.5;  ///< a_N of eq. 12
    /// Eq. 12 takes the greatest gradient within so many samples of a minimum, 0 to 8; 0: its own, as printed: next to nothing.
    int offset_radius = 1;
    int smoothing_radius = 1;  ///< of the smoothed map's kernel, in base samples, 0 to 8; 0: none
    SmoothingKernel smoothing_kernel = SmoothingKernel::Binomial;
    bool corrections = true;            ///< step 3
    bool gaps = true;                   ///< openings behind the first surface (beyond the paper)
    double correction_threshold = 0.1;  ///< vertices closer to the map than this share of target_error add nothing
    double jump_slope = 1.5;            ///< samples whose distances differ by more than this per length are probed for a jump
};

/// A chosen grid, subdivided, is within the format's limits.
[[nodiscard]] constexpr bool is_storable(const NormalMapOptions& options)
{
    const std::int64_t rows = options.grid.rows, columns = options.grid.columns;
    return ((rows - 1) << options.subdivisions) < model::k_max_map_rows &&
           (columns << options.subdivisions) <= model::k_max_map_columns;
}

}  // namespace sqmap::bake
