#include "sqmap/mesh/solid.h"

#include "sqmap/mesh/self_intersection.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::mesh {
namespace {

bool in_crossing_bars(Vec3d p)
{
    const double x = std::abs(p.x), y = std::abs(p.y), z = std::abs(p.z);
    return z < 0.5 && ((x < 2 && y < 0.5) || (x < 0.5 && y < 2));
}

TEST(Solid, OfTrianglesThatOthersCutOnlyWhatIsVisibleIsNear)
{
    const Mesh mesh = test::crossing_bars();
    const Solid solid(mesh, find_self_intersections(mesh).crossed);
    EXPECT_NEAR(solid.closest_boundary({0, 0, 0}).distance, 0.5, 1e-12);  // the faces above and below, which both bars share
    test::Random random(3);
    int inside = 0;
    for (int i = 0; i < 3000; ++i) {
        const Vec3d p = random.in_box({-2, -2, -0.5}, {2, 2, 0.5});
        ASSERT_EQ(solid.inside(p), in_crossing_bars(p)) << p.x << ' ' << p.y << ' ' << p.z;
        if (!solid.inside(p)) continue;
        ++inside;
        ASSERT_NEAR(solid.closest_boundary(p).distance, test::depth_in_crossing_bars(p), 1e-6) << p.x << ' ' << p.y << ' ' << p.z;
    }
    EXPECT_GT(inside, 1000);
}

TEST(Solid, AShellWithinTheSolidIsNoBoundary)
{
    const Mesh mesh = test::nested_balls(), ball = sphere(1, 3);
    const Solid solid(mesh, find_self_intersections(mesh).crossed), alone(ball);
    EXPECT_FALSE(solid.self_intersecting());
    test::Random random(4);
    for (int i = 0; i < 500; ++i) {
        const Vec3d p = random.in_box({-1, -1, -1}, {1, 1, 1});
        ASSERT_NEAR(solid.closest_boundary(p).distance, alone.closest_boundary(p).distance, 1e-12);
    }
}

TEST(Solid, ACavityIsBoundary)
{
    Mesh inner = sphere(0.5, 2);
    for (Triangle& t : inner.triangles) std::swap(t[1], t[2]);
    const Mesh mesh = test::together(sphere(1, 3), inner);
    const Solid solid(mesh);
    EXPECT_FALSE(solid.inside({0, 0, 0}));
    EXPECT_NEAR(solid.closest_boundary({0.55, 0, 0}).distance, 0.05, 0.01);
}

TEST(Solid, EverythingOfASurfaceIsKept)
{
    Mesh sheets;
    sheets.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    sheets.triangles = {{0, 1, 2}, {3, 4, 5}};
    const Solid solid(sheets);
    EXPECT_NEAR(solid.closest_boundary({0.2, 0.2, 0.9}).distance, 0.1, 1e-12);
    EXPECT_NEAR(solid.closest_boundary({0.2, 0.2, 0.1}).distance, 0.1, 1e-12);
}

}  // namespace
}  // namespace sqmap::mesh
