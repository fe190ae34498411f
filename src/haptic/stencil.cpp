#include "haptic/stencil.h"

#include "math/cube_root.h"

#include <cmath>

namespace sqmap::haptic {

// Along any axis a sphere's surface is spread evenly (Archimedes): with c from -1 to 1, depths are t - r c, and their squares'
// mean is an integral over the part of them above zero.
double mean_square_depth(double r, double t) noexcept
{
    if (!(t > -r)) return 0;
    return t < r ? (t + r) * (t + r) * (t + r) / (6 * r) : t * t + r * r / 3;
}

StencilDepth depth_of_stencil(double r, double mean_square) noexcept
{
    if (!(mean_square > 0)) return {-r, 0};
    const double spread = r * r / 3;
    if (mean_square >= 4 * spread) {
        const double t = std::sqrt(mean_square - spread);
        return {t, 0.5 / t};
    }
    const double s = cube_root(6 * r * mean_square);  // t + r
    return {s - r, s / (3 * mean_square)};
}

}  // namespace sqmap::haptic
