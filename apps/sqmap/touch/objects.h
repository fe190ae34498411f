// The objects of a touch in motion: pushed by the tool against springs, or swaying.
#pragma once

#include "sqmap/haptic/step.h"
#include "touch/options.h"

#include <span>
#include <vector>

namespace sqmap::app {

class MovingObjects {
public:
    MovingObjects() = default;
    /// solids: one an object, in the order of the options; each is put where it is at first.
    MovingObjects(const TouchOptions& options, std::span<haptic::TouchedBody> solids);

    /// dt seconds on. pushes: of the tool on each object over the last tick. Real-time safe.
    void move(double dt, std::span<const haptic::Wrench> pushes, std::span<haptic::TouchedBody> solids) noexcept;

private:
    /// Its centre and what of it has moved.
    struct Body {
        Vec3d position{};      ///< of the model's origin in the world at first, m
        Vec3d centre{};        ///< mesh frame, m
        Vec3d off{}, speed{};  ///< of the centre, from the position
        Mat3d turn{};
        Vec3d spin{};
        double inertia = 0;  ///< kg m^2
    };
    void put(const Body& body, haptic::TouchedBody& solid) const noexcept;

    BodyOptions options_;
    std::vector<Body> bodies_;
    double time_ = 0;  // s
};

}  // namespace sqmap::app
