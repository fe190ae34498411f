// Touch: the servo with a simulated device in a simulated hand that goes where the pointer in the page says, or with a real
// device.
#pragma once

#include "sqmap/device/device.h"
#include "sqmap/device/servo.h"
#include "viewer/server/protocol/messages.h"
#include "viewer/server/scene/object.h"
#include "viewer/server/touch/feet.h"
#include "viewer/server/touch/frame.h"
#include "viewer/server/touch/recording.h"

#include <memory>
#include <vector>

namespace sqmap::viewer {

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
    /// Feet of the tool's contacts with the object that the frame names. @pre the frame is of this touch
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
