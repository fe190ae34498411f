#include "sqmap/query/separating.h"

#include "query/probe/triangle_tree.h"
#include "sqmap/query/overlap.h"

#include "support/bodies.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sqmap::query {
namespace {

struct Piece {
    explicit Piece(mesh::Mesh m) : mesh(std::move(m)), probe(mesh.vertices, mesh.triangles) {}
    [[nodiscard]] Body at(const sqmap::Pose& pose = {}) const { return {nullptr, &probe, pose}; }
    mesh::Mesh mesh;
    Probe probe;
};

double sizes_of(const Body& a, const Body& b)
{
    return norm(size(a.probe->triangles().box())) + norm(size(b.probe->triangles().box()));
}

/// Complete contacts and the volume they share, after b is moved.
bool is_free_after(const Body& a, const Body& b, Vec3d by)
{
    Body moved = b;
    moved.pose.translation += by;
    ContactWorkspace space(4096);
    OverlapWorkspace overlap_space(*a.probe, *b.probe);
    return query_contacts(a, moved, {}, space).meetings == 0 && overlap(a, moved, overlap_space).volume < 1e-12;
}

void expect_separates(const Body& a, const Body& b, const SeparatingTranslation& s)
{
    ASSERT_EQ(s.status, k_ok);
    EXPECT_NEAR(norm(s.direction), 1, 1e-14);
    EXPECT_LE(s.at_least, s.distance);
    const double sizes = sizes_of(a, b);
    EXPECT_TRUE(is_free_after(a, b, (s.distance + 1e-9 * sizes) * s.direction)) << s.distance;
    if (s.exact && s.distance > 0) {
        EXPECT_LE(s.distance - s.at_least, 1e-10 * sizes);
        EXPECT_FALSE(is_free_after(a, b, (s.at_least - 1e-6 * sizes) * s.direction)) << s.distance;
    }
}

TEST(SeparatingTranslation, OfBoxesIsTheLeastOfTheirSharedSides)
{
    const Piece box(test::box({0, 0, 0}, {2, 3, 1}));
    SeparatingWorkspace space(box.probe, box.probe);
    test::Random random(1);
    for (int i = 0; i < 200; ++i) {
        const Vec3d by = random.in_box({-2.5, -3.5, -1.5}, {2.5, 3.5, 1.5});
        const double shared[3] = {2 - std::abs(by.x), 3 - std::abs(by.y), 1 - std::abs(by.z)};
        const double expected = std::max(std::min({shared[0], shared[1], shared[2]}), 0.);
        const sqmap::Pose world = test::random_pose(random, 5);
        const Body a = box.at(world), b = box.at(compose(world, test::shifted(by)));
        const SeparatingTranslation s = least_separating_translation(a, b, space);
        EXPECT_NEAR(s.distance, expected, 1e-11);
        EXPECT_TRUE(s.exact);
        expect_separates(a, b, s);
        for (int k = 0; k < 3; ++k) {
            Vec3d axis{};
            axis[k] = by[k] < 0 ? -3 : 3;
            const SeparatingTranslation along = separating_translation(a, b, world.rotation * axis, space);
            EXPECT_NEAR(along.distance, expected == 0 ? 0 : shared[k], 1e-11);
            EXPECT_TRUE(along.exact);
        }
    }
}

TEST(SeparatingTranslation, OfFacesInOnePlaneIsKnown)
{
    const Piece wall(test::box({0, 0, 0}, {4, 0.2, 3}));  // walls in one plane that overlap by 50 mm
    SeparatingWorkspace space(wall.probe, wall.probe);
    const Body a = wall.at(), b = wall.at(test::shifted({3.95, 0, 0}));
    const SeparatingTranslation least = least_separating_translation(a, b, space);
    EXPECT_NEAR(least.distance, 0.05, 1e-12);
    EXPECT_TRUE(least.exact);
    EXPECT_NEAR(least.direction.x, 1, 1e-12);
    expect_separates(a, b, least);
    EXPECT_NEAR(separating_translation(a, b, {0, 1, 0}, space).distance, 0.2, 1e-12);
    EXPECT_NEAR(separating_translation(a, b, {-1, 0, 0}, space).distance, 7.95, 1e-12);
    EXPECT_EQ(separating_translation(a, wall.at(test::shifted({4, 0, 0})), {1, 0, 0}, space).distance, 0) << "they only touch";
}

TEST(SeparatingTranslation, OfConvexSolidsIsShorterThanAlongAnyDirection)
{
    test::Random random(3);
    for (int i = 0; i < 60; ++i) {
        const Piece one(test::random_solid(random, i % 2 == 0)), other(test::random_solid(random, i % 2 == 0));
        if (find_fault(one.mesh.vertices, one.mesh.triangles).kind != TriangleFault::Kind::None ||
            find_fault(other.mesh.vertices, other.mesh.triangles).kind != TriangleFault::Kind::None)
            continue;
        SeparatingWorkspace space(one.probe, other.probe);
        const Body a = one.at(), b = other.at(test::random_pose(random, 1));
        const SeparatingTranslation least = least_separating_translation(a, b, space);
        expect_separates(a, b, least);
        for (int k = 0; k < 30; ++k) {
            const SeparatingTranslation along = separating_translation(a, b, random.direction(), space);
            expect_separates(a, b, along);
            EXPECT_GE(along.distance, least.at_least - 1e-11);
        }
    }
}

TEST(SeparatingTranslation, OfABoxFromABallOfManyTrianglesStaysInItsWorkspace)
{
    const Piece cube(test::box({-1, -1, -1}, {1, 1, 1})), ball(mesh::sphere(1, 4));
    for (const bool is_turned : {false, true}) {
        const Piece &one = is_turned ? ball : cube, &other = is_turned ? cube : ball;
        SeparatingWorkspace space(one.probe, other.probe);
        const Body a = one.at(), b = other.at(test::shifted({1.9, 0, 0}));
        const SeparatingTranslation least = least_separating_translation(a, b, space);
        EXPECT_TRUE(least.exact);
        EXPECT_NEAR(least.distance, 0.1, 2e-3);
    }
}

TEST(SeparatingTranslation, LeavesHollowsAndGoesOnWhereOneIsWithinTheOther)
{
    const Piece torus(test::small_torus()), bead(test::box({-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05}));
    SeparatingWorkspace space(torus.probe, bead.probe);
    // A bead within the tube leaves it along z; in the middle of the ring it is free.
    const Body within = bead.at(test::shifted({1, 0, 0}));
    const SeparatingTranslation up = separating_translation(torus.at(), within, {0, 0, 1}, space);
    EXPECT_GT(up.distance, 0.05);
    expect_separates(torus.at(), within, up);
    EXPECT_EQ(separating_translation(torus.at(), bead.at(), {1, 0, 0}, space).distance, 0);
    // Towards the middle it ends in the hole, and does not cross the other side of the ring.
    const SeparatingTranslation in = separating_translation(torus.at(), within, {-1, 0, 0}, space);
    EXPECT_LT(in.distance, 1);
    expect_separates(torus.at(), within, in);
    const Piece outer(test::box({-2, -2, -2}, {2, 2, 2})), inner(test::box({-1, -1, -1}, {1, 1, 1}));
    SeparatingWorkspace boxes(outer.probe, inner.probe);
    EXPECT_NEAR(separating_translation(outer.at(), inner.at(), {0, -5, 0}, boxes).distance, 3, 1e-12);
    EXPECT_NEAR(least_separating_translation(inner.at(), outer.at(), boxes).distance, 3, 1e-12);
}

TEST(SeparatingTranslation, OfMeshesIsBoundedFromBothSides)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    SeparatingWorkspace space(ring.probe, hand.probe);
    test::Random random(2);
    int bounded = 0;
    for (int i = 0; i < 20; ++i) {
        const Body a = ring.at(), b = hand.at(test::random_pose(random, 0.6));
        const SeparatingTranslation least = least_separating_translation(a, b, space);
        expect_separates(a, b, least);
        bounded += least.at_least > 0 ? 1 : 0;
        for (int k = 0; k < 5; ++k) {
            const SeparatingTranslation along = separating_translation(a, b, random.direction(), space);
            expect_separates(a, b, along);
            EXPECT_GE(along.distance, least.at_least);
        }
    }
    EXPECT_GT(bounded, 5);
}

