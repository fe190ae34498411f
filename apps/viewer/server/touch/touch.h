// Touch: the servo with a simulated device in a simulated hand that goes where the pointer in the page says, or with a real
// device.
#pragma once

#include "sqmap/device/device.h"
#include "sqmap/device/servo.h"
#include "viewer/server/protocol/messages.h"
#include "viewer/server/scene/object.h"
#include "viewer/server/touch/feet.h"
#include "viewer/server/touch/recording.h"

#include <array>
#include <memory>
#include <vector>

namespace sqmap::viewer {

/// One tick, as charts draw it.
struct TickPoint {
    float force = 0, torque = 0;  ///< N, N m, as sent
    float depth = 0;              ///< m
    float cpu = 0;                ///< us
    float since = 0;              ///< s since the frame's first tick, by the servo's clock
};

/// What is streamed: the newest tick, and what lay between it and the one before.
struct TouchFrame {
    std::uint64_t tick = 0;
    Vec3d tool{}, force{}, torque{};  ///< m, N, N m; the tool as it is drawn; the force as it is sent to the hand
    Vec3d hand{};                     ///< m, of the device: with a proxy it goes below what the tool lies on
    Mat3d turn{};                     ///< of the tool: world = turn x + tool
    Vec3d point{}, normal{};          ///< of the contact; zero where free
    double depth = 0;                 ///< m, of the hand below the surface
    double late = 0;                  ///< s, the most
    std::uint32_t contacts = 0, acted = 0, faults = 0;
    int object = -1, part = -1;  ///< that is touched
    bool engaged = false, degraded = false, connected = true;
    std::vector<TickPoint> ticks;  ///< at most 256
    double time = 0;               ///< s from the touch's first tick to the first of these
    bool cut = false;              ///< there were more: those that came last are left out
};

/// Runs from construction to destruction.
class Touch {
public:
    /// device: null for the simulated one, which starts at `start`.
    /// An object that is held as the tool (settings) is not there to be touched. take: where frame() records what it hears.
    /// @throw std::invalid_argument, std::system_error as Servo does
    Touch(std::vector<ObjectPtr> objects, const Settings& settings, std::unique_ptr<device::Device> device, Vec3d start,
          std::shared_ptr<Take> take = nullptr);
    ~Touch();
    Touch(const Touch&) = delete;
    Touch& operator=(const Touch&) = delete;

    // One thread.
    void aim(Vec3d target);  ///< where the hand wants the tool; see Hand
    /// False where the new settings need another tool: make another Touch.
    bool adjust(const Settings& settings);
    void stop();
    void resume();
    void end_take();              ///< records no more
    bool frame(TouchFrame& out);  ///< false where no tick has been since the last one
    /// Of the tool's contacts with the object that such a frame names. @pre the frame is of this touch
    [[nodiscard]] std::vector<Foot> feet(const TouchFrame& frame) const;
    [[nodiscard]] const device::Capabilities& capabilities() const;
    [[nodiscard]] device::ServoCounters counters() const;
    [[nodiscard]] double force_limit() const;
    [[nodiscard]] double safe_stiffness() const;  ///< N/m, the largest that the device shows without ever giving energy

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace sqmap::viewer
