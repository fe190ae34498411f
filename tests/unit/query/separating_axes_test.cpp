// Two features before complete contacts measure them: whether edges can support each other, and how deep triangles are.
// are.
#include "query/contacts/separating_axes.h"
#include "query/contacts/crossing_rows.h"
#include "query/probe/triangle_tree.h"

#include "math/random.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace sqmap::query {
namespace {

Vec3d random_point(SplitMix64& random) { return {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)}; }

/// An edge about the origin; every third one has a face that holds the z axis or all but holds it.
Wedge random_wedge(SplitMix64& random, int number)
{
    const Vec3d from = random_point(random);
    Wedge wedge{from, -random.between(0.5, 2) * from, {random_point(random), random_point(random)}};
    if (number % 3 == 0) wedge.beside[0] = wedge.from + random.between(-1, 1) * (wedge.to - wedge.from) + Vec3d{0, 0, 1e-15};
    return wedge;
}

TEST(Support, IsLackedSurelyOnlyWhereSeparateFindsNothingAndMostlyThere)
{
    SplitMix64 random(3);
    int none = 0, surely = 0, some = 0;
    for (int i = 0; i < 20000; ++i) {
        const Wedge a = random_wedge(random, i), b = random_wedge(random, i + 1);
        const bool finds = separate(a, b).has_value(), lacks = surely_lack_support(a, b);
        EXPECT_FALSE(finds && lacks) << i;
        none += finds ? 0 : 1;
        some += finds ? 1 : 0;
        surely += lacks ? 1 : 0;
    }
    EXPECT_GT(some, 200);
    EXPECT_GT(surely, 0.7 * none);
}

TEST(Crossings, HaveTheDepthAlongNormalsToTheBit)
{
    SplitMix64 random(4);
    const auto triangles = [&] {
        std::vector<Vec3d> points;
        for (int i = 0; i < 3 * 64; ++i) points.push_back(random_point(random));
        points[5] = points[4];  // without area
        return points;
    };
    std::vector<ProbeTriangle> numbers;
    for (std::uint32_t i = 0; i < 64; ++i) numbers.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    const std::vector<Vec3d> a = triangles(), b = triangles();
    const TriangleTree tree_a(a, numbers), tree_b(b, numbers);
    const Affine still{};
    std::vector<TrianglePair> pairs;
    for (std::uint32_t i = 0; i < 61; ++i) pairs.push_back({i, 63 - i});
    CrossingRows rows;
    find_crossings(tree_a, tree_b, still, pairs, rows);
    int meetings = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const std::uint32_t s = 3 * pairs[i].a, t = 3 * pairs[i].b;
        const TriangleCorners of_a{a[s], a[s + 1], a[s + 2]}, of_b{b[t], b[t + 1], b[t + 2]};
        if (!rows.crossings[i].meets() && (rows.open >> i & 1u) == 0) continue;
        EXPECT_EQ(rows.depths[i], depth_along_normals(of_a, of_b)) << i;
        EXPECT_GE(rows.depths[i], 0);
        ++meetings;
    }
    EXPECT_GT(meetings, 5);
}

}  // namespace
}  // namespace sqmap::query
