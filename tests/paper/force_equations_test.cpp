// Equations 21 and 32 to 34 of the paper.
#include "sqmap/bake/normal_map.h"
#include "sqmap/haptic/force.h"
#include "sqmap/haptic/texture.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/query/normal_projection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace sqmap {
namespace {

// A ball of 0.8 in a superquadric that is a ball of 1: everything has a closed form.
class BallInBall : public testing::Test {
protected:
    BallInBall()
    {
        const mesh::Mesh m = mesh::sphere(0.8, 5);
        std::vector<std::uint32_t> all(m.triangles.size());
        std::iota(all.begin(), all.end(), 0u);
        const bake::MapRays rays(m);
        map = bake::bake_normal_map(rays, all, shape::Superquadricd{}, {.min_level = 6, .max_level = 6});
    }
    [[nodiscard]] query::PartAnswer answer(Vec3d p) const { return query::project(map.view(), cast<float>(p)); }

    bake::NormalMap map;
    const std::vector<Vec3d> points{{0.6, 0.3, 0.2}, {-0.1, 0.7, -0.3}, {0.2, -0.4, 0.6}, {-0.5, -0.5, -0.3}};
};

TEST_F(BallInBall, Eq21SizeOfTheSpringForceFromTheMap)
{
    for (const Vec3d& p : points) {
        const query::PartAnswer a = answer(p);
        ASSERT_EQ(a.verdict, query::Verdict::Contact);
        const double force = haptic::spring_force(300, {a.foot_distance, a.map_distance});
        EXPECT_NEAR(force, 300 * (0.8 - norm(p)), 300 * 0.002);
    }
    EXPECT_DOUBLE_EQ(haptic::spring_force(300, {0.1, 0.3}), 60);  // an absolute value, as printed
}

TEST_F(BallInBall, Eq32ReactionAlongTheSurfaceNormalOfEq26)
{
    for (const Vec3d& p : points) {
        const query::PartAnswer a = answer(p);
        const Vec3d f = haptic::reaction_force(300, a.foot_distance - a.map_distance, cast<double>(a.normal));
        const Vec3d expected = 300 * (0.8 - norm(p)) * normalized(p);
        EXPECT_LT(norm(f - expected), 0.03 * norm(expected) + 0.6);
    }
}

TEST(Paper, Eq33FrictionAgainstTheMotionGrowsWithDepthAndIsNothingWhileStill)
{
    const Vec3d motion{0.001, -0.002, 0.0005};
    for (const double depth : {0.0, 0.001, 0.004}) {
        const Vec3d f = haptic::printed_friction({.f_c = 0.3, .k_f = 200}, depth, motion);
        EXPECT_NEAR(norm(f), 0.3 * (1 + 200 * depth), 1e-12);
        EXPECT_NEAR(dot(f, motion), -norm(f) * norm(motion), 1e-12);
    }
    EXPECT_EQ(haptic::printed_friction({.f_c = 0.3, .k_f = 200}, 0.001, {}), Vec3d{});
}

TEST(Paper, Eq34NoiseChangesTheSizeByItsHeightAndIsFixedInPlace)
{
    std::vector<float> values;
    const haptic::Texture texture = haptic::gaussian_texture({.amplitude = 0.0002}, values);
    const Vec3d n{0, 0, 1};
    for (int i = 0; i < 100; ++i) {
        const Vec3d p{1e-3 * i, 2e-3 * i, 0};
        const haptic::Relief r = haptic::relief_at(texture, p, n);
        const haptic::Carved c = haptic::carved(r, 0.005, n);
        // |S - (D + n_g)| with n_g = -height, a distance further in.
        EXPECT_NEAR(haptic::spring_force(500, {0.105, 0.100 - r.height}), 500 * c.depth, 1e-9);
        const haptic::Relief again = haptic::relief_at(texture, p, n);
        EXPECT_EQ(r.height, again.height);
    }
}

}  // namespace
}  // namespace sqmap
