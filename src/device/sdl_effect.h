// A force as the effect that SDL plays on a stick with force feedback.
#pragma once

#include "sqmap/math/vec.h"

#include <SDL2/SDL_haptic.h>

#include <cstdint>

namespace sqmap::device {

inline constexpr std::uint32_t k_effect_length = 100;  ///< ms after which the hardware falls still by itself

/// force: N, the world. full_scale: N, the hardware's strongest force. The effect is zero for a force that is not finite.
[[nodiscard]] SDL_HapticEffect constant_force(Vec3d force, double full_scale);

}  // namespace sqmap::device
