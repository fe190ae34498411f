#include "sqmap/mesh/skin.h"

#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::mesh {
namespace {

/// A ball that two joints share: by x, with a band about the middle where both move it.
struct Shared {
    Mesh mesh = sphere(1, 4);
    Influences influences;

    Shared()
    {
        for (const Vec3d& v : mesh.vertices) {
            const double right = std::min(1.0, std::max(0.0, 0.5 + v.x / 0.4));
            influences.joints.push_back({0, 1, 0, 0});
            influences.weights.push_back({1 - right, right, 0, 0});
        }
    }
};

TEST(Skin, JointsThatMoveAlikeMoveTheMeshRigidly)
{
    const Shared s;
    const Affine turn{{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}, {1, 2, 3}};
    const auto moved = skinned(s.mesh.vertices, s.influences, std::array{turn, turn});
    for (std::size_t i = 0; i < moved.size(); ++i)
        EXPECT_LT(norm(moved[i] - (turn.linear * s.mesh.vertices[i] + turn.shift)), 1e-12);
}

TEST(Skin, AVertexIsBlendedByItsWeights)
{
    const Influences half{{{0, 1, 0, 0}}, {{0.25, 0.75, 0, 0}}};
    const auto moved = skinned(std::array{Vec3d{1, 0, 0}}, half, std::array{Affine{{}, {4, 0, 0}}, Affine{{}, {0, 8, 0}}});
    EXPECT_EQ(moved[0], (Vec3d{2, 6, 0}));
}

TEST(Skin, JointSolidsAreClosedAndOverlapToMakeTheWhole)
{
    const Shared s;
    const auto left = joint_solid(s.mesh, s.influences, 0, 0.3), right = joint_solid(s.mesh, s.influences, 1, 0.3);
    ASSERT_TRUE(left && right);
    // A ball cut off at x = 0.08, and up to a row of triangles farther.
    const auto cap = [](double h) { return M_PI * h * h * (3 - h) / 3; };
    EXPECT_GT(volume(*left), 0.99 * cap(1.08));
    EXPECT_LT(volume(*left), cap(1.17));
    EXPECT_NEAR(volume(*left), volume(*right), 0.02);
    EXPECT_GT(volume(*left) + volume(*right), volume(s.mesh));
    EXPECT_FALSE(joint_solid(s.mesh, s.influences, 7, 0.3));
}

}  // namespace
}  // namespace sqmap::mesh
