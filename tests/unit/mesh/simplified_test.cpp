#include "mesh/simplified.h"

#include "math/triangle.h"
#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sqmap::mesh {
namespace {

TEST(Simplified, ACoarseCopyHasFewTrianglesTheSameTopologyAndIsNear)
{
    const Mesh fine = torus({.major_radius = 1, .minor_radius = 0.3, .major_segments = 120, .minor_segments = 40});
    const Simplified coarse = simplified(fine, 600);
    EXPECT_LE(coarse.mesh.triangles.size(), 600u);
    EXPECT_EQ(coarse.mesh.triangles.size(), 2 * coarse.mesh.vertices.size()) << "a torus";
    for (const auto& neighbours : dual_graph(coarse.mesh).neighbours)
        for (const std::uint32_t o : neighbours) EXPECT_NE(o, k_no_triangle);
    ASSERT_EQ(coarse.carrier.size(), fine.vertices.size());
    for (std::size_t v = 0; v < fine.vertices.size(); ++v) {
        const Triangle& t = coarse.mesh.triangles[coarse.carrier[v]];
        const Vec3d p = fine.vertices[v], a = coarse.mesh.vertices[t[0]], b = coarse.mesh.vertices[t[1]],
                    c = coarse.mesh.vertices[t[2]];
        EXPECT_LE(norm(closest_point_on_triangle(p, a, b, c) - p), 0.03);
    }
}

TEST(Simplified, OfAnOpenSheetTheBorderStaysAndOfTwoPiecesBoth)
{
    Mesh two;
    constexpr std::uint32_t k_side = 21;
    for (const double height : {0.0, 0.01}) {
        const auto first = static_cast<std::uint32_t>(two.vertices.size());
        for (std::uint32_t i = 0; i < k_side * k_side; ++i)
            two.vertices.push_back({0.05 * (i % k_side), 0.05 * (i / k_side), height});
        for (std::uint32_t i = 0; i + k_side < k_side * k_side; ++i) {
            if (i % k_side + 1 == k_side) continue;
            const std::uint32_t a = first + i;
            two.triangles.push_back({a, a + 1, a + k_side + 1});
            two.triangles.push_back({a, a + k_side + 1, a + k_side});
        }
    }
    const Simplified coarse = simplified(two, 200);
    EXPECT_LT(coarse.mesh.triangles.size(), two.triangles.size() / 4);
    for (std::size_t v = 0; v < two.vertices.size(); ++v)
        for (const std::uint32_t u : coarse.mesh.triangles[coarse.carrier[v]])
            EXPECT_EQ(coarse.mesh.vertices[u].z > 0.005, two.vertices[v].z > 0.005);
    double area = 0;
    for (std::uint32_t t = 0; t < coarse.mesh.triangles.size(); ++t) area += triangle_area(coarse.mesh, t);
    EXPECT_NEAR(area, 2, 0.05);
}

}  // namespace
}  // namespace sqmap::mesh
