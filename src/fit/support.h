// Many points at once against planes of one direction.
#pragma once

#include "sqmap/math/vec.h"

#include <cstdint>
#include <span>

namespace sqmap::fit {

/// Greatest of the products of a direction and points; minus infinity of none. The bits do not depend on the machine.
[[nodiscard]] double greatest_along(Vec3d direction, std::span<const Vec3d> points);

/// Sets bit i % 64 of word i / 64 where point i lies beyond the plane, dot(direction, p) > offset; clears the others.
/// @pre as many words as that takes
void mark_beyond(Vec3d direction, double offset, std::span<const Vec3d> points, std::span<std::uint64_t> words);

}  // namespace sqmap::fit
