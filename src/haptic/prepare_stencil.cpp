#include "sqmap/haptic/stencil.h"

#include <cmath>
#include <numbers>

namespace sqmap::haptic {

std::vector<Vec3d> stencil_points(const Smoothing& smoothing)
{
    // Fibonacci lattice: no plane holds many of them.
    constexpr double k_turn = std::numbers::pi * 0.7639320225002103;  // golden angle: pi (3 - sqrt 5)
    const std::uint32_t n = smoothing.points > 8 ? smoothing.points : 8;
    std::vector<Vec3d> points(n);
    Vec3d mean{};
    for (std::uint32_t i = 0; i < n; ++i) {
        const double z = 1 - (2 * i + 1.) / n, rho = std::sqrt(1 - z * z);
        points[i] = {rho * std::cos(k_turn * i), rho * std::sin(k_turn * i), z};
        mean += points[i] / static_cast<double>(n);
    }
    // Moves and stretches the points by a per cent or two until their mean is zero and their second moments are the sphere's:
    // then the force of a plane has the plane's direction at any depth.
    Mat3d second{{{}, {}, {}}};
    for (Vec3d& p : points) {
        p -= mean;
        for (int i = 0; i < 3; ++i) second.row[i] += (3 * p[i] / n) * p;
    }
    Mat3d root{};  // of the inverse, by Newton: x <- x (3 - x^2 second) / 2
    for (int round = 0; round < 20; ++round) {
        Mat3d m = root * root * second;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) m.row[i][j] = ((i == j ? 3 : 0) - m.row[i][j]) / 2;
        root = root * m;
    }
    for (Vec3d& p : points) p = smoothing.radius * (root * p);
    points.push_back({});
    return points;
}

}  // namespace sqmap::haptic
