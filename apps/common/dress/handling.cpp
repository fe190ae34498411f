#include "common/dress/handling.h"

#include "sqmap/device/path.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace sqmap::app {
namespace {

constexpr double k_hover = 0.6;     // s: the filter's ramp, and what comes before it
constexpr double k_tick = 1e-3;     // s
constexpr double k_instant = 1e-9;  // s, of rounding

std::string words(const char* what, double at)
{
    char text[80];
    std::snprintf(text, sizeof text, "a %s at %g s never came: it ended before", what, at);
    return text;
}

}  // namespace

std::uint32_t nearest_vertex(const sim::Cloth& cloth, Vec3d position)
{
    const auto at = cloth.positions();
    std::uint32_t nearest = 0;
    for (std::uint32_t i = 1; i < at.size(); ++i)
        if (norm_sq(at[i] - position) < norm_sq(at[nearest] - position)) nearest = i;
    return nearest;
}

Handling::Handling(const GarmentFile& file, const std::string& name, std::span<const sim::Collider> solids, const FindBone& bone)
    : file_(&file)
{
    for (const PinEvent& pin : file.pins) {
        try {
            bones_.push_back(bone(pin.bone));
        } catch (const GarmentFileError& e) {
            throw GarmentFileError(name + ": pin: 'bone' " + e.what());
        }
    }
    pinned_.resize(bones_.size());
    if (file.pulls.empty()) return;
    tool_ = std::make_unique<ClothTool>(solids);
    // As a path is: no motors of its own, so that the filter's own limits hold.
    const device::PathDevice path("pull", {{}}, 1 / k_tick);
    filter_ = std::make_unique<haptic::SafetyFilter>(device::safety_limits(path.capabilities(), k_tick), haptic::SafetyOptions{});
}

void Handling::before(sim::Cloth& cloth, double time, double dt, std::span<const sim::Collider> solids)
{
    const double start = time - dt;
    // An event that is listed for a time happens in the first step that begins there or later.
    const auto now = [&](double at) { return at <= start + k_instant && at > start - dt + k_instant; };
    for (const SeamEvent& e : file_->seam_events) {
        if (!now(e.at)) continue;
        for (std::size_t s = 0; s < cloth.seams(); ++s)
            if (file_->garment.seams[s].name == e.seam) e.sew ? cloth.sew(s) : cloth.cut(s);
    }
    for (std::size_t k = 0; k < file_->pins.size(); ++k) {
        const PinEvent& pin = file_->pins[k];
        std::vector<std::uint32_t>& nodes = pinned_[k];
        if (now(pin.at)) {
            const std::uint32_t nearest = nearest_vertex(cloth, pin.near);
            nodes.clear();
            for (std::uint32_t i = 0; i < cloth.size(); ++i)
                if (i == nearest || norm(cloth.positions()[i] - cloth.positions()[nearest]) <= pin.radius) nodes.push_back(i);
            cloth.pin(nodes, bones_[k], bones_[k] < solids.size() ? solids[bones_[k]].previous : sqmap::Pose{});
        }
        if (now(pin.until)) cloth.unpin(nodes);
    }
    if (holding_ != nullptr && start >= holding_->until - k_instant) {
        cloth.release();
        holding_ = nullptr;
    }
    for (const Pull& p : file_->pulls)
        if (time > p.at - k_hover && start < p.until - k_instant) {
            pull(cloth, p, time, dt, solids);
            break;
        }
}

void Handling::pull(sim::Cloth& cloth, const Pull& p, double time, double dt, std::span<const sim::Collider> solids)
{
    const double start = time - dt;
    if (holding_ == nullptr && start >= p.at - k_instant) {
        const std::uint32_t nearest = nearest_vertex(cloth, p.near);
        grabbed_ = dragged_ = cloth.positions()[nearest];
        cloth.grasp(nearest, p.radius, grabbed_, ClothTool::k_stiffness);
        holding_ = &p;
        pulls_.push_back({{"at", p.at},
                          {"vertex", nearest},
                          {"most_cloth_N", 0.0},
                          {"most_body_N", 0.0},
                          {"most_asked_N", 0.0},
                          {"most_sent_N", 0.0},
                          {"tip_behind_m", 0.0}});
    }
    const bool holds = holding_ == &p;
    if (!holds) grabbed_ = dragged_ = cloth.positions()[nearest_vertex(cloth, p.near)];
    const ToolScene scene = tool_->scene(solids, holds ? &cloth : nullptr, dragged_, dragged_);
    const int ticks = std::max(1, static_cast<int>(std::lround(dt / k_tick)));
    for (int k = 1; k <= ticks; ++k) {
        const double at = start + k * dt / ticks;
        sqmap::Pose device;
        device.translation = grabbed_ + (holds ? std::clamp((at - p.at) / (p.until - p.at), 0.0, 1.0) : 0.0) * p.by;
        const ToolForces forces = tool_->tick(scene, device, dt / ticks);
        const haptic::Wrench commanded{forces.commanded(), {}};
        haptic::Wrench sent;
        (void)filter_->tick(
            {.time = at, .sample_time = at, .sequence = ++sequence_, .poses = {&device, 1}, .commanded = {&commanded, 1}},
            {&sent, 1});
        dragged_ = forces.tip;
        if (!holds) continue;
        nlohmann::json& log = pulls_.back();
        const auto keep_max = [&](const char* key, double value) { log[key] = std::max(log[key].get<double>(), value); };
        keep_max("most_cloth_N", norm(forces.cloth));
        keep_max("most_body_N", norm(forces.body));
        keep_max("most_asked_N", norm(commanded.force));
        keep_max("most_sent_N", norm(sent.force));
        keep_max("tip_behind_m", norm(forces.tip - forces.device));
        log["last_cloth_N"] = norm(forces.cloth);
    }
    if (holds) cloth.drag(dragged_);
}

std::vector<std::string> Handling::never_came(double until) const
{
    std::vector<std::string> out;
    const auto late = [&](const char* what, double at) {
        if (!(at < until - k_instant)) out.push_back(words(what, at));
    };
    for (const SeamEvent& e : file_->seam_events) late(e.sew ? "sewing" : "cut", e.at);
    for (const PinEvent& pin : file_->pins) late("pin", pin.at);
    for (const Pull& p : file_->pulls) late("pull", p.at);
    return out;
}

}  // namespace sqmap::app
