#include "math/triangle_crossing.h"
#include "query/probe_pointwise.h"
#include "sqmap/query/pair.h"
#include "sqmap/query/point.h"
#include "sqmap/query/scene.h"
#include "support/bodies.h"
#include "support/paper_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace sqmap::query {
namespace {

TEST(FrameOffset, AnswersAsEveryPointAskedByItself)
{
    const test::Parsed central(test::small_hand());
    const test::PaperModel paper(test::small_hand());
    for (const bool is_paper : {false, true}) {
        const model::ModelView view = is_paper ? paper.view() : central.view();
        ASSERT_GT(offset_reach(view, {.offset = true}), 0.f);
        test::Random random(31);
        std::vector<Vec3d> points;
        for (int i = 0; i < 3000; ++i) points.push_back(0.6 * random.in_box({-1, -1, -1}, {1, 1, 1}));
        const Probe probe(points);
        std::vector<Contact> contacts(points.size());
        std::size_t total = 0, other = 0;
        for (int i = 0; i < 5; ++i) {
            const Pose pose = test::random_pose(random, 0.3);
            const ProbeResult r = query_probe({.model = &view}, {.probe = &probe, .pose = pose}, {.offset = true}, contacts);
            std::vector<const Contact*> of_point(points.size(), nullptr);
            for (const Contact& c : std::span(contacts).first(r.contacts)) {
                EXPECT_EQ(of_point[c.index], nullptr);
                of_point[c.index] = &c;
                EXPECT_FALSE(c.certain);
            }
            for (std::size_t k = 0; k < points.size(); ++k) {
                const PointResult c = query_point(view, apply(pose, points[k]), {.offset = true});
                // Places are rounded in another order: points on the moved surface may change sides.
                if (c.contact && c.depth > 1e-4 * view.header.unit) {
                    ASSERT_NE(of_point[k], nullptr);
                    // Either of two surfaces that are equally near may be the answer.
                    other += std::abs(static_cast<double>(of_point[k]->depth) - c.depth) > 2e-3 * view.header.unit ? 1u : 0u;
                    ++total;
                } else if (!c.contact && of_point[k] != nullptr) {
                    EXPECT_LE(of_point[k]->depth, 1e-4 * view.header.unit);
                }
            }
        }
        EXPECT_GT(total, 100u);
        EXPECT_LE(other, total / 200);
    }
}

TEST(FrameOffset, FindsAtLeastTheContactsWithoutIt)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    test::Random random(32);
    std::vector<Contact> plain(4096), moved(4096);
    std::size_t more = 0, total = 0;
    for (int i = 0; i < 30; ++i) {
        const Pose pose = test::random_pose(random, 0.8);
        const ProbeResult without = query_probe({.model = &ring.view}, {.probe = &hand.probe, .pose = pose}, {}, plain);
        const ProbeResult with =
            query_probe({.model = &ring.view}, {.probe = &hand.probe, .pose = pose}, {.offset = true}, moved);
        for (const Contact& c : std::span(plain).first(without.contacts))
            // A kernel and a point's own query may disagree within the target of the bake.
            EXPECT_TRUE(c.depth < 5e-3 * ring.view.header.r_max * ring.view.header.unit ||
                        std::any_of(moved.begin(), moved.begin() + static_cast<std::ptrdiff_t>(with.contacts),
                                    [&](const Contact& m) { return m.index == c.index; }));
        more += with.contacts > without.contacts ? 1u : 0u;
        total += without.contacts;
    }
    EXPECT_GT(more, 3u);
    EXPECT_GT(total, 300u);
}

TEST(FrameOffset, AMarginFindsThePointsWithinIt)
{
    const test::Solid ball(mesh::sphere(1, 4));
    test::Random random(34);
    std::vector<Vec3d> points;
    for (int i = 0; i < 2000; ++i) points.push_back(random.between(0.9, 1.1) * random.direction());
    const Probe probe(points);
    std::vector<Contact> contacts(points.size());
    for (const double margin : {0.02, 0.04, 0.08})
        for (const Layer layer : {Layer::Two, Layer::Three, Layer::Exact}) {
            const ProbeResult r =
                query_probe({.model = &ball.view}, {.probe = &probe}, {.layer = layer, .margin = margin}, contacts);
            std::vector<double> depth(points.size(), 0);
            for (const Contact& c : std::span(contacts).first(r.contacts)) {
                depth[c.index] = static_cast<double>(c.depth);
                if (layer == Layer::Two) continue;  // whose surface may lie beyond the point
                EXPECT_GE(dot(cast<double>(c.normal), normalized(points[c.index])), 0.95);
            }
            for (std::size_t i = 0; i < points.size(); ++i)
                EXPECT_NEAR(depth[i], std::max(1 + margin - norm(points[i]), 0.), layer == Layer::Two ? 0.02 : 0.005)
                    << "layer 2 reads the base grid alone";
        }
}

