#include "sqmap/haptic/tool.h"

#include "haptic/stencil.h"
#include "haptic/zone_tick.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sqmap::haptic {

void take_surface(ToolDescription& tool, std::span<const Vec3d> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                  double spacing, bool has_denser)
{
    if (has_denser) tool.denser = DenserSets(vertices, triangles);
    PatchPoints patch = patch_points(vertices, triangles, spacing);
    tool.points = std::move(patch.points);
    tool.weights = std::move(patch.weights);
}

namespace {

/// Sets how contacts are averaged, and a point's or ball's points.
void take_shape(ToolDescription& tool)
{
    ZoneOptions& force = tool.force;
    if (tool.shape == ToolShape::Surface || force.smoothed_map) {
        SQMAP_ASSERT(tool.shape != ToolShape::Ball);
        force.averaging = Averaging::Patch;
        if (tool.shape == ToolShape::Point) tool.points.assign(1, {});
        return;
    }
    const bool is_ball = tool.shape == ToolShape::Ball;
    force.averaging = is_ball ? Averaging::Ball : Averaging::Stencil;
    if (is_ball) {
        const Kernel kernel = force.smoothing.kernel;
        force.smoothing = ball_of(tool.ball_radius);
        force.smoothing.kernel = kernel;
    }
    if (tool.tolerance) force.smoothing.tolerance = *tool.tolerance;
    tool.points = stencil_points(force.smoothing);
}

}  // namespace

Tool::Tool(ToolDescription description) : description_(std::move(description))
{
    ToolDescription& d = description_;
    take_shape(d);
    probe_ = std::make_unique<query::Probe>(d.points);
    if (!d.triangles.empty() && d.shape == ToolShape::Surface && d.first.empty()) {
        surface_ = std::make_unique<query::Probe>(d.points, d.triangles);
    }
    const Zone zone{.probe = probe_.get(),
                    .in_world = !d.first.empty(),
                    .weights = d.weights,
                    .denser = d.denser.points(),
                    .max_touching = d.max_touching,
                    .radius = d.radius > 0 ? d.radius : std::numeric_limits<double>::infinity(),
                    .surface = surface_.get(),
                    .options = d.force};
    zones_.assign(d.first.empty() ? d.zones : d.first.size() - 1, zone);
    for (std::size_t z = 0; z + 1 < d.first.size(); ++z) {
        zones_[z].first = d.first[z];
        zones_[z].count = d.first[z + 1] - d.first[z];
    }
}

State Tool::state(std::size_t max_touched) const
{
    const std::size_t surfaces = surface_ != nullptr ? k_surface_contacts : 0;
    return State(zones_, {.max_contacts = std::max(probe_->size(), description_.denser.max_points()) + surfaces,
                          .max_touched = std::max<std::size_t>(1, max_touched)});
}

}  // namespace sqmap::haptic
