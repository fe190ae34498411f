// The paper's force on a paper model (section 6). Plain data: any number of threads may read it.
#pragma once

#include "sqmap/haptic/zone.h"

namespace sqmap::paper {

/// The paper's force: each contact's spring by eqs. 21, 26 and 32 on the smoothed map of a paper model, averaged over the zone,
/// and nothing that blends it over time. With Projector::Printed the depth is eq. 21's, |S - D(P_M)|, on the map of the zone's
/// layer; with the other projectors that of the tangent plane at the foot, on the finest map. Projector, openings, pruning and
/// closest-point steps are the model's own options (Reading::set_options); layer, k_L (ZoneOptions::gate), eq. 12's offset and
/// stiffness the zone's; the friction the material's.
[[nodiscard]] inline haptic::ZoneOptions with_paper_force(haptic::ZoneOptions options)
{
    options.averaging = haptic::Averaging::Patch;
    options.shading = haptic::Shading::Mean;
    options.entry_depth = 0;
    options.smoothed_map = true;
    options.blend_time = 0;
    return options;
}

/// The friction that belongs to it: eq. 33, with the material's f_c and k_f.
[[nodiscard]] inline haptic::Material with_paper_friction(haptic::Material material)
{
    material.friction = Friction::Paper;
    return material;
}

}  // namespace sqmap::paper
