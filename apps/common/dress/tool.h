// The tool that grasps a garment: the tip of a device, which meets the body and, through springs, the cloth that it holds.
#pragma once

#include "common/dress/garment_file.h"
#include "device/handover.h"
#include "sqmap/device/device.h"
#include "sqmap/device/servo.h"
#include "sqmap/haptic/safety.h"
#include "sqmap/haptic/step.h"
#include "sqmap/haptic/tool.h"
#include "sqmap/query/probe.h"
#include "sqmap/query/skin.h"
#include "sqmap/sim/cloth.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::app {

/// The state of the cloth that the tool's ticks need. World, m.
struct ToolScene {
    static constexpr std::size_t k_max = 32;
    std::array<sqmap::Pose, k_max> poses{};  ///< of the solids
    bool holds = false;
    Vec3d slack{};                      ///< where the tip would feel nothing of the cloth that it holds
    bool on_skin = false;               ///< the tip is in a skinned solid
    Vec3d skin_point{}, skin_normal{};  ///< its tangent plane there
};

/// The result of a tick.
struct ToolForces {
    Vec3d device{}, tip{};  ///< where the device is; where the tip is, which stays outside the body
    Vec3d body{}, cloth{};  ///< N, on the hand
    std::uint32_t buttons = 0;
    [[nodiscard]] Vec3d commanded() const { return body + cloth; }
};

/// The tip's forces, a tick at a time. Of solids a proxy (haptic::Mode::Proxy) at every tick; of a skin the tangent plane
/// that the last step of the cloth found. The cloth pulls by the springs of its grip at the proxy.
class ClothTool {
public:
    static constexpr double k_stiffness = 500;  ///< N/m, of the contact and of the grip

    /// @pre solids' models outlive this
    explicit ClothTool(std::span<const sim::Collider> solids);

    /// The scene that the next ticks meet, made after each of the cloth's steps.
    [[nodiscard]] ToolScene scene(std::span<const sim::Collider> solids, const sim::Cloth* held, Vec3d dragged, Vec3d device);
    /// dt seconds later, with the device there. No allocation.
    ToolForces tick(const ToolScene& scene, const sqmap::Pose& device, double dt, bool degraded = false) noexcept;

private:
    haptic::Tool tool_;
    std::vector<haptic::TouchedBody> solids_;
    std::vector<std::size_t> which_;  ///< of the avatar's solids
    std::unique_ptr<haptic::State> state_;
    std::size_t skin_ = ToolScene::k_max;  ///< of the avatar's solids; none
    std::unique_ptr<query::SkinWorkspace> workspace_;
};

/// A device that tries a script out: a simulated one, in a simulated hand that goes where a pull says. @pre the pull outlives it
[[nodiscard]] std::unique_ptr<device::Device> simulated_hand(const Pull& pull, const std::string& profile);

/// The tool on a device, by the clock: a servo of its own ticks it at 1 kHz behind the safety filter.
class LiveTool {
public:
    /// at: where the device's origin is in the world.
    LiveTool(std::span<const sim::Collider> solids, device::Device& device, Vec3d at);
    ~LiveTool();

    /// After a step of the cloth: what the ticks are to feel from now on.
    void show(std::span<const sim::Collider> solids, const sim::Cloth* held, Vec3d dragged);
    /// Forces of the newest tick; of the one before where there is no new one.
    [[nodiscard]] const ToolForces& forces();
    /// N: the most of any tick yet, asked for and sent.
    [[nodiscard]] double max_commanded() const { return max_commanded_; }
    [[nodiscard]] double max_sent() const { return max_sent_; }
    [[nodiscard]] std::uint64_t ticks() const { return ticks_; }
    [[nodiscard]] bool gone() const { return gone_; }

private:
    static std::uint32_t tick(void* context, const device::TickInput& input, std::span<device::Wrench> wrenches) noexcept;
    void drain();

    ClothTool tool_;
    Vec3d at_;
    device::Newest<ToolScene> scene_;
    device::Newest<ToolForces> forces_;
    double max_commanded_ = 0, max_sent_ = 0;
    std::uint64_t ticks_ = 0;
    bool gone_ = false;
    std::optional<device::Servo> servo_;
};

}  // namespace sqmap::app
