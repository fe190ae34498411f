#include "sim/crossings.h"

#include "sqmap/sim/garment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

namespace sqmap::sim {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

TEST(Crossings, CountAnEdgeThroughATriangleAndNothingThatTouches)
{
    std::vector<Vec3d> at{{-1, 0, -1}, {1, 0, -1}, {0, 0, 2}, {0, -1, 0}, {0, 1, 0}, {5, 1, 0}};
    const std::vector<Triangle> two{{0, 1, 2}, {3, 4, 5}};
    EXPECT_EQ(crossings(at, two), 2u);  // of 3-4, and of 5-3, which comes back through at x = 2.5: outside; and of 1-2 through it
    at[5] = {50, 100, 0};
    at[4] = {0, 0, 0};  // its tip in the plane: it touches
    at[3] = {0, 1, 0};
    EXPECT_EQ(crossings(at, two), 0u);
}

TEST(Crossings, VerticesThatAreSewnTogetherAreOne)
{
    // Two triangles hinged on copies of one edge, a hair past each other: sewn they touch, else they cross.
    const std::vector<Vec3d> at{{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.1, 0.01, -1e-3}, {0.9, 0.01, -1e-3}, {0.5, 0.3, 1}};
    const std::vector<Triangle> two{{0, 1, 2}, {3, 4, 5}};
    const std::vector<std::uint32_t> sewn{0, 1, 2, 0, 1, 5};
    EXPECT_EQ(crossings(at, two), 2u);
    EXPECT_EQ(crossings(at, two, sewn), 0u);
}

TEST(Crossings, AreThoseOfEveryEdgeAgainstEveryTriangle)
{
    // By the signs of where the edge's line meets the plane, in another way than the code's.
    Garment g = sheet({{0, 0, 0}, 1, 1, 0, 0, 300});
    std::mt19937 random(7);
    std::normal_distribution<double> shake(0, 0.05);
    for (Vec3d& p : g.start) p += {shake(random), shake(random), shake(random)};
    std::set<std::array<std::uint32_t, 2>> edges;
    for (const Triangle& t : g.triangles)
        for (std::size_t k = 0; k < 3; ++k) edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
    std::size_t expected = 0;
    for (const auto& e : edges)
        for (const Triangle& t : g.triangles) {
            if (std::any_of(t.begin(), t.end(), [&](std::uint32_t v) { return v == e[0] || v == e[1]; })) continue;
            const Vec3d a = g.start[t[0]], u = g.start[t[1]] - a, v = g.start[t[2]] - a, p = g.start[e[0]], d = g.start[e[1]] - p;
            // Moller and Trumbore
            const Vec3d h = cross(d, v);
            const double det = dot(u, h), x = dot(p - a, h) / det;
            const Vec3d q = cross(p - a, u);
            const double y = dot(d, q) / det, s = dot(v, q) / det;
            expected += x > 0 && y > 0 && x + y < 1 && s > 0 && s < 1 ? 1 : 0;
        }
    EXPECT_GT(expected, 100u);
    EXPECT_EQ(crossings(g.start, g.triangles), expected);
}

}  // namespace
}  // namespace sqmap::sim
