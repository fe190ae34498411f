#include "sqmap/query/swept.h"

#include "support/bodies.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace sqmap::query {
namespace {

constexpr double k_half_thickness = 0.04;

const test::Parsed& plate()
{
    static const test::Parsed k_plate = [] {
        mesh::Mesh m = test::cube();
        for (Vec3d& v : m.vertices) v.y *= k_half_thickness;
        return test::Parsed(m);
    }();
    return k_plate;
}

std::vector<Vec3d> grid_at(double y, double half, int n)
{
    std::vector<Vec3d> points;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) points.push_back({half * (2.0 * i / (n - 1) - 1), y, half * (2.0 * j / (n - 1) - 1)});
    return points;
}

struct Swept {
    SweptResult result;
    std::vector<Contact> contacts;
};

Swept answer_of(const model::ModelView& view, std::span<const Vec3d> previous, std::span<const Vec3d> now, double step,
                const Pose& from = {}, const Pose& to = {})
{
    Probe probe(now);
    SweptWorkspace workspace(now.size());
    Swept out;
    out.contacts.resize(now.size());
    SweptOptions options;
    options.step = step;
    out.result = query_swept({{.model = &view}, &probe, from, to, previous, now}, options, workspace, out.contacts);
    out.contacts.resize(std::min(out.contacts.size(), out.result.probe.contacts));
    std::sort(out.contacts.begin(), out.contacts.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
    return out;
}

TEST(Swept, PosesBetweenTwoAreExactAtTheEndsAndTurnEvenly)
{
    test::Random random(5);
    for (int i = 0; i < 50; ++i) {
        const Vec3d axis = random.direction();
        const double angle = random.between(0.01, 3.1);
        const Pose from = test::random_pose(random, 2), to{test::rotation_about(axis, angle) * from.rotation, {1, 2, 3}};
        EXPECT_EQ(between(from, to, 0).rotation, from.rotation);
        EXPECT_EQ(between(from, to, 1).translation, to.translation);
        const Pose third = between(from, to, 1.0 / 3);
        const Mat3d expected = test::rotation_about(axis, angle / 3) * from.rotation;
        for (int k = 0; k < 3; ++k) EXPECT_LT(norm(third.rotation.row[k] - expected.row[k]), 1e-9);
    }
    const Pose half = between({}, {{{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}}, {}}, 0.5);
    EXPECT_NEAR(std::abs(half.rotation.row[0].z), 1, 1e-9);
    EXPECT_NEAR(half.rotation.row[1].y, 1, 1e-9);
}

TEST(Swept, PointsThatJumpOverAThinPlateAreCaughtOnTheSideTheyCameFrom)
{
    const std::vector<Vec3d> above = grid_at(0.31, 0.8, 20), below = grid_at(-0.29, 0.8, 20);
    EXPECT_EQ(answer_of(plate().view(), above, below, 10).result.probe.contacts, 0u);  // a frame alone sees nothing
    const Swept swept = answer_of(plate().view(), above, below, 2 * k_half_thickness);
    ASSERT_EQ(swept.contacts.size(), above.size());
    EXPECT_EQ(swept.result.caught, above.size());
    for (const Contact& c : swept.contacts) {
        EXPECT_GT(c.normal.y, 0.99f);
        EXPECT_NEAR(c.depth, 0.29 + k_half_thickness, 0.01);
    }
    for (const Contact& c : answer_of(plate().view(), below, above, 2 * k_half_thickness).contacts) EXPECT_LT(c.normal.y, -0.99f);
}

TEST(Swept, APlateThatJumpsOverPointsCatchesThemToo)
{
    const std::vector<Vec3d> points = grid_at(0, 0.5, 12);
    // From 0.31, not 0.3: at whole steps of 0.04 from there the plate's two sides would lie exactly on the points.
    const Swept swept = answer_of(plate().view(), points, points, 2 * k_half_thickness, {{}, {0, 0.31, 0}}, {{}, {0, -0.29, 0}});
    ASSERT_EQ(swept.contacts.size(), points.size());
    for (const Contact& c : swept.contacts) EXPECT_GT(c.normal.y, 0.99f);
}

TEST(Swept, PointsThatPassBesideOrRestInsideAnswerAsAFrameDoes)
{
    const std::vector<Vec3d> from = grid_at(0.2, 0.8, 10), to = grid_at(0.06, 0.8, 10);
    EXPECT_EQ(answer_of(plate().view(), from, to, 0.05).result.probe.contacts, 0u);
    const std::vector<Vec3d> inside = grid_at(0.02, 0.8, 10);
    const Swept swept = answer_of(plate().view(), from, inside, 0.05), frame = answer_of(plate().view(), inside, inside, 0.05);
    ASSERT_EQ(swept.contacts.size(), inside.size());
    EXPECT_EQ(swept.result.caught, 0u);
    for (std::size_t i = 0; i < inside.size(); ++i) {
        EXPECT_EQ(swept.contacts[i].normal, frame.contacts[i].normal);
        EXPECT_EQ(swept.contacts[i].depth, frame.contacts[i].depth);
    }
}

TEST(Swept, AWayOfMoreThanTheMostStepsSaysSo)
{
    const std::vector<Vec3d> above = grid_at(50, 0.8, 4), below = grid_at(-50, 0.8, 4);
    EXPECT_NE(answer_of(plate().view(), above, below, 0.05).result.probe.status & k_coarse, 0);
    EXPECT_EQ(answer_of(plate().view(), above, below, 5).result.probe.status & k_coarse, 0);
}

TEST(Swept, APointThatIsNotFiniteHasNoContact)
{
    std::vector<Vec3d> above = grid_at(0.3, 0.8, 8), below = grid_at(-0.3, 0.8, 8);
    const std::size_t all = above.size();
    below[5].y = std::numeric_limits<double>::quiet_NaN();
    Probe probe(above);
    probe.move(below);
    SweptWorkspace workspace(all);
    std::vector<Contact> contacts(all);
    SweptOptions options;
    options.step = 0.05;
    const SweptResult result =
        query_swept({{.model = &plate().view()}, &probe, {}, {}, above, below}, options, workspace, contacts);
    for (const Contact& c : std::span(contacts).first(result.probe.contacts)) EXPECT_NE(c.index, 5u);
}

class MovedProbe : public testing::Test {
protected:
    static const test::Parsed& hand()
    {
        static const test::Parsed k_hand(test::small_hand());
        return k_hand;
    }
    static std::vector<Contact> contacts(const Probe& probe)
    {
        std::vector<Contact> out(4 * probe.size());
        out.resize(query_probe({.model = &hand().view()}, {.probe = &probe}, {}, out).contacts);
        std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
        return out;
    }
    static Vec3d hand_point(test::Random& random)
    {
        const auto& v = hand().mesh().vertices;
        const auto& h = hand().view().header;
        return Vec3d{h.origin[0], h.origin[1], h.origin[2]} + h.unit * (v[random.below(v.size())] + 0.1 * random.direction());
    }
    static std::vector<Vec3d> cloud(std::uint64_t seed, std::size_t n)
    {
        test::Random random(seed);
        std::vector<Vec3d> points;
        for (std::size_t i = 0; i < n; ++i) points.push_back(hand_point(random));
        return points;
    }
};

TEST_F(MovedProbe, AnswersAsOneBuiltWhereItIs)
{
    const std::vector<Vec3d> before = cloud(1, 1000), after = cloud(2, 1000);
    Probe moved(before);
    moved.move(after);
    const auto a = contacts(moved), b = contacts(Probe(after));
    ASSERT_GT(b.size(), 20u);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a[i].index, b[i].index);
        EXPECT_LT(norm(a[i].normal - b[i].normal), 1e-3f);  // places are rounded about another centre
        EXPECT_NEAR(a[i].depth, b[i].depth, 1e-5f);
    }
}

