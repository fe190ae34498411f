#include "sqmap/query/overlap.h"

#include "sqmap/query/point.h"

#include "support/bodies.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace sqmap::query {
namespace {

struct Shell {
    explicit Shell(mesh::Mesh m) : mesh(std::move(m)), probe(mesh.vertices, mesh.triangles) {}
    [[nodiscard]] Body at(const sqmap::Pose& pose = {}) const { return {nullptr, &probe, pose}; }
    mesh::Mesh mesh;
    Probe probe;
};

Overlap overlap_of(const Shell& a, const Shell& b, const sqmap::Pose& pose, const sqmap::Pose& world = {})
{
    OverlapWorkspace workspace(a.probe, b.probe);
    return overlap(a.at(world), b.at(compose(world, pose)), workspace);
}

TEST(Overlap, OfBoxesIsTheProductOfTheirSharedSides)
{
    const Shell box(test::box({0, 0, 0}, {2, 3, 1}));
    test::Random random(1);
    for (int i = 0; i < 100; ++i) {
        const Vec3d by = random.in_box({-2.5, -3.5, -1.5}, {2.5, 3.5, 1.5});
        const double expected =
            std::max(2 - std::abs(by.x), 0.) * std::max(3 - std::abs(by.y), 0.) * std::max(1 - std::abs(by.z), 0.);
        const sqmap::Pose world = test::random_pose(random, 5);
        EXPECT_NEAR(overlap_of(box, box, test::shifted(by), world).volume, expected, 1e-12);
    }
}

TEST(Overlap, OfFacesInOnePlaneIsKnownWithinItsError)
{
    const Shell box(test::box({0, 0, 0}, {2, 2, 1}));
    for (const auto& [by, expected] : {std::pair<Vec3d, double>{{0, 0, 0}, 4},
                                       {{0, 0, 0.5}, 2},
                                       {{1, 0, 0}, 2},
                                       {{1, 1, 0.5}, 0.5},
                                       {{0, 0, 1}, 0},
                                       {{2, 2, 1}, 0}}) {
        const Overlap o = overlap_of(box, box, test::shifted(by));
        EXPECT_EQ(o.status, k_ok);
        EXPECT_NEAR(o.volume, expected, o.error + 1e-12);
        EXPECT_LE(o.error, 1e-10);
    }
}

TEST(Overlap, OfASolidWithinAnotherIsItsVolume)
{
    const Shell outer(test::box({-2, -2, -2}, {2, 2, 2})), inner(test::small_torus()),
        two(test::joined({test::box({0, 0, 0}, {1, 1, 1}), test::box({9, 0, 0}, {10, 1, 1})}));
    double volume = 0;
    for (const mesh::Triangle& t : inner.mesh.triangles)
        volume += dot(inner.mesh.vertices[t[0]], cross(inner.mesh.vertices[t[1]], inner.mesh.vertices[t[2]])) / 6;
    EXPECT_NEAR(overlap_of(outer, inner, {}).volume, volume, 1e-12);
    EXPECT_NEAR(overlap_of(inner, outer, {}).volume, volume, 1e-12);
    EXPECT_NEAR(overlap_of(outer, two, {}).volume, 1, 1e-12) << "one of two pieces";
    EXPECT_EQ(overlap_of(outer, inner, test::shifted({0, 0, 50})).volume, 0);
    EXPECT_NEAR(overlap_of(inner, inner, {}).volume, volume, 1e-9);
}

TEST(Overlap, OfMeshesIsThatOfTheirPoints)
{
    // The share of random points of a box that are in both, by the exact layer: three standard deviations.
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    test::Random random(2);
    OverlapWorkspace workspace(ring.probe, hand.probe), swapped(hand.probe, ring.probe);
    for (int i = 0; i < 5; ++i) {
        const Body a = ring.at(), b = hand.at(test::random_pose(random, 0.4));
        const Overlap o = overlap(a, b, workspace);
        constexpr int k_points = 40000;
        const double box = 2.6 * 2.6 * 0.6;
        int inside = 0;
        for (int k = 0; k < k_points; ++k) {
            const Vec3d p = random.in_box({-1.3, -1.3, -0.3}, {1.3, 1.3, 0.3});
            const QueryOptions exact{.layer = Layer::Exact};
            inside += query_point(a, p, exact).contact && query_point(b, p, exact).contact ? 1 : 0;
        }
        const double share = static_cast<double>(inside) / k_points;
        EXPECT_NEAR(o.volume, box * share, 3 * box * std::sqrt(share / k_points) + 1e-4);
        EXPECT_NEAR(overlap(b, a, swapped).volume, o.volume, 1e-9);
    }
}

TEST(Overlap, BadInputHasAStatus)
{
    const Shell box(test::box({0, 0, 0}, {1, 1, 1})), torus(test::small_torus());
    const Probe points(box.mesh.vertices);
    sqmap::Pose nowhere;
    nowhere.rotation.row[1].y = std::numeric_limits<double>::infinity();
    OverlapWorkspace workspace(box.probe, box.probe);
    EXPECT_EQ(overlap(box.at(), box.at(nowhere), workspace).status, k_not_finite);
    EXPECT_EQ(overlap(box.at(), {nullptr, &points, {}}, workspace).status, k_no_triangles);
    EXPECT_EQ(overlap(box.at(), torus.at(), workspace).status, k_full);
}

}  // namespace
}  // namespace sqmap::query
