// Nearest points in double: the vector kernel has the bits of foot_on_triangle, whatever the region and the triangle.
#include "query/distance/double_feet.h"
#include "math/random.h"
#include "math/triangle.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>

namespace sqmap {
namespace {

using Triangle = std::array<Vec3d, 3>;

Vec3d random_point(SplitMix64& random, double size)
{
    return {random.between(-size, size), random.between(-size, size), random.between(-size, size)};
}

/// Needles, corners that coincide, corners in line, and triangles of any shape.
Triangle random_triangle(SplitMix64& random)
{
    const Vec3d a = random_point(random, 1), b = random_point(random, 1);
    switch (random.bits() % 8) {
        case 0:
            return {a, a, a};
        case 1:
            return {a, b, b};
        case 2:
            return {a, 0.5 * (a + b), b};
        case 3:
            return {a, b, a + 1e-9 * random_point(random, 1)};
        default:
            return {a, b, random_point(random, 1)};
    }
}

/// On a corner, on a side, on the face, or anywhere about.
Vec3d random_point_about(SplitMix64& random, const Triangle& t)
{
    const double u = random.uniform(), v = random.uniform() * (1 - u);
    switch (random.bits() % 6) {
        case 0:
            return t[random.bits() % 3];
        case 1:
            return t[0] + u * (t[1] - t[0]);
        case 2:
            return t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]);
        case 3:
            return random_point(random, 20);
        default:
            return random_point(random, 2);
    }
}

bool same_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

TEST(DoubleFeet, HaveTheBitsOfFootOnTriangle)
{
    SplitMix64 random(1);
    const auto feet = std::make_unique<query::DoubleFeet>();
    std::array<int, 8> seen{};
    for (int round = 0; round < 400; ++round) {
        const std::size_t first = random.bits() % 20, count = 1 + random.bits() % (query::DoubleFeet::k_capacity - first);
        for (std::size_t i = 0; i < first + count; ++i) {
            const Triangle t = random_triangle(random);
            feet->put(i, random_point_about(random, t), t);
        }
        feet->measure(first, count);
        for (std::size_t i = first; i < first + count; ++i) {
            const Triangle t = feet->triangle_of(i);
            const Vec3d p{feet->point[0][i], feet->point[1][i], feet->point[2][i]};
            const TriangleFoot foot = foot_on_triangle(p, t[0], t[1], t[2]);
            const Vec3d offset = foot.point - p, found = feet->offset_of(i);
            for (int k = 0; k < 3; ++k) ASSERT_TRUE(same_bits(found[k], offset[k])) << found[k] << " for " << offset[k];
            ASSERT_TRUE(same_bits(feet->distance_sq[i], norm_sq(offset)));
            ASSERT_TRUE(same_bits(feet->distance[i], norm(offset)));
            ASSERT_EQ(feet->corners[i], foot.corners);
            const Vec3d across = cross(t[1] - t[0], t[2] - t[0]);
            const double area = norm(across), height = area > 0 ? -dot(offset, across / area) : 0;
            ASSERT_EQ(feet->height[i], height);
            ASSERT_EQ(feet->facing[i], norm(offset) > 0 ? std::abs(height) / norm(offset) : 0);
            ++seen[foot.corners];
        }
    }
    for (const unsigned corners : {1u, 2u, 3u, 4u, 5u, 6u, 7u}) EXPECT_GT(seen[corners], 500) << corners;
}

}  // namespace
}  // namespace sqmap
