#include "sqmap/mesh/mesh.h"

#include <gtest/gtest.h>

namespace sqmap::mesh {
namespace {

Mesh tetrahedron() { return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}}; }

TEST(Mesh, CanonicalOrderDoesNotDependOnFileOrder)
{
    const Mesh a = canonicalized(tetrahedron());
    const Mesh b = canonicalized({{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}}, {{2, 1, 0}, {3, 2, 0}, {0, 1, 3}, {1, 2, 3}}});
    EXPECT_EQ(a.vertices, b.vertices);
    EXPECT_EQ(a.triangles, b.triangles);
}

TEST(Mesh, ModelSpaceDoesNotDependOnUnits)
{
    Mesh big = tetrahedron();
    for (Vec3d& v : big.vertices) v = 1024.0 * v;
    const Mesh small_model = normalized(tetrahedron(), normalization_of(tetrahedron()));
    EXPECT_EQ(small_model.vertices, normalized(big, normalization_of(big)).vertices);
}

TEST(Mesh, LargestDistanceIsTheLongestEdgeOfATetrahedron)
{
    EXPECT_DOUBLE_EQ(largest_vertex_distance(tetrahedron()), std::sqrt(2.0));
}

}  // namespace
}  // namespace sqmap::mesh
