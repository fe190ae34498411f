#include "sqmap/query/pair.h"

#include "support/bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <tuple>

namespace sqmap::query {
namespace {

std::vector<PairContact> queried(const Body& a, const Body& b, const PairOptions& options = {}, PairResult* result = nullptr)
{
    PairWorkspace workspace(4096);
    PairResult r = query_pair(a, b, options, workspace);
    EXPECT_LE(r.contacts.size(), r.found);
    const std::vector<PairContact> contacts(r.contacts.begin(), r.contacts.end());
    r.contacts = {};  // the workspace ends here
    if (result != nullptr) *result = r;
    return contacts;
}

const PairContact& deepest(const std::vector<PairContact>& contacts)
{
    return *std::max_element(contacts.begin(), contacts.end(),
                             [](const PairContact& a, const PairContact& b) { return a.depth < b.depth; });
}

const PairOptions k_unmerged{.query = {}, .merge_distance = 0};

TEST(Pair, OverlappingSpheresAreAsDeepAsTheirCentresSay)
{
    const test::Solid ball(test::small_sphere());
    test::Random random(1);
    for (int i = 0; i < 20; ++i) {
        const Vec3d direction = random.direction(), position = random.in_box({-50, -50, -50}, {50, 50, 50});
        const double overlap = random.between(0.05, 0.5);
        const Body a = ball.at({test::rotation_about(random.direction(), 1), position}),
                   b = ball.at(test::shifted(position + (2 - overlap) * direction));
        const std::vector<PairContact> contacts = queried(a, b);
        ASSERT_FALSE(contacts.empty());
        // No vertex is deeper than the spheres, and one is within an edge (0.15) of the deepest position: the loss is 2 (1 - cos
        // 0.15 / 2).
        const PairContact& c = deepest(contacts);
        EXPECT_LE(c.depth, overlap + 0.005);
        EXPECT_GE(c.depth, overlap - 0.025);
        EXPECT_GE(dot(cast<double>(c.normal), direction), 0.98);
        for (const PairContact& each : contacts) {
            const Vec3d vertex = each.vertex_of == Side::A ? each.witness.on_a : each.witness.on_b,
                        other = each.vertex_of == Side::A ? b.pose.translation : position;
            EXPECT_NEAR(each.depth, 1 - norm(vertex - other), 0.01);
            EXPECT_GE(dot(cast<double>(each.normal), direction), 0.5);
            EXPECT_NEAR(norm(each.normal), 1.f, 1e-4f);
            EXPECT_LE(norm(each.witness.on_b - (each.witness.on_a - static_cast<double>(each.depth) * cast<double>(each.normal))),
                      1e-5);
        }
    }
}

TEST(Pair, BoxesOverlapAlongTheirFaces)
{
    const test::Solid box(test::small_box());  // half size 1.2, 0.8, 0.6
    const std::vector<PairContact> contacts = queried(box.at(), box.at(test::shifted({0, 0, 1.1})));
    ASSERT_GT(contacts.size(), 10u);
    std::size_t seen = 0;
    for (const PairContact& c : contacts) {
        if (std::abs(c.witness.on_a.x) > 0.9 || std::abs(c.witness.on_a.y) > 0.5) continue;  // near rounded edges
        EXPECT_NEAR(c.depth, 0.1, 0.005);
        EXPECT_GE(c.normal.z, 0.99f);
        EXPECT_NEAR(c.witness.on_a.z, 0.6, 0.005);
        EXPECT_NEAR(c.witness.on_b.z, 0.5, 0.005);
        // The grids of both faces lie on each other.
        EXPECT_TRUE(c.mutual);
        ++seen;
    }
    EXPECT_GE(seen, 5u);
}

TEST(Pair, ContactsAreThoseOfTheTwoFrames)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    test::Random random(2);
    std::vector<Contact> frame(4096);
    std::size_t total = 0;
    for (int i = 0; i < 30; ++i) {
        const Body a = ring.at(test::random_pose(random, 0.5)), b = hand.at(test::random_pose(random, 0.5));
        const std::vector<PairContact> contacts = queried(a, b, k_unmerged);
        std::set<std::tuple<Side, std::uint32_t, float>> expected;
        for (const Side side : {Side::B, Side::A}) {
            const Body &solid = side == Side::B ? a : b, &vertices = side == Side::B ? b : a;
            const ProbeResult r = query_probe(solid, vertices, {}, frame);
            for (std::size_t k = 0; k < r.contacts; ++k) expected.insert({side, frame[k].index, frame[k].depth});
        }
        std::set<std::tuple<Side, std::uint32_t, float>> found;
        for (const PairContact& c : contacts) {
            found.insert({c.vertex_of, c.index, c.depth});
            // The named vertex is where the contact says.
            const bool of_a = c.vertex_of == Side::A;
            const Body& body = of_a ? a : b;
            const Vec3d vertex = body.pose.rotation * (of_a ? ring : hand).mesh.vertices[c.index] + body.pose.translation;
            EXPECT_LE(norm((of_a ? c.witness.on_a : c.witness.on_b) - vertex), 2e-4 * 1.3);
        }
        EXPECT_EQ(found, expected);
        total += found.size();
    }
    EXPECT_GT(total, 1000u);
}

TEST(Pair, SwappedBodiesGiveTheSameContactsTurnedRound)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus()), ball(test::small_sphere());
    test::Random random(3);
    std::size_t total = 0, mutual = 0;
    // A hand deep in a ring has many contacts and hardly one from both sides; two balls that graze have most of them so.
    for (int i = 0; i < 80; ++i) {
        const bool graze = i % 2 == 1;
        const Body a = graze ? ball.at() : ring.at(test::random_pose(random, 0.6)),
                   b = graze ? ball.at(test::shifted(random.between(1.9, 1.99) * random.direction()))
                             : hand.at(test::random_pose(random, 0.6));
        const std::vector<PairContact> there = queried(a, b), back = queried(b, a);
        const auto key = [](const PairContact& c, bool turned) {
            const double sign = turned ? -1 : 1;
            return std::tuple(c.vertex_of == (turned ? Side::B : Side::A), c.index, c.depth, c.part, c.mutual, c.certain,
                              (turned ? c.witness.on_b : c.witness.on_a).x, (turned ? c.witness.on_a : c.witness.on_b).y,
                              static_cast<float>(sign) * c.normal.z);
        };
        std::set<decltype(key(there[0], false))> first, second;
        for (const PairContact& c : there) first.insert(key(c, false));
        for (const PairContact& c : back) second.insert(key(c, true));
        EXPECT_EQ(first, second);
        total += there.size();
        const auto marked =
            static_cast<std::size_t>(std::count_if(there.begin(), there.end(), [](const PairContact& c) { return c.mutual; }));
        EXPECT_EQ(marked, queried(a, b, k_unmerged).size() - there.size()) << "one for each that is left out";
        mutual += marked;
    }
    EXPECT_GT(total, 5000u);
    EXPECT_GT(mutual, 200u);
}

