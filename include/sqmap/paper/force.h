// The paper's force on a paper model (section 6), and balls that feel it. Plain data: any number of threads may read it.
#pragma once

#include "sqmap/haptic/tool.h"
#include "sqmap/haptic/zone.h"
#include "sqmap/mesh/shapes.h"

namespace sqmap::paper {

/// The paper's force: each contact's spring by eqs. 21, 26 and 32 on the smoothed map of a paper model, averaged over the zone,
/// and nothing that blends it over time. With Projector::Printed the depth is eq. 21's, |S - D(P_M)|, on the map of the zone's
/// layer; with the other projectors that to the smoothed surface about the foot. Projector, openings, pruning and
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

/// Makes the tool a ball of this radius, m, as its force can feel one: the smoothed map of a paper model gives forces at points
/// alone, so under tool.force.smoothed_map these are 162 points of the ball's surface. Radius 0: a point.
/// @throw std::bad_alloc
inline void take_ball(haptic::ToolDescription& tool, double radius)
{
    tool.ball_radius = radius;
    tool.shape = radius > 0 ? haptic::ToolShape::Ball : haptic::ToolShape::Point;
    if (!tool.force.smoothed_map || tool.shape == haptic::ToolShape::Point) return;
    tool.shape = haptic::ToolShape::Surface;
    tool.points = mesh::sphere(radius, 2).vertices;
}

}  // namespace sqmap::paper
