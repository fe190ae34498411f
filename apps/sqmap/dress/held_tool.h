// A tool on a device that somebody holds, and the garment that it has grasped.
#pragma once

#include "dress/worn.h"

#include <chrono>
#include <optional>

namespace sqmap::app {

/// The cloth keeps to the clock while there is one.
class HeldTool {
public:
    /// spec: of the device. A simulated one's hand follows the one pull that the garments have, which is taken out of its file.
    /// at: X,Y,Z of the device's origin in the world; empty: its own. @throw device::DeviceError
    HeldTool(const std::string& spec, const std::string& at, std::span<const sim::Collider> solids, std::vector<Worn>& worn);

    /// Before the step that ends at time: waits until its time has come, grasps, drags, lets go.
    void before(double time);
    void after(std::span<const sim::Collider> solids) { tool_->show(solids, held_, dragged_); }
    [[nodiscard]] nlohmann::json report(double time) const;

private:
    std::vector<Worn>* worn_;
    std::optional<Pull> script_;
    std::unique_ptr<device::Device> device_;
    std::optional<LiveTool> tool_;
    std::chrono::steady_clock::time_point begin_;
    sim::Cloth* held_ = nullptr;
    std::uint32_t vertex_ = 0;
    Vec3d dragged_{};
    std::size_t grasps_ = 0;
    double max_cloth_ = 0, max_body_ = 0;
};

}  // namespace sqmap::app