TEST(Probe, SpacingIsThatOfTheMesh)
{
    // 642 vertices on a unit sphere: a square of side sqrt(4 pi / 642) each.
    EXPECT_NEAR(Probe(mesh::sphere(1, 3).vertices).spacing(), 0.14, 0.03);
}

TEST(Pair, MergingLeavesOutOnlyWhatADeeperTwinStandsFor)
{
    const test::Solid ball(mesh::sphere(1, 4)), other(mesh::sphere(1, 3));
    test::Random random(4);
    std::size_t dropped = 0;
    for (int i = 0; i < 40; ++i) {
        const Vec3d direction = random.direction();
        const Body a = ball.at({test::rotation_about(random.direction(), 2), {}}),
                   b = other.at({test::rotation_about(random.direction(), 1), random.between(1.9, 1.99) * direction});
        const PairOptions options{};
        const std::vector<PairContact> all = queried(a, b, k_unmerged), merged = queried(a, b, options);
        const double distance =
            static_cast<double>(options.merge_distance) * std::max(ball.probe.spacing(), other.probe.spacing());
        const auto same = [](const PairContact& x, const PairContact& y) {
            return x.vertex_of == y.vertex_of && x.index == y.index;
        };
        // In order, with nothing new.
        auto at = all.begin();
        for (const PairContact& c : merged) {
            at = std::find_if(at, all.end(), [&](const PairContact& o) { return same(o, c); });
            ASSERT_NE(at, all.end());
        }
        std::size_t mutual = 0;
        for (const PairContact& c : merged) mutual += c.mutual ? 1u : 0u;
        EXPECT_EQ(all.size() - merged.size(), mutual);
        for (const PairContact& c : all) {
            if (std::any_of(merged.begin(), merged.end(), [&](const PairContact& m) { return same(m, c); })) continue;
            ++dropped;
            EXPECT_TRUE(std::any_of(merged.begin(), merged.end(), [&](const PairContact& m) {
                return m.mutual && m.vertex_of != c.vertex_of && m.depth >= c.depth &&
                       norm(m.witness.on_a - c.witness.on_a) <= distance && norm(m.witness.on_b - c.witness.on_b) <= distance &&
                       dot(m.normal, c.normal) >= options.merge_cosine;
            }));
        }
    }
    EXPECT_GT(dropped, 50u);
}

