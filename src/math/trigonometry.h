// Sines, cosines and angles by polynomials: no system's library, so that every machine has the same bits. Within 2e-15 of their
// functions; arithmetic and roots alone, which IEEE 754 rounds in one way.
// Pure functions: any number of threads.
#pragma once

#include <cmath>

namespace sqmap {

/// The sine and cosine of one angle.
struct SineCosine {
    double sine, cosine;
};

/// Sine and cosine of an angle in radians; NaN for an angle beyond a million of either sign, or not finite.
[[nodiscard]] inline SineCosine sine_cosine(double angle) noexcept
{
    if (!(std::abs(angle) <= 1e6)) return {NAN, NAN};
    // Less whole right angles, in three parts: products of the first two with a count below 2^20 are exact.
    constexpr double k_high = 0x1.921fb544p+0, k_middle = 0x1.0b4611a6p-34, k_low = 0x1.3198a2e037073p-69;
    const double count = std::floor(angle * 0x1.45f306dc9c883p-1 + 0.5);
    const double r = ((angle - count * k_high) - count * k_middle) - count * k_low, t = r * r;
    // Taylor's series to the terms below 1e-17 at an eighth of a turn.
    double sine = 0, cosine = 0;
    for (int n = 17; n >= 3; n -= 2) sine = -t / (n * (n - 1)) * (1 + sine);
    for (int n = 18; n >= 2; n -= 2) cosine = -t / (n * (n - 1)) * (1 + cosine);
    sine = r + r * sine;
    cosine = 1 + cosine;
    switch (static_cast<long long>(count) & 3) {
        case 0:
            return {sine, cosine};
        case 1:
            return {cosine, -sine};
        case 2:
            return {-sine, -cosine};
        default:
            return {-cosine, sine};
    }
}

/// The angle of (x, y), from -pi to pi; zero for (0, 0), NaN for numbers that are not finite.
[[nodiscard]] inline double angle_of(double y, double x) noexcept
{
    const double ax = std::abs(x), ay = std::abs(y), large = ax > ay ? ax : ay, small = ax > ay ? ay : ax;
    if (large == 0) return 0;
    const double ratio = small / large;
    // Half of half of an angle of at most an eighth of a turn: its tangent is below 0.1.
    const double half = ratio / (1 + std::sqrt(1 + ratio * ratio)), quarter = half / (1 + std::sqrt(1 + half * half));
    const double t = quarter * quarter;
    double sum = 0;
    for (int n = 25; n >= 3; n -= 2) sum = -t * (1.0 / n + sum);
    double angle = 4 * (quarter + quarter * sum);
    constexpr double k_pi = 0x1.921fb54442d18p+1;
    if (ay > ax) angle = 0.5 * k_pi - angle;
    if (x < 0) angle = k_pi - angle;
    return y < 0 ? -angle : angle;
}

}  // namespace sqmap
