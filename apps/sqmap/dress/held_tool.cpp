#include "dress/held_tool.h"

#include "sqmap/device/open.h"
#include "three_numbers.h"

#include <algorithm>
#include <cstdio>
#include <thread>

namespace sqmap::app {
namespace {

constexpr double k_reach = 0.05;  ///< m, from the tip to what it grasps

}  // namespace

HeldTool::HeldTool(const std::string& spec_text, const std::string& at, std::span<const sim::Collider> solids,
                   std::vector<Worn>& worn)
    : worn_(&worn)
{
    const std::optional<Vec3d> position = at.empty() ? Vec3d{} : three_numbers(at);
    if (!position) throw device::DeviceError("--tool-at " + at + ": a position is three numbers, as in 0,1.2,0.3");
    const device::DeviceSpec spec = device::parse_spec(spec_text);
    std::size_t pulls = 0;
    for (const Worn& w : worn) pulls += w.file.pulls.size();
    if (spec.kind == "simulated") {
        spec.allow({"hand"});
        if (pulls != 1)
            throw device::DeviceError("--device simulated: its hand follows the one 'pull' of the garments, which have " +
                                      std::to_string(pulls) + "\n  cure: list one, or leave --device out");
        for (Worn& w : worn)
            if (!w.file.pulls.empty()) {
                script_ = w.file.pulls.front();
                w.file.pulls.clear();
            }
        device_ = simulated_hand(*script_, spec.text("hand", "pen"));
    } else {
        if (pulls > 0)
            throw device::DeviceError(
                "--device " + spec_text +
                ": a garment has a 'pull', which is a tool's too\n  cure: take it out, or leave --device out");
        device_ = device::open_device(spec_text);
    }
    std::printf("%s; %s\n", device_->capabilities().name.c_str(),
                script_ ? "its hand follows the pull" : "its first button grasps the nearest vertex");
    tool_.emplace(solids, *device_, *position);
    begin_ = std::chrono::steady_clock::now();
}

void HeldTool::before(double time)
{
    std::this_thread::sleep_until(begin_ + std::chrono::duration<double>(time));
    const ToolForces& forces = tool_->forces();
    const bool wants = script_ ? time >= script_->at && time < script_->until : (forces.buttons & 1u) != 0;
    if (wants && held_ == nullptr) {
        double least = script_ ? INFINITY : k_reach;
        for (Worn& w : *worn_) {
            const std::uint32_t v = nearest_vertex(w.cloth, forces.tip);
            const double distance = norm(w.cloth.positions()[v] - forces.tip);
            if (!(distance < least)) continue;
            least = distance;
            held_ = &w.cloth;
            vertex_ = v;
        }
        if (held_ != nullptr) {
            held_->grasp(vertex_, script_ ? script_->radius : Pull{}.radius, forces.tip, ClothTool::k_stiffness);
            ++grasps_;
        }
    } else if (!wants && held_ != nullptr) {
        held_->release();
        held_ = nullptr;
    }
    dragged_ = forces.tip;
    if (held_ != nullptr) held_->drag(dragged_);
    max_cloth_ = std::max(max_cloth_, norm(forces.cloth));
    max_body_ = std::max(max_body_, norm(forces.body));
}
nlohmann::json HeldTool::report(double time) const
{
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin_;
    return {{"device", device_->capabilities().name},
            {"simulated", device_->capabilities().simulated},
            {"ticks", tool_->ticks()},
            {"grasps", grasps_},
            {"most_cloth_N", max_cloth_},
            {"most_body_N", max_body_},
            {"most_asked_N", tool_->max_commanded()},
            {"most_sent_N", tool_->max_sent()},
            {"gone_at_end", tool_->gone()},
            {"cloth_s_per_s", time / took.count()}};
}

}  // namespace sqmap::app