TEST(SeparatingTranslation, BadInputHasAStatus)
{
    const Piece box(test::box({0, 0, 0}, {1, 1, 1})), torus(test::small_torus());
    const Probe points(box.mesh.vertices);
    constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
    SeparatingWorkspace space(box.probe, box.probe);
    EXPECT_EQ(separating_translation(box.at(), box.at(test::shifted({k_nan, 0, 0})), {1, 0, 0}, space).status, k_not_finite);
    EXPECT_EQ(separating_translation(box.at(), box.at(), {0, 0, 0}, space).status, k_not_finite);
    EXPECT_EQ(separating_translation(box.at(), box.at(), {k_nan, 0, 1}, space).status, k_not_finite);
    EXPECT_EQ(least_separating_translation(box.at(), {nullptr, &points, {}}, space).status, k_no_triangles);
    EXPECT_EQ(least_separating_translation(box.at(), torus.at(), space).status, k_full);
    EXPECT_EQ(separating_translation(box.at(), box.at(test::shifted({1e200, 0, 0})), {1, 0, 0}, space).status, k_not_finite);
    EXPECT_NEAR(separating_translation(box.at(), box.at(), {1e-200, 0, 0}, space).distance, 1, 1e-12);
}

}  // namespace
}  // namespace sqmap::query
