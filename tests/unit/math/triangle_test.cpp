#include "math/triangle.h"

#include "math/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace sqmap {
namespace {

class ClosestPoint : public testing::Test {
protected:
    Vec3d position(double size)
    {
        return {random_.between(-size, size), random_.between(-size, size), random_.between(-size, size)};
    }
    SplitMix64 random_{5};
};

TEST_F(ClosestPoint, NoPointOfALatticeIsNearer)
{
    for (int i = 0; i < 2000; ++i) {
        const auto a = position(1), b = position(1), c = position(1), p = position(2);
        const auto found = closest_point_on_triangle(p, a, b, c);
        double least = norm(found - p), nearest_lattice = 100;
        constexpr int k_steps = 24;
        for (int u = 0; u <= k_steps; ++u)
            for (int v = 0; u + v <= k_steps; ++v) {
                const auto q = a + (static_cast<double>(u) / k_steps) * (b - a) + (static_cast<double>(v) / k_steps) * (c - a);
                EXPECT_LE(least, norm(q - p) + 1e-5);
                nearest_lattice = std::min(nearest_lattice, norm(q - found));
            }
        // The answer is a point of the triangle: not farther from the lattice than its step.
        EXPECT_LE(nearest_lattice, (norm(b - a) + norm(c - a)) / k_steps);
    }
}

TEST_F(ClosestPoint, ATriangleWithoutAreaGivesAPointOfIt)
{
    const Vec3d a{0, 0, 0}, b{1, 0, 0}, c{2, 0, 0};
    EXPECT_LE(norm(closest_point_on_triangle({3, 1, 0}, a, b, c) - c), 1e-6);
    EXPECT_LE(norm(closest_point_on_triangle({-1, 1, 0}, a, a, a) - a), 1e-6);
}

TEST_F(ClosestPoint, ATriangleWithoutAreaIsAsNearAsItsLongestSide)
{
    for (int i = 0; i < 20000; ++i) {
        const auto a = position(1), side = position(1), p = position(1);
        const auto share = random_.between(-1, 2);
        Vec3d corners[3] = {a, a + side, a + share * side};
        std::rotate(corners, corners + i % 3, corners + 3);
        const double from = std::min(0.0, share), to = std::max(1.0, share);
        const double along = std::clamp(dot(p - a, side) / dot(side, side), from, to);
        const auto nearest = a + along * side;
        const auto found = closest_point_on_triangle(p, corners[0], corners[1], corners[2]);
        EXPECT_LE(norm(found - p), norm(nearest - p) + 20 * std::numeric_limits<double>::epsilon()) << i;
    }
}

}  // namespace
}  // namespace sqmap
