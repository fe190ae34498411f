#include "viewer/server/touch/forces.h"

#include "sqmap/haptic/stiffness.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/model/model.h"
#include "sqmap/paper/force.h"
#include "sqmap/paper/model.h"
#include "viewer/server/scene/meetings.h"
#include "viewer/server/touch/tool.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sqmap::viewer {
namespace {

constexpr double k_static = 1.33;  // mu_static over mu_dynamic
constexpr double k_stiffen = 0.1;  // s, time constant in which a spring under load takes a new stiffness
constexpr double k_hold = 0.005;   // m of the hand's path in which a proxy takes another side

}  // namespace

bool has_paper_force(std::span<const ObjectPtr> objects)
{
    return std::all_of(objects.begin(), objects.end(),
                       [](const ObjectPtr& object) { return object == nullptr || paper::is_paper(object->view); });
}

Live live_of(const Settings& s, std::uint32_t number)
{
    return {s.layer, s.tolerance, s.stiffness, s.damping, s.law, s.friction, s.f_c, s.k_f, number};
}

Forces::Forces(std::vector<ObjectPtr> objects, const Settings& settings) : objects_(std::move(objects))
{
    haptic::ToolDescription description{
        .force = {.stiffness = settings.stiffness, .damping = settings.damping, .tangential_stiffness = settings.stiffness},
        .radius = settings.zone};
    haptic::ZoneOptions& zone = description.force;
    zone.gate = settings.gate;
    const bool held = settings.tool == ToolKind::Mesh && settings.tool_object < objects_.size();
    const ObjectPtr tool_object = held ? std::exchange(objects_[settings.tool_object], nullptr) : nullptr;
    if (settings.paper_force && has_paper_force(objects_)) {
        paper_force_ = true;
        zone = paper::with_paper_force(zone);
        zone.offset = settings.offset;
    } else if (settings.proxy) {
        proxy_ = true;
        zone.mode = haptic::Mode::Proxy;
        zone.side_path = k_hold;
    }
    if (settings.tool != ToolKind::Ball && (settings.tool == ToolKind::Hand || held)) {
        Tool tool = make_tool(settings, tool_object.get());
        description.weights = std::move(tool.weights);
        const std::vector<query::ProbeTriangle>& triangles = tool.mesh.triangles;
        if (settings.edges && query::find_fault(tool.mesh.vertices, triangles).kind == query::TriangleFault::Kind::None)
            description.triangles = triangles;
        description.points = std::move(tool.mesh.vertices);
    } else if (settings.smoothing > 0) {
        description.shape = haptic::ToolShape::Point;
        zone.smoothing.radius = settings.smoothing;
    } else {
        paper::take_ball(description, settings.tool_radius);
    }
    for (const ObjectPtr& object : objects_)
        doubtful_ = doubtful_ || (object != nullptr && model::is_doubtful(object->metres.measured));
    tool_ = haptic::Tool(std::move(description));
    patch_ = tool_.zones().front().options.averaging == haptic::Averaging::Patch;
    if (settings.texture > 0)
        texture_ = haptic::gaussian_texture({.amplitude = settings.texture, .wavelength = 0.003}, texture_values_);
    read_objects(settings.paper);
    for (haptic::TouchedBody& solid : solids_)
        if (settings.texture > 0) solid.material.texture = &texture_;
    state_ = std::make_unique<haptic::State>(tool_.state(solids_.size()));
    force_limit_ = settings.force_limit;
    adjust(live_of(settings, 0));
    state_->options(0).stiffness = state_->options(0).tangential_stiffness = wanted_;
}

/// A paper model is read by a reading of this tool's own: the object's is shared with all that look at it.
void Forces::read_objects(const paper::QueryOptions& options)
{
    metres_.reserve(objects_.size());
    surfaces_.reserve(objects_.size());
    for (const ObjectPtr& object : objects_) {
        if (object == nullptr) continue;
        if (const paper::ModelView* model = object->model->paper()) {
            readings_.push_back(std::make_unique<paper::Reading>(*model, options));
            metres_.push_back(haptic::in_metres(readings_.back()->view(), object->metres_per_unit));
        } else {
            metres_.push_back(object->metres);
        }
        solids_.push_back({.model = &metres_.back(), .pose = object->pose()});
        if (tool_.zones().front().surface == nullptr) continue;
        if (std::optional<query::Probe> surface = solid_of(*object))
            solids_.back().surface = &surfaces_.emplace_back(std::move(*surface));
    }
}

query::Layer Forces::layer_of(const Live& live) const noexcept
{
    if (paper_force_ && (!live.layer || *live.layer == query::Layer::Auto)) return query::Layer::Three;
    if (doubtful_ && !paper_force_) return query::Layer::Exact;
    if (!live.layer) return patch_ ? query::Layer::Three : query::Layer::Exact;
    if (*live.layer != query::Layer::Auto) return *live.layer;
    // One layer for all: the most careful of theirs. Superquadrics alone push from outside the surface.
    query::Layer layer = query::Layer::Two;
    for (const haptic::TouchedBody& solid : solids_)
        layer = std::max(layer, query::chosen_layer(*solid.model, {.layer = query::Layer::Auto, .tolerance = live.tolerance}));
    return layer;
}

void Forces::adjust(const Live& live) noexcept
{
    haptic::ZoneOptions& zone = state_->options(0);
    zone.layer = layer_of(live);
    wanted_ = live.stiffness;
    zone.damping = live.damping;
    for (haptic::TouchedBody& solid : solids_) {
        haptic::Material& material = solid.material;
        material.friction = live.law;
        material.mu_dynamic = live.friction;
        material.mu_static = k_static * live.friction;
        material.f_c = live.f_c;
        material.k_f = live.k_f;
    }
}

double Forces::stiffen(double dt) noexcept
{
    haptic::ZoneOptions& zone = state_->options(0);
    const double before = zone.stiffness;
    if (before == wanted_) return before;
    // Hardly stiffer than wanted is as wanted.
    const double next = before + std::clamp(dt / k_stiffen, 0., 1.) * (wanted_ - before);
    zone.stiffness = zone.tangential_stiffness = std::abs(next - wanted_) < 1e-3 * wanted_ ? wanted_ : next;
    return before;
}

haptic::StepResult Forces::step(const ForceInput& input, haptic::Wrench& wrench) noexcept
{
    haptic::StepInput step{.touched = solids_, .poses = {&input.pose, 1}, .twists = {}, .dt = input.dt};
    if (input.has_twist) step.twists = {&input.twist, 1};
    step.degraded = input.degraded;
    const double before = stiffen(input.dt), now = state_->options(0).stiffness;
    const haptic::StepResult result = haptic::step(*state_, step, {&wrench, 1});
    const haptic::ZoneReport& zone = report();
    // The spring is stretched by push / now, and was before.
    const double gained = haptic::spring_energy(zone.push, force_limit_, now) -
                          haptic::spring_energy(before / now * zone.push, force_limit_, before);
    stiffened_ = now > before ? gained : 0;
    if (!input.degraded) found_ = {proxy_ ? zone.depth : zone.deepest, result.contacts, zone.point, zone.normal, {}};
    found_.body = zone.body;
    return result;
}

}  // namespace sqmap::viewer
