#include "mesh/convex_hull.h"

#include "math/predicates.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace sqmap::mesh {
namespace {

/// The hull is closed, two triangles run each edge in opposite ways, and exact signs put no point outside any plane.
void expect_hull_of(const std::vector<Vec3d>& points, const Mesh& hull, const char* name)
{
    ASSERT_FALSE(hull.triangles.empty()) << name;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const Triangle& t : hull.triangles)
        for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1) << name;
        EXPECT_EQ(edges.count({edge.second, edge.first}), 1u) << name;
    }
    EXPECT_EQ(hull.vertices.size() + hull.triangles.size(), edges.size() / 2 + 2) << name << ": Euler";
    for (const Triangle& t : hull.triangles) {
        const Vec3d a = hull.vertices[t[0]], b = hull.vertices[t[1]], c = hull.vertices[t[2]];
        EXPECT_GT(norm(cross(b - a, c - a)), 0) << name;
        for (const Vec3d& p : points) ASSERT_GE(orient3d(a, b, c, p), 0) << name;
    }
    for (const Vec3d& v : hull.vertices) EXPECT_NE(std::find(points.begin(), points.end(), v), points.end()) << name;
}

std::vector<Vec3d> random_points(std::size_t count, std::uint64_t seed)
{
    test::Random random(seed);
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < count; ++i) points.push_back(random.in_box({-1, -2, -0.5}, {1, 2, 0.5}));
    return points;
}

TEST(ConvexHull, HoldsEveryPointByExactSigns)
{
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const std::vector<Vec3d> points = random_points(4 + 20 * seed, seed);
        expect_hull_of(points, convex_hull(points), "random");
    }
    for (const test::Shape& shape : test::small_shapes())
        expect_hull_of(shape.mesh.vertices, convex_hull(shape.mesh.vertices), shape.name.c_str());
}

TEST(ConvexHull, OfAGridOfPointsInPlanesAndOnLinesIsTheCube)
{
    std::vector<Vec3d> points;
    for (int x = 0; x <= 6; ++x)
        for (int y = 0; y <= 6; ++y)
            for (int z = 0; z <= 6; ++z) points.push_back({x / 3., y / 3., z / 3.});
    test::Random random(3);
    for (int turn = 0; turn < 20; ++turn) {
        for (std::size_t i = points.size() - 1; i > 0; --i) std::swap(points[i], points[random.below(i + 1)]);
        const Mesh hull = convex_hull(points);
        expect_hull_of(points, hull, "grid");
        EXPECT_NEAR(volume(hull), 8, 1e-12);
        for (const Vec3d& corner : {Vec3d{0, 0, 0}, Vec3d{2, 0, 0}, Vec3d{0, 2, 2}, Vec3d{2, 2, 2}})
            EXPECT_NE(std::find(hull.vertices.begin(), hull.vertices.end(), corner), hull.vertices.end());
    }
}

TEST(ConvexHull, TakesThePointThatRoundingCannotTellFromAPlane)
{
    // Far below the rounding of its neighbours, above the middle of a face.
    std::vector<Vec3d> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.5, -1}, {0.3, 0.4, 1e-60}};
    const Mesh hull = convex_hull(points);
    expect_hull_of(points, hull, "hair");
    EXPECT_NE(std::find(hull.vertices.begin(), hull.vertices.end(), points.back()), hull.vertices.end());
}

TEST(ConvexHull, OfRepeatedPointsIsThatOfEachOnce)
{
    std::vector<Vec3d> points = random_points(50, 5);
    const double once = volume(convex_hull(points));
    points.insert(points.end(), points.begin(), points.begin() + 50);
    expect_hull_of(points, convex_hull(points), "twice");
    EXPECT_DOUBLE_EQ(volume(convex_hull(points)), once);
}

