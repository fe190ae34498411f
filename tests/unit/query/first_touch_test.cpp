#include "sqmap/query/first_touch.h"

#include "sqmap/query/contacts.h"
#include "sqmap/query/swept.h"
#include "support/bodies.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sqmap::query {
namespace {

MovingPoint still(Vec3d p) { return {p, p}; }

TEST(FirstTouch, APointMeetsATriangleWhenItGetsThere)
{
    const MovingPoint triangle[3] = {still({0, 0, 0}), still({4, 0, 0}), still({0, 4, 0})};
    const Touch through = first_touch({{1, 1, 3}, {1, 1, -1}}, triangle);
    EXPECT_TRUE(through.touches);
    EXPECT_LE(through.time, 0.75);
    EXPECT_GE(through.time, 0.75 - 2e-9);
    EXPECT_FALSE(first_touch({{3, 3, 3}, {3, 3, -1}}, triangle).touches) << "beside it";
    EXPECT_FALSE(first_touch({{1, 1, 3}, {1, 1, 1e-9}}, triangle).touches) << "not so far";
    EXPECT_TRUE(first_touch({{1, 1, 3}, {1, 1, 0}}, triangle).touches) << "at the end";
    EXPECT_TRUE(first_touch({{4, 0, 3}, {4, 0, -1}}, triangle).touches) << "through a corner";
    EXPECT_EQ(first_touch({{1, 1, 0}, {9, 9, 9}}, triangle).time, 0) << "from the beginning";
}

TEST(FirstTouch, AnEdgeMeetsAnEdgeWhenItGetsThere)
{
    const MovingPoint a[2] = {still({-1, 0, 0}), still({1, 0, 0})};
    const auto falling = [](Vec3d p, Vec3d q) {
        return std::array{MovingPoint{p + Vec3d{0, 0, 1}, p - Vec3d{0, 0, 3}},
                          MovingPoint{q + Vec3d{0, 0, 1}, q - Vec3d{0, 0, 3}}};
    };
    const auto touch = [&](Vec3d p, Vec3d q) {
        const auto f = falling(p, q);
        const MovingPoint b[2] = {f[0], f[1]};
        return first_touch(a, b);
    };
    EXPECT_NEAR(touch({0.5, -1, 0}, {0.5, 1, 0}).time, 0.25, 2e-9);
    EXPECT_TRUE(touch({1, -1, 0}, {1, 1, 0}).touches) << "at an end";
    EXPECT_TRUE(touch({-3, 0, 0}, {3, 0, 0}).touches) << "parallel, on it";
    EXPECT_FALSE(touch({-3, 1e-9, 0}, {3, 1e-9, 0}).touches) << "parallel, beside it";
    EXPECT_FALSE(touch({1.5, -1, 0}, {1.5, 1, 0}).touches);
}

TEST(FirstTouch, TimesAreNeitherLateNorMuchTooEarly)
{
    // A point against a plane that moves and turns little: the time by bisection of the exact height.
    test::Random random(3);
    int touched = 0;
    for (int i = 0; i < 2000; ++i) {
        const auto near = [&](Vec3d p) {
            return MovingPoint{p + random.in_box({-1, -1, -1}, {1, 1, 1}), p + random.in_box({-1, -1, -1}, {1, 1, 1})};
        };
        const MovingPoint triangle[3] = {near({-9, -9, 0}), near({9, -9, 0}), near({0, 9, 0})},
                          point = near({0, 0, random.between(0, 2)});
        const auto height = [&](double t) {
            const auto at = [&](const MovingPoint& m) { return m.from + t * (m.to - m.from); };
            const Vec3d a = at(triangle[0]);
            return dot(cross(at(triangle[1]) - a, at(triangle[2]) - a), at(point) - a);
        };
        double first = 2;
        for (int k = 0; k < 1000 && first > 1; ++k) {
            double lo = k * 1e-3, hi = lo + 1e-3;
            if (height(lo) * height(hi) > 0) continue;
            for (int step = 0; step < 60; ++step) (height(lo) * height(0.5 * (lo + hi)) <= 0 ? hi : lo) = 0.5 * (lo + hi);
            first = hi;
        }
        const Touch touch = first_touch(point, triangle);
        if (first > 1) continue;
        ++touched;
        ASSERT_TRUE(touch.touches);
        EXPECT_LE(touch.time, first + 1e-12);
        EXPECT_GE(touch.time, first - 1e-7);
    }
    EXPECT_GT(touched, 300);
}

TEST(FirstTouch, SeparationAndUntilAreKept)
{
    const MovingPoint triangle[3] = {still({0, 0, 0}), still({4, 0, 0}), still({0, 4, 0})};
    EXPECT_NEAR(first_touch({{1, 1, 3}, {1, 1, -1}}, triangle, {.separation = 1}).time, 0.5, 2e-9);
    EXPECT_FALSE(first_touch({{1, 1, 3}, {1, 1, -1}}, triangle, {.until = 0.5}).touches);
    EXPECT_TRUE(first_touch({{-0.5, 1, 3}, {-0.5, 1, -1}}, triangle, {.separation = 0.6}).touches);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(first_touch({{1, 1, nan}, {1, 1, -1}}, triangle).time, 0);
    EXPECT_TRUE(first_touch({{1, 1, nan}, {1, 1, -1}}, triangle).touches);
}

struct Shell {
    explicit Shell(mesh::Mesh m) : mesh(std::move(m)), probe(mesh.vertices, mesh.triangles) {}
    [[nodiscard]] Body at(const sqmap::Pose& pose = {}) const { return {nullptr, &probe, pose}; }
    mesh::Mesh mesh;
    Probe probe;
};

TEST(FirstTouchOfBodies, RidgesMeetInFlight)
{
    const Shell lower(test::diamond_bar(true, 3, 1, 0)), upper(test::diamond_bar(false, 3, 1, 0));
    const BodyTouch touch = first_touch(lower.at(), upper.at(test::shifted({0, 0, 4})), test::shifted({0, 0, -4}));
    EXPECT_TRUE(touch.touches);
    EXPECT_LE(touch.time, 0.25);
    EXPECT_GE(touch.time, 0.249);
    EXPECT_EQ(touch.status, k_ok);
    EXPECT_FALSE(first_touch(lower.at(), upper.at(test::shifted({0, 0, 4})), test::shifted({0, 0, 2.001})).touches);
    EXPECT_EQ(first_touch(lower.at(), upper.at(test::shifted({0, 0, 1})), test::shifted({0, 0, 5})).time, 0);
}

TEST(FirstTouchOfBodies, NoNeedleAndNoEdgePassesAThinPlate)
{
    const Shell plate(test::box({-1, -1, -0.001}, {1, 1, 0.001}));
    const mesh::Mesh needle =
        test::prism({{0, 0, -0.05}, {1e-4, 0, -0.05}, {0, 1e-4, -0.05}}, {{0, 0, 0.05}, {1e-4, 0, 0.05}, {0, 1e-4, 0.05}});
    const Shell thin(needle);
    test::Random random(9);
    for (int i = 0; i < 10000; ++i) {
        // From one side to the other, however it is turned, and across a side as often as through a face.
        const Pose from{test::rotation_about(random.direction(), random.between(0, 3)),
                        {random.between(-0.9, 0.9), random.between(-0.9, 0.9), 0.3}};
        const Pose to{test::rotation_about(random.direction(), random.between(0, 3)),
                      {random.between(-0.9, 0.9), random.between(-0.9, 0.9), -0.3}};
        const BodyTouch touch = first_touch(plate.at(), thin.at(from), to);
        ASSERT_TRUE(touch.touches) << i;
        // It is not late: until then nothing touches. And not early: a little later something does, or nearly.
        ContactWorkspace workspace(256);
        for (const double share : {0.25, 0.5, 0.75, 1.})
            EXPECT_TRUE(
                query_contacts(plate.at(), thin.at(between(from, to, share * touch.time)), {}, workspace).contacts.empty());
    }
}

TEST(FirstTouchOfBodies, NothingPassesWhereBothMoveAndNoTimeIsLate)
{
    // The plate turns and falls while needles come up.
    const Shell plate(test::box({-1, -1, -0.001}, {1, 1, 0.001}));
    const Shell thin(
        test::prism({{0, 0, -0.05}, {1e-4, 0, -0.05}, {0, 1e-4, -0.05}}, {{0, 0, 0.05}, {1e-4, 0, 0.05}, {0, 1e-4, 0.05}}));
    test::Random random(19);
    std::size_t touched = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vec3d axis = random.direction(), by{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
        const Pose plate_from = test::random_pose(random, 2);
        const Pose plate_to{test::rotation_about(axis, random.between(0, 2)) * plate_from.rotation, plate_from.translation + by};
        // From one side of the plate at the beginning to the other side at the end.
        const auto beside = [&](double z) {
            return Pose{test::rotation_about(random.direction(), random.between(0, 3)),
                        {random.between(-0.3, 0.3), random.between(-0.3, 0.3), z}};
        };
        const Pose from = compose(plate_from, beside(0.2)), to = compose(plate_to, beside(-0.2));
        const BodyTouch touch = first_touch(plate.at(plate_from), plate_to, thin.at(from), to);
        const BodyTouch other = first_touch(thin.at(from), to, plate.at(plate_from), plate_to);
        touched += touch.touches ? 1u : 0u;
        EXPECT_EQ(touch.touches, other.touches) << i;
        EXPECT_NEAR(touch.time, other.time, 2e-2) << i;
        ContactWorkspace workspace(256);
        for (const double share : {0.25, 0.5, 0.75, 1.}) {
            const double time = share * touch.time;
            EXPECT_TRUE(
                query_contacts(plate.at(between(plate_from, plate_to, time)), thin.at(between(from, to, time)), {}, workspace)
                    .contacts.empty())
                << i;
        }
    }
}

TEST(FirstTouchOfBodies, TheTimeIsThatOfTheFirstContact)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    test::Random random(10);
    ContactWorkspace workspace(4096);
    int touched = 0;
    for (int i = 0; i < 60; ++i) {
        const Pose from{test::rotation_about(random.direction(), random.between(0, 3)), 2.6 * random.direction()},
            to = test::random_pose(random, 0.5);
        const auto meets = [&](double share) {
            return !query_contacts(ring.at(), hand.at(between(from, to, share)), {.first_only = true}, workspace)
                        .contacts.empty();
        };
        const BodyTouch touch = first_touch(ring.at(), hand.at(from), to);
        double first = 2;
        for (int k = 0; k <= 2000 && first > 1; ++k)
            if (meets(k / 2000.)) first = k / 2000.;
        if (!touch.touches) {
            EXPECT_GT(first, 1);
            continue;
        }
        ++touched;
        EXPECT_LE(touch.time, first);
        EXPECT_GE(touch.time, std::min(first, 1.) - 0.0015) << "a thousandth and a step of the search";
    }
    EXPECT_GT(touched, 20);
}

