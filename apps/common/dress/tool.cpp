#include "common/dress/tool.h"

#include "sqmap/device/simulated.h"

#include <algorithm>

namespace sqmap::app {
namespace {

haptic::Tool held_point()
{
    haptic::ZoneOptions o;
    o.mode = haptic::Mode::Proxy;
    o.layer = query::Layer::Exact;
    o.stiffness = ClothTool::k_stiffness;
    return haptic::Tool({.force = o, .shape = haptic::ToolShape::Point});
}

}  // namespace

ClothTool::ClothTool(std::span<const sim::Collider> solids) : tool_(held_point())
{
    for (std::size_t i = 0; i < std::min(solids.size(), ToolScene::k_max); ++i) {
        const sim::Collider& solid = solids[i];
        if (solid.model == nullptr) continue;
        if (solid.skin != nullptr) {
            skin_ = i;
            const Vec3d tip{};
            workspace_ = std::make_unique<query::SkinWorkspace>(solid.skin->lattice(), std::span(&tip, 1));
            continue;
        }
        which_.push_back(i);
        solids_.push_back({.model = solid.model, .pose = solid.pose});
    }
    state_ = std::make_unique<haptic::State>(tool_.state(solids_.size()));
}

ToolScene ClothTool::scene(std::span<const sim::Collider> solids, const sim::Cloth* held, Vec3d dragged, Vec3d device)
{
    ToolScene scene;
    for (std::size_t i = 0; i < std::min(solids.size(), ToolScene::k_max); ++i) scene.poses[i] = solids[i].pose;
    if (held != nullptr) {
        scene.holds = true;
        scene.slack = dragged + held->tension() / k_stiffness;
    }
    if (skin_ >= solids.size()) return scene;
    query::SkinContact c;
    scene.on_skin =
        query::query_skin({solids[skin_].model, &solids[skin_].skin->to(), {&device, 1}, {}}, {}, *workspace_, {&c, 1}).contacts >
        0;
    scene.skin_point = c.witness;
    scene.skin_normal = c.normal;
    return scene;
}

ToolForces ClothTool::tick(const ToolScene& scene, const sqmap::Pose& device, double dt, bool degraded) noexcept
{
    for (std::size_t i = 0; i < solids_.size(); ++i) solids_[i].pose = scene.poses[which_[i]];
    haptic::Wrench wrench;
    (void)haptic::step(*state_, {.touched = solids_, .poses = {&device, 1}, .dt = dt, .degraded = degraded}, {&wrench, 1});
    const haptic::ZoneReport& report = state_->report(0);
    const bool touches = (report.status & haptic::k_step_contact) != 0;
    ToolForces forces{
        .device = device.translation, .tip = touches ? report.body.translation : device.translation, .body = wrench.force};
    const double depth = scene.on_skin ? dot(scene.skin_normal, scene.skin_point - device.translation) : 0;
    if (depth > 0) {
        forces.body += k_stiffness * depth * scene.skin_normal;
        forces.tip += depth * scene.skin_normal;
    }
    if (scene.holds) forces.cloth = k_stiffness * (scene.slack - forces.tip);
    return forces;
}

std::unique_ptr<device::Device> simulated_hand(const Pull& pull, const std::string& profile)
{
    device::SimulatedOptions options{.script =
                                         [](const void* context, double time, std::size_t) noexcept {
                                             const Pull& p = *static_cast<const Pull*>(context);
                                             const double share = std::clamp((time - p.at) / (p.until - p.at), 0.0, 1.0);
                                             device::HandTarget target;
                                             target.pose.translation = p.near + share * p.by;
                                             if (share > 0 && share < 1) target.twist.linear = p.by / (p.until - p.at);
                                             return target;
                                         },
                                     .script_context = &pull};
    options.hand = device::hand_profile(profile);
    return std::make_unique<device::SimulatedDevice>(options);
}

LiveTool::LiveTool(std::span<const sim::Collider> solids, device::Device& device, Vec3d at) : tool_(solids), at_(at)
{
    show(solids, nullptr, {});
    servo_.emplace(device, device::ServoOptions{}, tick, this);
}

LiveTool::~LiveTool() = default;

std::uint32_t LiveTool::tick(void* context, const device::TickInput& input, std::span<device::Wrench> wrenches) noexcept
{
    LiveTool& self = *static_cast<LiveTool*>(context);
    (void)self.scene_.take();
    sqmap::Pose pose = input.sample.poses[0];
    pose.translation += self.at_;
    ToolForces forces = self.tool_.tick(self.scene_.value(), pose, input.dt, input.degraded);
    forces.buttons = input.sample.buttons;
    if (!wrenches.empty()) wrenches[0].force = forces.commanded();
    self.forces_.put(forces);
    return 0;
}

void LiveTool::show(std::span<const sim::Collider> solids, const sim::Cloth* held, Vec3d dragged)
{
    scene_.put(tool_.scene(solids, held, dragged, forces().device));
    drain();
}

const ToolForces& LiveTool::forces()
{
    (void)forces_.take();
    return forces_.value();
}

void LiveTool::drain()
{
    device::ServoTick tick;
    while (servo_ && servo_->next(tick)) {
        ++ticks_;
        max_commanded_ = std::max(max_commanded_, norm(tick.commanded[0].force));
        max_sent_ = std::max(max_sent_, norm(tick.sent[0].force));
        gone_ = !tick.connected;
    }
}

}  // namespace sqmap::app
