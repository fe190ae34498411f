// Numbers as files have them.
#pragma once

#include "sqmap/math/vec.h"

#include <string>

namespace sqmap::collider {

/// The nearest number of nine significant decimal digits.
[[nodiscard]] double rounded(double value);
[[nodiscard]] Vec3d rounded(Vec3d v);
/// The least number of nine significant decimal digits that is not below a value. value: not negative.
[[nodiscard]] double rounded_up(double value);

/// The shortest text that reads as this number.
[[nodiscard]] std::string text(double value);
/// "x y z"
[[nodiscard]] std::string text(Vec3d v, const char* separator = " ");

}  // namespace sqmap::collider
