// The simulated hand that goes where the pointer in the page says, and the simulated device that it holds.
#pragma once

#include "device/handover.h"
#include "sqmap/device/simulated.h"
#include "sqmap/math/vec.h"

namespace sqmap::viewer {

inline constexpr double k_hand_speed = 0.4;  ///< m/s; the safety filter takes more than 1 m/s for a fault

/// Goes to its target at a hand's speed and comes to rest there without passing it. The target by one thread, the rest by
/// another.
class Hand {
public:
    explicit Hand(Vec3d start) : position_(start) { target_.put(start); }

    void aim(Vec3d target) { target_.put(target); }
    /// time: s since it began to move, never less than before.
    [[nodiscard]] device::HandTarget at(double time) const noexcept;

private:
    // A device asks through a pointer to const.
    mutable device::Newest<Vec3d> target_;
    mutable Vec3d position_, velocity_{};
    mutable double time_ = 0;
};

/// A light tool without motors, so that nothing heats, held so that no surface makes it ring. hand: outlives the device.
[[nodiscard]] device::SimulatedOptions held_by(const Hand& hand);

}  // namespace sqmap::viewer