TEST(FrameOffset, NoEdgeUpToTheNamedLengthCrossesTheOtherSurfaceUnseen)
{
    const mesh::Mesh round = mesh::sphere(1, 2);
    const test::Solid ball(round);
    PairWorkspace workspace(1000);
    test::Random random(35);
    std::size_t crossings = 0, unseen_without = 0;
    for (int i = 0; i < 6; ++i) {
        Pose pose = test::random_pose(random, 0);
        pose.translation = random.between(1.94, 1.985) * random.direction();
        const Body a{&ball.view, &ball.probe, {}}, b{&ball.view, &ball.probe, pose};
        for (const Layer layer : {Layer::Three, Layer::Exact})
            for (const double margin : {0., 0.2}) {
                const PairResult found =
                    query_pair(a, b, {.query = {.layer = layer, .margin = margin}, .merge_distance = 0}, workspace);
                EXPECT_NEAR(found.edge_length, 2 * margin, 1e-4);
                std::array<std::vector<bool>, 2> is_found{std::vector<bool>(ball.probe.size()),
                                                          std::vector<bool>(ball.probe.size())};
                for (const PairContact& c : found.contacts) is_found[c.vertex_of == Side::A ? 0 : 1][c.index] = true;
                for (const mesh::Triangle& s : round.triangles)
                    for (const mesh::Triangle& t : round.triangles) {
                        const auto& v = round.vertices;
                        const Crossing crossing = crossing_of({v[s[0]], v[s[1]], v[s[2]]},
                                                              {apply(pose, v[t[0]]), apply(pose, v[t[1]]), apply(pose, v[t[2]])});
                        for (std::uint32_t k = 0; k < 6; ++k) {
                            if (((crossing.sides_a | crossing.sides_b << 3) >> k & 1) == 0) continue;
                            const mesh::Triangle& own = k < 3 ? s : t;
                            const std::uint32_t from = own[k % 3], to = own[(k + 1) % 3];
                            const bool seen = is_found[k / 3][from] || is_found[k / 3][to];
                            if (margin == 0) unseen_without += seen ? 0u : 1u;
                            if (margin > 0 && norm(v[to] - v[from]) <= found.edge_length) {
                                EXPECT_TRUE(seen);
                                ++crossings;
                            }
                        }
                    }
            }
    }
    EXPECT_GT(crossings, 100u);
    EXPECT_GT(unseen_without, 0u);
    const Body a{&ball.view, &ball.probe, {}};
    EXPECT_EQ(query_pair(a, a, {}, workspace).edge_length, 0);
    EXPECT_EQ(query_pair(a, a, {.query = {.offset = true, .margin = 0.1}}, workspace).edge_length, 0);
}

TEST(FrameOffset, BodiesWithinTheMarginAreAPair)
{
    const test::Solid ball(mesh::sphere(1, 3));
    Scene scene;
    (void)scene.add(&ball.view, &ball.probe);
    (void)scene.add(&ball.view, &ball.probe, test::shifted({2.05, 0, 0}));
    std::vector<ScenePair> pairs(2);
    std::vector<PairContact> contacts(1000);
    EXPECT_EQ(scene.query_pairs({}, pairs, contacts).pairs, 0u);
    const SceneResult r = scene.query_pairs({.query = {.margin = 0.1}}, pairs, contacts);
    EXPECT_EQ(r.pairs, 1u);
    EXPECT_GT(r.contacts, 0u);
    EXPECT_GT(scene.query_probe({.probe = &ball.probe, .pose = test::shifted({-2.05, 0, 0})}, {.margin = 0.1}, pairs, contacts)
                  .contacts,
              0u);
    EXPECT_EQ(scene.query_probe({.probe = &ball.probe, .pose = test::shifted({-2.05, 0, 0})}, {}, pairs, contacts).contacts, 0u);
}

TEST(FrameOffset, AModelWithoutALocatorIsAskedPointByPoint)
{
    const test::Parsed b(test::small_hand());
    const model::ModelView view = b.view();
    ASSERT_TRUE(model::has_locator(view));
    model::ModelView bare = view;
    bare.locator = {};
    bare.bricks = {};
    const std::vector<Vec3d> points = mesh::sphere(0.3, 3).vertices;
    const Probe probe(points);
    std::vector<Contact> contacts(4096);
    std::size_t total = 0;
    test::Random random(33);
    for (int i = 0; i < 6; ++i) {
        const Pose pose = test::random_pose(random, 0.3);
        for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact}) {
            const ProbeResult r = query_probe({.model = &bare}, {.probe = &probe, .pose = pose}, {.layer = layer}, contacts);
            EXPECT_EQ(r.status, k_ok);
            EXPECT_EQ(
                query_probe({.model = &bare}, {.probe = &probe, .pose = pose}, {.layer = layer, .first_only = true}, contacts)
                        .contacts > 0,
                r.contacts > 0);
            std::size_t expected = 0;
            for (const Vec3d& p : points) expected += query_point(bare, apply(pose, p), {.layer = layer}).contact ? 1u : 0u;
            // Places are rounded in another order.
            EXPECT_NEAR(static_cast<double>(r.contacts), static_cast<double>(expected), 1);
            total += r.contacts;
            const ProbeResult few =
                query_probe({.model = &bare}, {.probe = &probe, .pose = pose}, {.layer = layer}, std::span(contacts).first(1));
            EXPECT_EQ(few.contacts, r.contacts);
            EXPECT_EQ(few.status, r.contacts > 1 ? k_full : k_ok);
        }
    }
    EXPECT_GT(total, 100u);
}

}  // namespace
}  // namespace sqmap::query
