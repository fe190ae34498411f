#include "sqmap/mesh/wrap.h"

#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <vector>

namespace sqmap::mesh {
namespace {

/// A square in z = height, of two triangles over [0, side]^2.
Mesh square(double side, double height)
{
    return {{{0, 0, height}, {side, 0, height}, {side, side, height}, {0, side, height}}, {{0, 1, 2}, {0, 2, 3}}};
}

TEST(Deviation, IsZeroOfAMeshToItself)
{
    const Mesh ball = sphere(1, 3);
    const Deviation d = deviation(ball, ball);
    EXPECT_LT(d.input_to_result.max, 1e-12);
    EXPECT_LT(d.result_to_input.max, 1e-12);
    EXPECT_EQ(d.made_up_area, 0);
}

TEST(Deviation, OfShiftedSquaresIsTheShift)
{
    const Deviation d = deviation(square(1, 0), square(1, 0.25));
    for (const Distances& one : {d.input_to_result, d.result_to_input}) {
        EXPECT_NEAR(one.mean, 0.25, 1e-12);
        EXPECT_NEAR(one.p99, 0.25, 1e-12);
        EXPECT_NEAR(one.max, 0.25, 1e-12);
    }
}

TEST(Deviation, IsMeasuredBothWaysAndByArea)
{
    // The larger square reaches one beyond the smaller: half the area of a strip is farther than 1/2.
    Mesh wide = square(1, 0);
    for (Vec3d& p : wide.vertices) p.x *= 2;
    const Deviation d = deviation(square(1, 0), wide);
    EXPECT_LT(d.input_to_result.max, 1e-12);
    EXPECT_NEAR(d.result_to_input.mean, 0.25, 1e-3);
    EXPECT_NEAR(d.result_to_input.p99, 0.98, 1e-3);
    EXPECT_NEAR(d.result_to_input.max, 1, 1e-12);
}

TEST(Deviation, LeavesOutWhatIsMadeUpOneWayAndSaysHowMuchThatIs)
{
    Mesh both = square(1, 0);
    const Mesh lid = square(1, 3);
    for (const Vec3d& p : lid.vertices) both.vertices.push_back(p);
    for (const Triangle& t : lid.triangles) both.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
    const std::vector<std::uint8_t> made_up{0, 0, 1, 1};
    const Deviation d = deviation(square(1, 0), both, made_up);
    EXPECT_LT(d.result_to_input.max, 1e-12);
    EXPECT_NEAR(d.made_up_area, 1, 1e-12);
    EXPECT_NEAR(d.made_up_share, 0.5, 1e-12);
    EXPECT_NEAR(deviation(square(1, 0), both).result_to_input.max, 3, 1e-12);
}

}  // namespace
TEST(Deviation, BoundingSurfaceLeavesOutInnerWallsAndSheets)
{
    Mesh input = sphere(1, 3), result = input;
    const auto add = [&](const Mesh& other, double size, Vec3d at) {
        const auto n = static_cast<std::uint32_t>(input.vertices.size());
        for (const Vec3d& v : other.vertices) input.vertices.push_back(size * v + at);
        for (const Triangle& t : other.triangles) input.triangles.push_back({t[0] + n, t[1] + n, t[2] + n});
    };
    for (Vec3d& v : result.vertices) v = 1.01 * v;
    add(square(1, 0), 0.2, {0, 0, 0});  // in the ball
    add(square(1, 0), 0.2, {0, 0, 5});  // outside
    EXPECT_GT(deviation(input, result).input_to_result.max, 3);
    const Distances bounding = bounding_distances(input, result);
    EXPECT_NEAR(bounding.mean, 0.01, 5e-4);
    EXPECT_LT(bounding.max, 0.0101);
    EXPECT_EQ(bounding_distances(square(1, 0), result).max, 0);  // bounds nothing
}

}  // namespace sqmap::mesh