TEST(Pair, MovingTheWorldMovesTheContacts)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    test::Random random(5);
    for (int i = 0; i < 20; ++i) {
        const Body a = ring.at(test::random_pose(random, 0.5)), b = hand.at(test::random_pose(random, 0.5));
        const Pose moved = test::random_pose(random, 1000);
        const std::vector<PairContact> here = queried(a, b, k_unmerged),
                                       there =
                                           queried(ring.at(compose(moved, a.pose)), hand.at(compose(moved, b.pose)), k_unmerged);
        // A vertex on the surface may change sides by rounding; all others stay.
        std::size_t common = 0;
        for (const PairContact& c : here) {
            const auto at = std::find_if(there.begin(), there.end(),
                                         [&](const PairContact& o) { return o.vertex_of == c.vertex_of && o.index == c.index; });
            if (at == there.end()) {
                EXPECT_LE(c.depth, 1e-3f);
                continue;
            }
            ++common;
            EXPECT_NEAR(at->depth, c.depth, 1e-4f);
            if (norm(at->witness.on_a - (moved.rotation * c.witness.on_a + moved.translation)) > 1e-2)
                continue;  // two surfaces equally near
            if (c.depth > 1e-2f) {
                EXPECT_GE(dot(cast<double>(at->normal), moved.rotation * cast<double>(c.normal)), 0.99);
            }
        }
        EXPECT_GE(common + 3, there.size());
    }
}

TEST(Pair, FarBodiesAndBodiesWithoutDataGiveNothing)
{
    const test::Solid ball(test::small_sphere());
    for (const double d : {2.1, 10., 1e6, 1e30}) {
        PairResult r;
        EXPECT_TRUE(queried(ball.at(), ball.at(test::shifted({0, d, 0})), {}, &r).empty());
        EXPECT_EQ(r.status, k_ok);
    }
    const Body near = ball.at(test::shifted({1.5, 0, 0}));
    EXPECT_TRUE(queried({}, near).empty());
    EXPECT_TRUE(queried({nullptr, &ball.probe, {}}, {nullptr, &ball.probe, {}}).empty());
    EXPECT_TRUE(queried({&ball.view, nullptr, {}}, {&ball.view, nullptr, {}}).empty());
    // Ground without vertices still stops what has some.
    const std::vector<PairContact> contacts = queried({&ball.view, nullptr, {}}, near);
    ASSERT_FALSE(contacts.empty());
    for (const PairContact& c : contacts) EXPECT_EQ(c.vertex_of, Side::B);
}

TEST(Pair, FullSpansAreFlaggedAndTheRestCounted)
{
    const test::Solid ball(test::small_sphere());
    const Body a = ball.at(), b = ball.at(test::shifted({1.2, 0.1, 0}));
    PairResult whole;
    const std::vector<PairContact> all = queried(a, b, k_unmerged, &whole);
    ASSERT_GT(all.size(), 20u);
    EXPECT_EQ(whole.status, k_ok);
    EXPECT_EQ(whole.found, all.size());
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, all.size() / 4}) {
        PairWorkspace small(size);
        const PairResult r = query_pair(a, b, k_unmerged, small);
        EXPECT_LE(r.contacts.size(), 2 * size);
        EXPECT_NE(r.status & k_full, 0);
        EXPECT_EQ(r.found, all.size());
        for (std::size_t i = 0; i < std::min(size, r.contacts.size()); ++i) EXPECT_EQ(r.contacts[i].index, all[i].index);
    }
}

TEST(Pair, PosesThatAreNotFiniteAreRefused)
{
    const test::Solid ball(test::small_sphere());
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    for (const double bad : {nan, inf, -inf}) {
        Pose turned;
        turned.rotation.row[1].z = bad;
        for (const Pose& pose : {test::shifted({bad, 0, 0}), turned})
            for (const bool second : {false, true}) {
                PairResult r;
                EXPECT_TRUE(queried(ball.at(second ? Pose{} : pose), ball.at(second ? pose : Pose{}), {}, &r).empty());
                EXPECT_NE(r.status & k_not_finite, 0);
            }
    }
}

TEST(Pair, TheFirstContactIsEnoughForAYesOrNo)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    test::Random random(6);
    int yes = 0;
    for (int i = 0; i < 60; ++i) {
        const Body a = ring.at(test::random_pose(random, 0.8)), b = hand.at(test::random_pose(random, 0.8));
        const bool touch = !queried(a, b).empty();
        EXPECT_EQ(!queried(a, b, {.query = {.first_only = true}}).empty(), touch);
        yes += touch ? 1 : 0;
    }
    EXPECT_GT(yes, 5);
    EXPECT_LT(yes, 55);
}

}  // namespace
}  // namespace sqmap::query
