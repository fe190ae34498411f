// Rotations about the axes of a frame, by angles in radians.
// Pure functions: any number of threads.
#pragma once

#include "sqmap/math/vec.h"

#include <cmath>

namespace sqmap {

inline Mat3d about_x(double a) { return {{{1, 0, 0}, {0, std::cos(a), -std::sin(a)}, {0, std::sin(a), std::cos(a)}}}; }
inline Mat3d about_y(double a) { return {{{std::cos(a), 0, std::sin(a)}, {0, 1, 0}, {-std::sin(a), 0, std::cos(a)}}}; }
inline Mat3d about_z(double a) { return {{{std::cos(a), -std::sin(a), 0}, {std::sin(a), std::cos(a), 0}, {0, 0, 1}}}; }

}  // namespace sqmap
