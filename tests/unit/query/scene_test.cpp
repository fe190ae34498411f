#include "sqmap/query/scene.h"

#include "support/bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace sqmap::query {
namespace {

using Ids = std::pair<BodyId, BodyId>;

std::vector<Ids> near(Scene& scene)
{
    std::vector<ScenePair> pairs(100000);
    const SceneResult r = scene.pairs(pairs);
    EXPECT_LE(r.pairs, pairs.size());
    std::vector<Ids> ids;
    for (const ScenePair& p : std::span(pairs).first(r.pairs)) ids.push_back({p.a, p.b});
    return ids;
}

/// Every pair of bodies whose spheres touch.
std::vector<Ids> near_by_force(const Scene& scene, const std::vector<BodyId>& ids)
{
    std::vector<Ids> found;
    for (const BodyId a : ids)
        for (const BodyId b : ids) {
            const Sphere s = sphere_of(scene.body(a)), t = sphere_of(scene.body(b));
            if (a < b && norm(s.centre - t.centre) <= 1.0001 * (s.radius + t.radius)) found.push_back({a, b});
        }
    std::sort(found.begin(), found.end());
    return found;
}

/// Points only: a broad phase needs no map. One of them is asked of a ball, so that every pair can have contacts.
struct Kinds {
    test::Solid ball{mesh::sphere(0.5, 2)}, egg{mesh::ellipsoid({1.5, 0.4, 0.3}, 2)};
    const test::Solid& of(std::size_t i) const { return i % 3 == 0 ? egg : ball; }
};

TEST(Scene, PairsAreThoseOfBruteForceWhateverMoves)
{
    const Kinds kinds;
    for (const double size : {3., 12., 60.}) {
        test::Random random(11);
        Scene scene;
        std::vector<BodyId> ids;
        std::vector<Pose> poses;
        std::vector<Vec3d> velocities;
        const auto add = [&] {
            const test::Solid& kind = kinds.of(ids.size());
            poses.push_back(test::random_pose(random, size));
            velocities.push_back(0.1 * random.direction());
            ids.push_back(scene.add(&kind.view, &kind.probe, poses.back()));
        };
        for (int i = 0; i < 80; ++i) add();
        std::size_t total = 0;
        for (int frame = 0; frame < 120; ++frame) {
            if (frame % 40 == 13) add();
            if (frame % 40 == 27) {
                const std::size_t gone = random.below(ids.size());
                scene.remove(ids[gone]);
                ids.erase(ids.begin() + static_cast<std::ptrdiff_t>(gone));
                poses.erase(poses.begin() + static_cast<std::ptrdiff_t>(gone));
                velocities.erase(velocities.begin() + static_cast<std::ptrdiff_t>(gone));
            }
            for (std::size_t i = 0; i < ids.size(); ++i) {
                poses[i].translation += velocities[i];
                // Some jump, now and then everything does, once all line up along an axis.
                if (random.below(100) == 0 || frame % 30 == 29) poses[i] = test::random_pose(random, size);
                if (frame / 20 % 3 == 1) poses[i].translation[frame / 60] *= 0.9;
                EXPECT_TRUE(scene.set_pose(ids[i], poses[i]));
            }
            const std::vector<Ids> found = near(scene);
            EXPECT_EQ(found, near_by_force(scene, ids)) << "size " << size << " frame " << frame;
            total += found.size();
        }
        EXPECT_GT(total, 0u);
    }
}

TEST(Scene, ContactsAreThoseOfThePairs)
{
    const Kinds kinds;
    test::Random random(12);
    Scene scene;
    for (std::size_t i = 0; i < 40; ++i) (void)scene.add(&kinds.of(i).view, &kinds.of(i).probe, test::random_pose(random, 2));
    std::vector<ScenePair> pairs(1000);
    std::vector<PairContact> contacts(100000);
    PairWorkspace workspace(4096);
    const SceneResult r = scene.query_pairs({}, pairs, contacts);
    EXPECT_EQ(r.status, k_ok);
    ASSERT_GT(r.pairs, 50u);
    ASSERT_GT(r.contacts, 200u);
    std::size_t total = 0;
    for (const ScenePair& p : std::span(pairs).first(r.pairs)) {
        const PairResult alone = query_pair(scene.body(p.a), scene.body(p.b), {}, workspace);
        ASSERT_EQ(p.first, total);
        ASSERT_EQ(p.count, alone.contacts.size());
        for (std::size_t i = 0; i < p.count; ++i) {
            EXPECT_EQ(contacts[p.first + i].index, alone.contacts[i].index);
            EXPECT_EQ(contacts[p.first + i].witness.on_a, alone.contacts[i].witness.on_a);
            EXPECT_EQ(contacts[p.first + i].depth, alone.contacts[i].depth);
        }
        total += p.count;
    }
    EXPECT_EQ(total, r.contacts);
}

TEST(Scene, AProbeMeetsTheBodiesItMeetsOneByOne)
{
    const Kinds kinds;
    test::Random random(13);
    Scene scene;
    std::vector<BodyId> ids;
    for (std::size_t i = 0; i < 100; ++i) ids.push_back(scene.add(&kinds.of(i).view, nullptr, test::random_pose(random, 5)));
    const test::Solid tool(mesh::ellipsoid({2, 0.3, 0.3}, 3));
    std::vector<ScenePair> pairs(1000);
    std::vector<PairContact> contacts(100000);
    std::vector<Contact> frame(4096);
    std::size_t touched = 0;
    for (int i = 0; i < 50; ++i) {
        const Pose pose = test::random_pose(random, 6);
        const SceneResult r = scene.query_probe({.probe = &tool.probe, .pose = pose}, {}, pairs, contacts);
        std::size_t at = 0;
        for (const BodyId id : ids) {
            const ProbeResult alone = query_probe(scene.body(id), {.probe = &tool.probe, .pose = pose}, {}, frame);
            const bool listed = at < r.pairs && pairs[at].a == id;
            if (!listed) {
                EXPECT_EQ(alone.contacts, 0u);
                continue;
            }
            EXPECT_EQ(pairs[at].b, k_no_body);
            ASSERT_EQ(pairs[at].count, alone.contacts);
            for (std::size_t k = 0; k < alone.contacts; ++k) EXPECT_EQ(contacts[pairs[at].first + k].index, frame[k].index);
            touched += alone.contacts > 0 ? 1u : 0u;
            ++at;
        }
        EXPECT_EQ(at, r.pairs);
    }
    EXPECT_GT(touched, 20u);
}

TEST(Scene, FullSpansAreFlagged)
{
    const test::Solid ball(mesh::sphere(0.5, 2));
    Scene scene;
    for (int i = 0; i < 10; ++i) (void)scene.add(&ball.view, &ball.probe, test::shifted({0.8 * i, 0, 0}));
    std::vector<ScenePair> pairs(20);
    std::vector<PairContact> contacts(1000);
    const SceneResult whole = scene.query_pairs({}, pairs, contacts);
    EXPECT_EQ(whole.status, k_ok);
    EXPECT_EQ(whole.pairs, 9u);
    ASSERT_GT(whole.contacts, 9u);
    const SceneResult few_pairs = scene.query_pairs({}, std::span(pairs).first(4), contacts);
    EXPECT_TRUE(few_pairs.pairs_full);
    EXPECT_EQ(few_pairs.status, k_ok);
    EXPECT_EQ(few_pairs.pairs, 9u);
    EXPECT_EQ(scene.pairs({}).pairs, 9u);
    const SceneResult few_contacts = scene.query_pairs({}, pairs, std::span(contacts).first(whole.contacts - 1));
    EXPECT_EQ(few_contacts.status, k_full);
    EXPECT_FALSE(few_contacts.pairs_full);
    EXPECT_LE(few_contacts.contacts, whole.contacts - 1);
    EXPECT_EQ(pairs[8].status, k_full);
    EXPECT_EQ(pairs[0].status, k_ok);
}

TEST(Scene, ABodyWithoutAFinitePoseIsNearNothing)
{
    const test::Solid ball(mesh::sphere(0.5, 2));
    Scene scene;
    const BodyId a = scene.add(&ball.view, &ball.probe), b = scene.add(&ball.view, &ball.probe, test::shifted({0.5, 0, 0}));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<ScenePair> pairs(4);
    std::vector<PairContact> contacts(1000);
    for (const double bad : {nan, std::numeric_limits<double>::infinity(), 1e200}) {
        EXPECT_EQ(scene.pairs(pairs).pairs, 1u);
        EXPECT_EQ(scene.set_pose(b, test::shifted({0, bad, 0})), bad == 1e200);
        const SceneResult r = scene.query_pairs({}, pairs, contacts);
        EXPECT_EQ(r.pairs, 0u);
        EXPECT_EQ(r.contacts, 0u);
        EXPECT_EQ(r.status, bad == 1e200 ? k_ok : k_not_finite);
        EXPECT_EQ(scene.query_probe({.probe = &ball.probe}, {}, pairs, contacts).pairs, 1u);
        EXPECT_TRUE(scene.set_pose(b, test::shifted({0.5, 0, 0})));
    }
    EXPECT_NE(
        scene.query_probe({.probe = &ball.probe, .pose = test::shifted({nan, 0, 0})}, {}, pairs, contacts).status & k_not_finite,
        0);
    EXPECT_FALSE(scene.set_pose(7, {}));
    scene.remove(a);
    EXPECT_EQ(scene.size(), 1u);
    EXPECT_EQ(scene.pairs(pairs).pairs, 0u);
    EXPECT_EQ(scene.add(&ball.view, &ball.probe), a);
    EXPECT_EQ(scene.pairs(pairs).pairs, 1u);
}

TEST(Scene, BodiesThatCannotAskEachOtherAreNoPair)
{
    const test::Solid ball(mesh::sphere(0.5, 2));
    Scene scene;
    (void)scene.add(&ball.view, nullptr);
    (void)scene.add(&ball.view, nullptr, test::shifted({0.2, 0, 0}));
    EXPECT_TRUE(near(scene).empty());
    (void)scene.add(nullptr, &ball.probe, test::shifted({0, 0.2, 0}));
    EXPECT_EQ(near(scene), (std::vector<Ids>{{0, 2}, {1, 2}}));
}

}  // namespace
}  // namespace sqmap::query
