// How flat a flat cell is.
#pragma once

namespace sqmap::bake {

/// By how much a cell's planes may miss the surface at its worst sample, model units; at most points it is a tenth.
/// target_error: percent of r_max.
[[nodiscard]] inline double flat_tolerance(double target_error, double r_max)
{
    constexpr double k_flat_share = 0.4;  // of the target error
    return 0.01 * k_flat_share * target_error * r_max;
}

}  // namespace sqmap::bake
