// Pure function: any number of threads.
#pragma once

#include <cmath>

namespace sqmap {

/// Within 1e-15 of the cube root, of its size. Arithmetic alone, so that every machine has the same bits; std::cbrt's differ.
/// A number that is not finite or not positive is returned unchanged.
[[nodiscard]] inline double cube_root(double x) noexcept
{
    if (!(x > 0) || !std::isfinite(x)) return x;
    int exponent = 0;
    const double share = std::frexp(x, &exponent);  // exact, in [1/2, 1)
    const int third = (exponent - (exponent < 0 ? 2 : 0)) / 3;
    const double rest = std::ldexp(share, exponent - 3 * third);  // in [1/2, 4)
    double root = 0.7 + 0.25 * rest;                              // within a fifth
    // Halley's steps: each cubes the error.
    for (int step = 0; step < 4; ++step) {
        const double cube = root * root * root;
        root *= (cube + 2 * rest) / (2 * cube + rest);
    }
    return std::ldexp(root, third);
}

}  // namespace sqmap