TEST_F(MovedProbe, AsksOnlyThePointsItIsToldTo)
{
    const std::vector<Vec3d> points = cloud(3, 1000);
    test::Random random(4);
    for (const double share : {0.0, 0.02, 0.5}) {
        std::vector<std::uint8_t> answer(points.size());
        for (auto& a : answer) a = random.uniform() < share ? 1 : 0;
        Probe probe(points);
        const auto all = contacts(probe);
        probe.move(points, answer);
        std::vector<std::uint32_t> expected, found;
        for (const auto& c : all)
            if (answer[c.index] != 0) expected.push_back(c.index);
        for (const auto& c : contacts(probe))
            if (answer[c.index] != 0) found.push_back(c.index);
        EXPECT_EQ(found, expected) << share;
    }
}

TEST_F(MovedProbe, ReachesWhatItHoldsAndNotWhatIsFar)
{
    const std::vector<Vec3d> points = cloud(7, 500);
    Probe probe(cloud(8, 500));
    probe.move(points);
    test::Random random(9);
    for (int i = 0; i < 300; ++i) {
        const Sphere sphere{random.in_box({-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5}), random.between(0.001, 0.4)};
        const bool holds =
            std::any_of(points.begin(), points.end(), [&](Vec3d p) { return norm(p - sphere.centre) <= sphere.radius; });
        if (holds) {
            EXPECT_TRUE(probe.reaches(sphere));
        }
    }
    EXPECT_FALSE(probe.reaches({{9, 0, 0}, 0.5}));
}

}  // namespace
}  // namespace sqmap::query
