#include "viewer/server/touch/hand.h"

#include <algorithm>

namespace sqmap::viewer {

device::HandTarget Hand::at(double time) const noexcept
{
    constexpr double k_quickness = 40;  // 1/s
    constexpr double k_longest = 0.02;  // s
    if (time > time_) {
        const double dt = std::min(time - time_, k_longest);
        time_ = time;
        (void)target_.take();
        // A critically damped approach, so that neither position nor speed jumps.
        Vec3d wish = k_quickness * (target_.value() - position_);
        if (const double speed = norm(wish); speed > k_hand_speed) wish = k_hand_speed / speed * wish;
        velocity_ += std::min(1.0, 4 * k_quickness * dt) * (wish - velocity_);
        position_ += dt * velocity_;
    }
    return {{{}, position_}, {velocity_, {}}};
}

device::SimulatedOptions held_by(const Hand& hand)
{
    // 9 N s/m are critical for 10 g between a spring of 400 N/m and a surface of 1500 N/m. Nearly all of it is the mechanism's: a
    // hand's own damper would push on with its speed, into the surface.
    constexpr device::HandProfile k_grip{"pointer", 0.005, 1, 400, 1e-5, 0.004, 0.3};
    device::SimulatedOptions options{.hand = k_grip};
    options.mechanism = {.mass = 0.005,
                         .damping = 8,
                         .coulomb_friction = 0.005,
                         .inertia = 1e-5,
                         .turn_damping = 1e-3,
                         .resolution = 1e-6,
                         .delay_ticks = 0};
    options.script = [](const void* context, double time, std::size_t) noexcept {
        return static_cast<const Hand*>(context)->at(time);
    };
    options.script_context = &hand;
#ifdef __EMSCRIPTEN__
    options.step = 1e-3;  // there the servo's ticks come in bursts
#endif
    return options;
}

}  // namespace sqmap::viewer
