// The paper's force on a paper model (section 6). Plain data: any number of threads may read it.
#pragma once

#include "sqmap/haptic/zone.h"

namespace sqmap::paper {

/// The paper's force: each contact's spring by eqs. 21, 26 and 32 on the smoothed map of a paper model, averaged over the zone.
[[nodiscard]] inline haptic::ZoneOptions with_paper_force(haptic::ZoneOptions options)
{
    options.averaging = haptic::Averaging::Patch;
    options.shading = haptic::Shading::Mean;
    options.entry_depth = 0;
    options.smoothed_map = true;
    return options;
}

}  // namespace sqmap::paper
