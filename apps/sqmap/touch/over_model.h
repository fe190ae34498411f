// Devices that need the model: scripted paths over it, and simulated devices in a hand that follows one.
#pragma once

#include "device/hand.h"
#include "sqmap/device/device.h"
#include "sqmap/device/open.h"
#include "sqmap/device/simulated.h"
#include "touch/setup.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace sqmap::app {

/// Poses that the simulated hand aims for, tick by tick; simulated devices point at them.
struct HandPath {
    std::vector<sqmap::Pose> poses;
    double rate = 1000;
    device::GloveMotion glove{};

    static device::HandTarget at(const void* context, double time, std::size_t) noexcept
    {
        const HandPath& path = *static_cast<const HandPath*>(context);
        const double position = std::clamp(time * path.rate, 0.0, static_cast<double>(path.poses.size() - 1));
        const auto k = static_cast<std::size_t>(position);
        const std::size_t next = std::min(k + 1, path.poses.size() - 1);
        const Vec3d a = path.poses[k].translation, b = path.poses[next].translation;
        return {{{}, a + (position - static_cast<double>(k)) * (b - a)}, {path.rate * (b - a), {}}};
    }
};

/// press, tap, slide, circle, simulated or glove.
[[nodiscard]] bool is_over_model(const std::string& kind);

/// spec: of such a kind. hand: what the device points at; it must outlive the device.
/// @throw device::DeviceError for options that the kind does not have
[[nodiscard]] std::unique_ptr<device::Device> device_over(const device::DeviceSpec& spec, const TouchSetup& setup, double seconds,
                                                          HandPath& hand);

}  // namespace sqmap::app