TEST(ConvexHull, OfPointsInOnePlaneHasNoTriangles)
{
    EXPECT_TRUE(convex_hull({}).triangles.empty());
    EXPECT_TRUE(convex_hull(std::vector<Vec3d>(9, Vec3d{1, 2, 3})).triangles.empty());
    std::vector<Vec3d> flat, line;
    for (int i = 0; i < 30; ++i) {
        flat.push_back({i % 5 * 0.25, i / 5 * 0.5, 1 + i % 5 * 0.25 + i / 5 * 0.5});
        line.push_back({0.25 * i, 0.5 * i, -0.75 * i});
    }
    EXPECT_TRUE(convex_hull(flat).triangles.empty());
    EXPECT_TRUE(convex_hull(line).triangles.empty());
}

TEST(PolytopeCorners, OfTheSidesOfAHullAreItsCorners)
{
    const Mesh hull = convex_hull(random_points(30, 11));
    std::vector<HalfSpaced> sides;
    for (const Triangle& t : hull.triangles) {
        const Vec3d a = hull.vertices[t[0]], n = normalized(cross(hull.vertices[t[1]] - a, hull.vertices[t[2]] - a));
        sides.push_back({n, dot(n, a)});
    }
    const Mesh again = convex_hull(polytope_corners(sides));
    EXPECT_NEAR(volume(again), volume(hull), 1e-7 * volume(hull));
    EXPECT_LE(farthest_from_hull(hull, again.vertices), 1e-7);
    EXPECT_LE(farthest_from_hull(again, hull.vertices), 1e-7);
}

TEST(PolytopeCorners, OfSidesWithoutACommonPointAreNone)
{
    EXPECT_TRUE(
        polytope_corners(std::vector<HalfSpaced>{{{1, 0, 0}, -1}, {{-1, 0, 0}, -1}, {{0, 1, 0}, 1}, {{0, 0, 1}, 1}}).empty());
}

TEST(CornersOn, AreThoseOfThePolytopeOnOneSide)
{
    std::vector<HalfSpaced> sides;
    for (const Vec3d& n : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, -1, 0}, Vec3d{0, 0, -1}})
        sides.push_back({n, 1});
    const std::vector<Vec3d> top = corners_on({{0, 0, 1}, 2}, sides);
    ASSERT_EQ(top.size(), 4u);
    for (const Vec3d& p : top) {
        EXPECT_DOUBLE_EQ(std::abs(p.x), 1);
        EXPECT_DOUBLE_EQ(std::abs(p.y), 1);
        EXPECT_DOUBLE_EQ(p.z, 2);
    }
    EXPECT_TRUE(corners_on({{1, 0, 0}, 3}, sides).empty());
}

TEST(FarthestFromHull, IsTheSupportExcess)
{
    const Mesh hull = convex_hull(test::cube().vertices);
    EXPECT_EQ(farthest_from_hull(hull, std::vector<Vec3d>{{0.5, 0.2, 0}, {1, 1, 1}}), 0);
    EXPECT_DOUBLE_EQ(farthest_from_hull(hull, std::vector<Vec3d>{{1.5, 0.2, 0}, {0, 3, 0.1}}), 2);
    EXPECT_DOUBLE_EQ(farthest_from_hull(hull, std::vector<Vec3d>{{2, 2, 2}}), std::sqrt(3.));
    // Against the definition, over directions.
    const std::vector<Vec3d> body = random_points(20, 2);
    const auto support = [](std::span<const Vec3d> points, Vec3d u) {
        double h = -1e9;
        for (const Vec3d& p : points) h = std::max(h, dot(u, p));
        return h;
    };
    std::vector<Vec3d> both = body;
    both.insert(both.end(), hull.vertices.begin(), hull.vertices.end());
    test::Random random(8);
    double greatest = 0;
    for (int i = 0; i < 40000; ++i) {
        const Vec3d u = random.direction();
        greatest = std::max(greatest, support(both, u) - support(hull.vertices, u));
    }
    const double excess = farthest_from_hull(hull, both);
    EXPECT_GE(excess, greatest);
    EXPECT_NEAR(excess, greatest, 0.01 * excess);
}

}  // namespace
}  // namespace sqmap::mesh
