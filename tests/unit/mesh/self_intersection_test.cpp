#include "sqmap/mesh/self_intersection.h"

#include "math/predicates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace sqmap::mesh {
namespace {

std::uint64_t pairs(const Mesh& mesh) { return find_self_intersections(mesh).pair_count; }

TEST(SelfIntersection, NeighboursThatOnlyShareVerticesDoNotIntersect)
{
    EXPECT_EQ(pairs({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {2, 1, 3}}}), 0u);
    EXPECT_EQ(pairs({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}}}), 0u);
}

TEST(SelfIntersection, NeighboursThatFoldOntoEachOtherDo)
{
    EXPECT_EQ(pairs({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.5, 1, 0}}, {{0, 1, 2}, {1, 0, 3}}}), 1u) << "shared edge";
    EXPECT_EQ(pairs({{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 1, 1}, {1, 1, -1}}, {{0, 1, 2}, {0, 3, 4}}}), 1u) << "shared vertex";
    EXPECT_EQ(pairs({{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 0.5, 0}, {0.5, 1, 0}}, {{0, 1, 2}, {0, 3, 4}}}), 1u) << "in one plane";
    EXPECT_EQ(pairs({{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}}, {{0, 1, 2}, {0, 2, 1}}}), 1u) << "back to back";
}

TEST(SelfIntersection, DisjointTrianglesIntersectFromTheFirstTouch)
{
    const auto with_tip = [](double z) {
        return Mesh{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, z}, {1, 2, 3}, {2, 1, 3}}, {{0, 1, 2}, {3, 4, 5}}};
    };
    EXPECT_EQ(pairs(with_tip(-1)), 1u);
    EXPECT_EQ(pairs(with_tip(0)), 1u);
    EXPECT_EQ(pairs(with_tip(1e-60)), 0u) << "no tolerance";
}

TEST(SelfIntersection, TheTreeFindsWhatTestingAllPairsFinds)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> coordinate(0, 1), offset(-0.15, 0.15);
    Mesh mesh;
    for (std::uint32_t t = 0; t < 300; ++t) {
        const Vec3d centre{coordinate(random), coordinate(random), coordinate(random)};
        for (int k = 0; k < 3; ++k) mesh.vertices.push_back(centre + Vec3d{offset(random), offset(random), offset(random)});
        mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    std::uint64_t expected = 0;
    for (std::uint32_t s = 0; s < 300; ++s)
        for (std::uint32_t t = s + 1; t < 300; ++t) {
            Mesh pair;
            for (const std::uint32_t i : {s, t})
                for (std::uint32_t k = 0; k < 3; ++k) pair.vertices.push_back(mesh.vertices[3 * i + k]);
            pair.triangles = {{0, 1, 2}, {3, 4, 5}};
            expected += pairs(pair);
        }
    ASSERT_GT(expected, 50u);
    const SelfIntersections found = find_self_intersections(mesh);
    EXPECT_EQ(found.pair_count, expected);
    EXPECT_TRUE(found.is_complete);
    EXPECT_FALSE(find_self_intersections(mesh, 10).is_complete);
    EXPECT_EQ(find_self_intersections(mesh, 10).pair_count, 10u);

    // Restricted to every third triangle: all pairs but those of two others.
    std::vector<std::uint8_t> third(mesh.triangles.size(), 0);
    Mesh others = mesh;
    others.triangles.clear();
    for (std::size_t t = 0; t < third.size(); ++t) {
        third[t] = t % 3 == 0 ? 1 : 0;
        if (third[t] == 0) others.triangles.push_back(mesh.triangles[t]);
    }
    const auto without = find_self_intersections(others).pair_count;
    ASSERT_GT(without, 0u);
    EXPECT_EQ(find_self_intersections(mesh, expected, third).pair_count, expected - without);
}

TEST(Predicates, SignsAreExactWhereRoundingIsNot)
{
    // Points on the diagonal plane x = y, moved by the least step that double has.
    const double step = std::ldexp(1.0, -53);
    const Vec3d a{0.1, 0.1, 0}, b{0.7, 0.7, 0}, c{0.3, 0.3, 1};
    EXPECT_EQ(orient3d(a, b, c, {0.5, 0.5, 0.25}), 0);
    const int side = orient3d(a, b, c, {0.5 + step, 0.5, 0.25});
    EXPECT_NE(side, 0);
    EXPECT_EQ(orient3d(a, b, c, {0.5 - step, 0.5, 0.25}), -side);
    EXPECT_EQ(orient3d(a, b, c, {0.75, 0.25, 0.25}), side);
    EXPECT_EQ(orient3d(b, a, c, {0.75, 0.25, 0.25}), -side);
    EXPECT_EQ(orient2d({0.1, 0.1}, {0.7, 0.7}, {0.5, 0.5}), 0);
    EXPECT_EQ(orient2d({0, 0}, {1, 0}, {0, 1}), 1);
    EXPECT_EQ(orient2d({0.1, 0.1}, {0.7, 0.7}, {0.5, 0.5 + step}), 1);
    EXPECT_EQ(orient2d({0.1, 0.1}, {0.7, 0.7}, {0.5 + step, 0.5}), -1);
}

}  // namespace
}  // namespace sqmap::mesh
