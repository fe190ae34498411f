// Clearance against CGAL's distances of all pairs of triangles.
#include "sqmap/query/clearance.h"
#include "support/bodies.h"
#include "support/small_meshes.h"

#include <CGAL/Simple_cartesian.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sqmap {
namespace {

using CartesianKernel = CGAL::Simple_cartesian<double>;

std::vector<CartesianKernel::Triangle_3> triangles_of(const mesh::Mesh& m, const Affine& move)
{
    const auto corner = [&](std::uint32_t v) {
        const Vec3d p = apply(move, m.vertices[v]);
        return CartesianKernel::Point_3(p.x, p.y, p.z);
    };
    std::vector<CartesianKernel::Triangle_3> triangles;
    for (const mesh::Triangle& t : m.triangles) triangles.emplace_back(corner(t[0]), corner(t[1]), corner(t[2]));
    return triangles;
}

TEST(ClearanceAgainstCgal, IsTheLeastOfAllPairsOfTriangles)
{
    test::Random random(31);
    std::size_t apart = 0;
    for (int i = 0; i < 200; ++i) {
        const auto solid = [&] {
            return test::joined(
                {test::random_solid(random, i % 2 == 0), test::moved(test::random_solid(random, i % 2 == 0), {3, 1, -2})});
        };
        const mesh::Mesh a = i % 10 == 0 ? mesh::sphere(1, 1) : solid(), b = solid();
        const query::Probe probe_a(a.vertices, a.triangles), probe_b(b.vertices, b.triangles);
        const query::Body body_a{nullptr, &probe_a, {}}, body_b{nullptr, &probe_b, test::random_pose(random, 5)};
        const auto of_a = triangles_of(a, {}), of_b = triangles_of(b, query::b_in_a(body_a, body_b));
        double least = std::numeric_limits<double>::infinity();
        for (const auto& s : of_a)
            for (const auto& t : of_b) least = std::min(least, CGAL::squared_distance(s, t));
        const query::Clearance c = query::clearance(body_a, body_b);
        EXPECT_NEAR(c.distance, std::sqrt(least), 1e-9) << i;
        EXPECT_LE(c.at_least, std::sqrt(least) + 1e-9) << i;
        apart += least > 0 ? 1u : 0u;
    }
    EXPECT_GT(apart, 50u);
}

}  // namespace
}  // namespace sqmap
