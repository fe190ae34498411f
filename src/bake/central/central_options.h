// How fine a central map is.
#pragma once

#include "model/central_cells.h"

#include <cstdint>

namespace sqmap::bake {

struct CentralOptions {
    double r_max = 1;                  ///< what the shares below are of, model units
    double tolerance = 0.001;          ///< a cell is split while its certified deviation exceeds this share of R_max
    double foreign_tolerance = 0.003;  ///< the same where no surface is the part's own: only verdicts are read there
    double finest = 0.0055;            ///< cells below this share of R_max are not split for their deviation
    double silhouette = 0.0035;        ///< nor below this one where rays of the cell meet different surfaces
    double division = 0.001;           ///< a cell with a silhouette is divided where its rays gain this share of R_max on average
    int max_depth = model::k_max_split_depth;
    std::uint32_t least_base = 8;  ///< the base grid is at least this fine
    std::uint32_t max_base = 32;   ///< and at most this fine
    double offset_constant = 1.5;  ///< a_N of eq. 12
    int smoothing_radius = 1;      ///< of the binomial kernel that smooths the map, in base samples
};

/// Cell sizes that meet a target error, in percent of R_max, as a rule; measured and corrected after. Targets below half a
/// percent start from that: cells that are finer than the surface needs crowd out those that it does.
[[nodiscard]] CentralOptions central_options(double target_error, double r_max);

/// Multiplies the cell sizes by a factor.
void scale(CentralOptions& options, double factor);

}  // namespace sqmap::bake
