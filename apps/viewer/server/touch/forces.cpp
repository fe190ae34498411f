#include "viewer/server/touch/forces.h"

#include "sqmap/model/doubt.h"
#include "viewer/server/touch/tool.h"

#include <algorithm>
#include <limits>
#include <span>

namespace sqmap::viewer {
namespace {

constexpr double k_static = 1.33;  // mu_static over mu_dynamic

query::Layer layer_of(query::Layer layer, haptic::Averaging averaging, bool doubtful)
{
    if (doubtful) return query::Layer::Exact;
    if (layer != query::Layer::Auto) return layer;
    return averaging == haptic::Averaging::Patch ? query::Layer::Three : query::Layer::Exact;
}

}  // namespace

Live live_of(const Settings& s, std::uint32_t number) { return {s.layer, s.stiffness, s.damping, s.friction, number}; }

Forces::Forces(std::vector<ObjectPtr> objects, const Settings& settings) : objects_(std::move(objects))
{
    haptic::ZoneOptions zone{
        .stiffness = settings.stiffness, .damping = settings.damping, .tangential_stiffness = settings.stiffness};
    const bool held = settings.tool == ToolKind::Mesh && settings.tool_object < objects_.size();
    if (settings.tool == ToolKind::Ball || (settings.tool == ToolKind::Mesh && !held)) {
        zone.averaging = settings.smoothing > 0 ? haptic::Averaging::Stencil : haptic::Averaging::Ball;
        zone.smoothing = haptic::ball_of(settings.tool_radius);
        if (settings.smoothing > 0) {
            zone.smoothing = {};
            zone.smoothing.radius = settings.smoothing;
        }
        probe_ = std::make_unique<query::Probe>(haptic::stencil_points(zone.smoothing));
    } else {
        Tool tool = make_tool(settings, held ? objects_[settings.tool_object].get() : nullptr);
        weights_ = std::move(tool.weights);
        probe_ = std::make_unique<query::Probe>(tool.mesh.vertices);
    }
    doubtful_ = std::any_of(objects_.begin(), objects_.end(),
                            [](const ObjectPtr& object) { return model::is_doubtful(object->metres.measured); });
    zone.layer = layer_of(settings.layer, zone.averaging, doubtful_);
    const haptic::Zone whole{.probe = probe_.get(),
                             .weights = weights_,
                             .radius = settings.zone > 0 ? settings.zone : std::numeric_limits<double>::infinity(),
                             .options = zone};
    if (settings.texture > 0)
        texture_ = haptic::gaussian_texture({.amplitude = settings.texture, .wavelength = 0.003}, texture_values_);
    haptic::Material material{.mu_static = k_static * settings.friction, .mu_dynamic = settings.friction};
    if (settings.texture > 0) material.texture = &texture_;
    for (const ObjectPtr& object : objects_) {
        if (held && object == objects_[settings.tool_object]) continue;
        solids_.push_back({.model = &object->metres, .pose = object->pose(), .material = material});
    }
    if (held) objects_[settings.tool_object] = nullptr;
    state_ = std::make_unique<haptic::State>(
        std::span(&whole, 1),
        haptic::StateOptions{.max_contacts = probe_->size(), .max_touched = std::max<std::size_t>(1, solids_.size())});
}

void Forces::adjust(const Live& live) noexcept
{
    haptic::ZoneOptions& zone = state_->options(0);
    zone.layer = layer_of(live.layer, zone.averaging, doubtful_);
    zone.stiffness = zone.tangential_stiffness = live.stiffness;
    zone.damping = live.damping;
    for (haptic::TouchedBody& solid : solids_) {
        solid.material.mu_dynamic = live.friction;
        solid.material.mu_static = k_static * live.friction;
    }
}

haptic::StepResult Forces::step(const ForceInput& input, haptic::Wrench& wrench) noexcept
{
    haptic::StepInput step{.touched = solids_, .poses = {&input.pose, 1}, .twists = {}, .dt = input.dt};
    if (input.has_twist) step.twists = {&input.twist, 1};
    step.degraded = input.degraded;
    return haptic::step(*state_, step, {&wrench, 1});
}

}  // namespace sqmap::viewer
