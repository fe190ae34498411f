// Triangles that rulers rule out are farther than a ruler at every point of the box.
#include "bake/locator/rulers.h"

#include "math/triangle.h"
#include "unit/fit/shapes.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <array>
#include <random>

namespace sqmap::bake {
namespace {

using fit::test::uniform;

using Corners = std::array<Vec3d, 3>;

/// A small triangle, at most `far` from the box's middle along each axis.
Corners random_triangle(std::mt19937& random, double far)
{
    const Vec3d at{uniform(random, -far, far), uniform(random, -far, far), uniform(random, -far, far)};
    Corners t;
    for (Vec3d& v : t) v = at + 0.3 * Vec3d{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
    return t;
}

Vec3d to_triangle(Vec3d p, const Corners& t) { return closest_point_on_triangle(p, t[0], t[1], t[2]) - p; }

Vec3d corner(std::size_t k) { return {k & 1 ? .5 : -.5, k & 2 ? .5 : -.5, k & 4 ? .5 : -.5}; }

/// The arrays of one triangle over the eight corners of the box of side 1 about the origin.
struct Measured {
    float distance[8], offset[3][8];

    explicit Measured(const Corners& t)
    {
        for (std::size_t k = 0; k < 8; ++k) {
            const Vec3d to = to_triangle(corner(k), t);
            distance[k] = static_cast<float>(norm(to));
            for (std::size_t i = 0; i < 3; ++i) offset[i][k] = static_cast<float>(to[static_cast<int>(i)]);
        }
    }
    [[nodiscard]] LatticeDistances view() const { return {distance, {offset[0], offset[1], offset[2]}}; }
};

TEST(Rulers, RuleOutOnlyWhatIsFartherEverywhere)
{
    constexpr std::size_t k_corners[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    constexpr float k_slack = 1e-4f;
    std::mt19937 random(3);
    int ruled_out = 0, kept = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        const Corners ruler = random_triangle(random, 0.8), other = random_triangle(random, 2);
        Rulers rulers;
        rulers.count = 1;
        const Measured near(ruler), far(other);
        std::copy(std::begin(near.distance), std::end(near.distance), rulers.value[0]);
        const bool first = rulers.rule_out(far.view(), k_corners, 0, 8, 1, k_slack);
        for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1) {
            hwy::SetSupportedTargetsForTest(left & -left);
            EXPECT_EQ(rulers.rule_out(far.view(), k_corners, 0, 8, 1, k_slack), first);
        }
        hwy::SetSupportedTargetsForTest(0);
        (first ? ruled_out : kept)++;
        if (!first) continue;
        for (int i = 0; i < 200; ++i) {
            const Vec3d p{uniform(random, -.5, .5), uniform(random, -.5, .5), uniform(random, -.5, .5)};
            ASSERT_GT(norm(to_triangle(p, other)), norm(to_triangle(p, ruler)));
        }
    }
    EXPECT_GT(ruled_out, 200);
    EXPECT_GT(kept, 200);
}

}  // namespace
}  // namespace sqmap::bake
