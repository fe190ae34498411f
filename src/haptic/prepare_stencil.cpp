#include "sqmap/haptic/stencil.h"

#include <cmath>
#include <numbers>

namespace sqmap::haptic {

std::vector<Vec3d> stencil_points(const Smoothing& smoothing)
{
    constexpr double turn = std::numbers::pi * 0.7639320225002103;  // golden angle: pi (3 - sqrt 5)
    const std::uint32_t n = smoothing.points > 0 ? smoothing.points : 1;
    std::vector<Vec3d> points(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        const double z = 1 - (2 * i + 1.) / n, rho = std::sqrt(1 - z * z);
        // In a ball the shells follow the van der Corput sequence, so that neighbours on the spiral lie on different ones.
        double share = 0, digit = 0.5;
        for (std::uint32_t k = i; k > 0; k /= 2, digit /= 2) share += digit * (k % 2);
        const double radius = smoothing.kernel == Kernel::Ball ? smoothing.radius * std::cbrt(share + 0.5 / n) : smoothing.radius;
        points[i] = radius * Vec3d{rho * std::cos(turn * i), rho * std::sin(turn * i), z};
    }
    // About their own mean, so that the centre is the point that the zone stands for.
    Vec3d mean{};
    for (const Vec3d& p : points) mean += p / static_cast<double>(n);
    for (Vec3d& p : points) p -= mean;
    return points;
}

}  // namespace sqmap::haptic