TEST(FirstTouchOfBodies, BodiesThatCrossAtTheBeginningTouchAtTimeZero)
{
    // The needle stands through the plate: its ends and all corners of the plate are outside the other one.
    const Shell plate(test::box({-1, -1, -0.001}, {1, 1, 0.001}));
    const Shell needle(
        test::prism({{0, 0, -0.05}, {1e-4, 0, -0.05}, {0, 1e-4, -0.05}}, {{0, 0, 0.05}, {1e-4, 0, 0.05}, {0, 1e-4, 0.05}}));
    for (const Vec3d to : {Vec3d{0, 0, 0}, Vec3d{0.3, 0.1, 0}, Vec3d{0, 0, 2}})
        for (const Vec3d at : {Vec3d{0.111, 0.222, 0}, Vec3d{0.5, -0.5, 0.01}}) {
            const BodyTouch touch = first_touch(plate.at(), needle.at(test::shifted(at)), test::shifted(at + to));
            EXPECT_TRUE(touch.touches);
            EXPECT_EQ(touch.time, 0);
            EXPECT_EQ(touch.status, k_ok);
        }
}

TEST(FirstTouchOfBodies, BadInputHasAStatus)
{
    const Shell cube(test::box({-1, -1, -1}, {1, 1, 1}));
    const BodyTouch jump = first_touch(cube.at(), cube.at(test::shifted({0, 0, 1e154})), test::shifted({0, 0, -1e154}));
    EXPECT_EQ(jump.status, k_not_finite);
    EXPECT_TRUE(jump.touches);
    EXPECT_EQ(jump.time, 0);
    const Shell box(test::box({0, 0, 0}, {1, 1, 1}));
    const Probe points(box.mesh.vertices);
    sqmap::Pose nowhere;
    nowhere.translation.y = std::numeric_limits<double>::quiet_NaN();
    const BodyTouch lost = first_touch(box.at(), box.at(test::shifted({3, 0, 0})), nowhere);
    EXPECT_EQ(lost.status, k_not_finite);
    EXPECT_TRUE(lost.touches);
    EXPECT_EQ(lost.time, 0);
    EXPECT_EQ(first_touch(box.at(), {nullptr, &points, {}}, {}).status, k_no_triangles);
}

}  // namespace
}  // namespace sqmap::query
