#include "sqmap/query/clearance.h"

#include "sqmap/math/box.h"

#include "support/bodies.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::query {
namespace {

/// A mesh and the probe of its triangles, without a model.
struct Closed {
    explicit Closed(mesh::Mesh m) : mesh(std::move(m)), probe(mesh.vertices, mesh.triangles) {}
    [[nodiscard]] Body at(const sqmap::Pose& pose = {}) const { return {nullptr, &probe, pose}; }
    mesh::Mesh mesh;
    Probe probe;
};

/// How far all of b is beyond all of a along a unit direction.
double gap_of_all(const mesh::Mesh& a, const sqmap::Pose& pose_a, const mesh::Mesh& b, const sqmap::Pose& pose_b, Vec3d direction)
{
    double high = -std::numeric_limits<double>::infinity(), low = -high;
    for (const Vec3d& v : a.vertices) high = std::max(high, dot(direction, apply(pose_a, v)));
    for (const Vec3d& v : b.vertices) low = std::min(low, dot(direction, apply(pose_b, v)));
    return low - high;
}

void expect_is_known(const Clearance& c, double distance)
{
    EXPECT_NEAR(c.distance, distance, 1e-13);
    EXPECT_LE(c.at_least, c.distance);
    EXPECT_GE(c.at_least, distance - 1e-12);
    EXPECT_NEAR(norm(c.witness.on_b - c.witness.on_a), c.distance, 1e-13);
    EXPECT_EQ(c.status, k_ok);
}

TEST(Clearance, OfFacesEdgesAndCornersIsAsByHand)
{
    const Closed cube(test::box({0, 0, 0}, {1, 1, 1}));
    expect_is_known(clearance(cube.at(), cube.at(test::shifted({3.5, 0.25, 0.5}))), 2.5);
    expect_is_known(clearance(cube.at(), cube.at(test::shifted({2, 2, 0.3}))), std::sqrt(2.));
    expect_is_known(clearance(cube.at(), cube.at(test::shifted({2, -2, 3}))), std::sqrt(1. + 1. + 4.));
    // Ridges that cross, with no vertex near.
    const Closed lower(test::diamond_bar(true, 3, 1, 0)), upper(test::diamond_bar(false, 3, 1, 2.5));
    const Vec3d by{5, -2, 1};
    const Clearance c = clearance(lower.at(test::shifted(by)), upper.at(test::shifted(by)));
    expect_is_known(c, 0.5);
    EXPECT_LE(norm(c.witness.on_a - (by + Vec3d{0, 0, 1})), 1e-12);
    EXPECT_LE(norm(c.witness.on_b - (by + Vec3d{0, 0, 1.5})), 1e-12);
}

TEST(Clearance, OfConvexSolidsIsTheGapAlongItsDirection)
{
    // A direction along which all of b is as far beyond all of a proves that nothing is nearer.
    test::Random random(21);
    const Closed ball(mesh::sphere(1, 4));
    std::size_t apart = 0;
    for (int i = 0; i < 300; ++i) {
        const Closed a(test::random_solid(random, i % 2 == 0));
        const Closed own(test::random_solid(random, i % 4 == 0));
        const Closed& b = i % 3 == 0 ? ball : own;
        const sqmap::Pose pose_a = test::random_pose(random, 3), pose_b = test::random_pose(random, 3);
        const Clearance c = clearance(a.at(pose_a), b.at(pose_b));
        if (c.distance == 0) continue;
        ++apart;
        const Vec3d direction = (c.witness.on_b - c.witness.on_a) / c.distance;
        EXPECT_NEAR(gap_of_all(a.mesh, pose_a, b.mesh, pose_b, direction), c.distance, 1e-9) << i;
        EXPECT_GE(c.at_least, c.distance - 1e-9) << i;
        const Clearance turned = clearance(b.at(pose_b), a.at(pose_a));
        EXPECT_NEAR(turned.distance, c.distance, 1e-12) << i;
        EXPECT_TRUE(is_within(a.at(pose_a), b.at(pose_b), c.distance * (1 + 1e-9)));
        EXPECT_FALSE(is_within(a.at(pose_a), b.at(pose_b), c.at_least * (1 - 1e-9)));
    }
    EXPECT_GT(apart, 150u);
}

TEST(Clearance, OfManyPiecesIsTheLeastOfTheirs)
{
    test::Random random(22);
    for (int i = 0; i < 20; ++i) {
        const auto pieces = [&](double x) {
            std::vector<mesh::Mesh> all;
            for (int k = 0; k < 12; ++k)
                all.push_back(test::moved(test::random_solid(random, false), {x, random.between(-8, 8), random.between(-8, 8)}));
            return all;
        };
        const std::vector<mesh::Mesh> a = pieces(-4), b = pieces(4);
        const Closed all_a(test::joined(a)), all_b(test::joined(b));
        const sqmap::Pose pose = test::random_pose(random, 0.5);
        double least = std::numeric_limits<double>::infinity();
        for (const mesh::Mesh& p : a)
            for (const mesh::Mesh& q : b) least = std::min(least, clearance(Closed(p).at(), Closed(q).at(pose)).distance);
        EXPECT_NEAR(clearance(all_a.at(), all_b.at(pose)).distance, least, 1e-13);
    }
}

TEST(Clearance, IsZeroWhereSolidsHaveAPointInCommon)
{
    const Closed cube(test::box({0, 0, 0}, {1, 1, 1})), needle(test::box({0.4, 0.4, -1}, {0.6, 0.6, 2}));
    for (const sqmap::Pose& pose :
         {sqmap::Pose{}, test::shifted({1, 0, 0}), test::shifted({1, 1, 1}), test::shifted({0.5, 0.2, 0.1})}) {
        const Clearance c = clearance(cube.at(), cube.at(pose));
        EXPECT_EQ(c.distance, 0);
        EXPECT_EQ(c.at_least, 0);
        EXPECT_EQ(c.witness.on_a, c.witness.on_b);
        EXPECT_TRUE(is_within(cube.at(), cube.at(pose), 0));
    }
    const Clearance through = clearance(cube.at(), needle.at());
    EXPECT_EQ(through.distance, 0);
    EXPECT_TRUE(contains(box_of(needle.mesh.vertices), through.witness.on_a));
    // One within the other: by its model, never without.
    const test::Solid ball(mesh::sphere(1, 3));
    const Closed small(mesh::sphere(0.25, 2));
    const Clearance inside = clearance(ball.at(), small.at(test::shifted({0.1, 0, 0})));
    EXPECT_EQ(inside.distance, 0);
    EXPECT_EQ(inside.triangle_a, k_unnamed);
    EXPECT_LE(norm(inside.witness.on_a), 1);
    EXPECT_TRUE(is_within(small.at(), ball.at(), 0));
    EXPECT_GT(clearance(Closed(ball.mesh).at(), small.at()).distance, 0.7);
}

TEST(Clearance, IsKnownWhereSolidsNearlyTouch)
{
    const test::Solid box(test::box({-0.5, -0.5, 0}, {0.5, 0.5, 1})), ball(mesh::sphere(0.5, 3));
    test::Random random(23);
    for (int i = 0; i < 60; ++i)
        for (const double gap : {1e-14, 1e-11, 1e-9, 1e-8, 3e-8, 1e-7, 1e-6}) {
            const sqmap::Pose frame = test::random_pose(random, 3);
            const double turn = random.between(0, 6);
            const test::Solid& upper = i % 2 == 0 ? box : ball;
            const double foot = gap_of_all(box.mesh, {}, upper.mesh, {}, {0, 0, 1}) + 1;  // of the upper one
            const sqmap::Pose above{frame.rotation * test::rotation_about({0, 0, 1}, turn),
                                    apply(frame, {random.between(-0.2, 0.2), random.between(-0.2, 0.2), 1 + gap - foot})};
            const Clearance c = clearance(box.at(frame), upper.at(above));
            EXPECT_NEAR(c.distance, gap, 1e-14);
            EXPECT_LE(c.at_least, gap + 1e-14);
            EXPECT_GE(c.at_least, (1 - 1e-8) * gap - 3e-13);
            if (gap < 1e-13) continue;
            EXPECT_FALSE(is_within(box.at(frame), upper.at(above), 0.5 * gap));
            // As close, but within.
            const double part = 1 - 2 * gap;
            mesh::Mesh smaller = box.mesh;
            for (Vec3d& v : smaller.vertices) v = part * v + Vec3d{0, 0, gap};
            const Closed kernel(std::move(smaller));
            EXPECT_EQ(clearance(box.at(frame), kernel.at(frame)).distance, 0);
            EXPECT_TRUE(is_within(kernel.at(frame), box.at(frame), 0.25 * gap));
        }
}

TEST(Clearance, IsKnownFarAwayAndAtAnySize)
{
    const Closed cube(test::box({0, 0, 0}, {1, 1, 1})), ball(mesh::sphere(1, 4));
    for (const double far : {1e3, 1e6, 1e9, 1e12, 1e15, 1e25, 1e60}) {
        const Clearance c = clearance(cube.at(), ball.at(test::shifted({far, 0.5, 0.5})));
        EXPECT_NEAR(c.distance, far - 2, 1e-3 + 1e-14 * far);
        EXPECT_GE(c.at_least, far - 2 - 1e-3 - 1e-13 * far);
    }
    for (const double scale : {1e-9, 1e9}) {
        mesh::Mesh m = cube.mesh;
        for (Vec3d& v : m.vertices) v = scale * v;
        const Closed scaled(std::move(m));
        EXPECT_NEAR(clearance(scaled.at(), scaled.at(test::shifted({1.5 * scale, 0, 0}))).distance / scale, 0.5, 1e-13);
    }
}

TEST(Clearance, SaysWhyThereIsNone)
{
    const Closed cube(test::box({0, 0, 0}, {1, 1, 1}));
    const Probe points(cube.mesh.vertices);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(clearance(cube.at(), cube.at(test::shifted({nan, 0, 0}))).status, k_not_finite);
    EXPECT_EQ(clearance(cube.at(), {nullptr, &points, {}}).status, k_no_triangles);
    EXPECT_EQ(clearance({}, cube.at()).status, k_no_triangles);
    EXPECT_FALSE(is_within(cube.at(), cube.at(test::shifted({nan, 0, 0})), 1));
    EXPECT_FALSE(is_within(cube.at(), {nullptr, &points, {}}, 1));
    EXPECT_FALSE(is_within(cube.at(), cube.at(), -1));
    EXPECT_FALSE(is_within(cube.at(), cube.at(), nan));
    EXPECT_TRUE(is_within(cube.at(), cube.at(test::shifted({5, 0, 0})), std::numeric_limits<double>::infinity()));
}

}  // namespace
}  // namespace sqmap::query
