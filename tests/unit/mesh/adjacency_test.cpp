#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sqmap::mesh {
namespace {

TEST(DualGraph, LinksTheTrianglesThatShareAnEdge)
{
    const Mesh m = torus();
    const DualGraph g = dual_graph(m);
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t)
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t o = g.neighbours[t][e];
            ASSERT_NE(o, k_no_triangle);
            const Triangle& other = m.triangles[o];
            EXPECT_NE(std::find(other.begin(), other.end(), m.triangles[t][e]), other.end());
            EXPECT_NE(std::find(other.begin(), other.end(), m.triangles[t][(e + 1) % 3]), other.end());
            EXPECT_EQ(std::count(g.neighbours[o].begin(), g.neighbours[o].end(), t), 1);
        }
}

TEST(DualGraph, HasNoNeighbourAcrossABorder)
{
    const Mesh two{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
    const DualGraph g = dual_graph(two);
    EXPECT_EQ(g.neighbours[0], (std::array<std::uint32_t, 3>{k_no_triangle, k_no_triangle, 1}));
    EXPECT_EQ(g.neighbours[1], (std::array<std::uint32_t, 3>{0, k_no_triangle, k_no_triangle}));
}

TEST(DualGraph, PairsTheTrianglesOfANonManifoldEdge)
{
    const Mesh fin{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}};
    const DualGraph g = dual_graph(fin);
    EXPECT_EQ(g.neighbours[0][0], 1u);
    EXPECT_EQ(g.neighbours[1][0], 0u);
    EXPECT_EQ(g.neighbours[2][0], k_no_triangle);
}

}  // namespace
}  // namespace sqmap::mesh
