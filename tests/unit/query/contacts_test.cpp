#include "sqmap/query/contacts.h"

#include "math/triangle.h"
#include "math/triangle_crossing.h"

#include "support/bodies.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace sqmap::query {
namespace {

/// A mesh and the probe of its triangles, without a model: only triangles meet.
struct Shell {
    explicit Shell(mesh::Mesh m) : mesh(std::move(m)), probe(mesh.vertices, mesh.triangles) {}
    [[nodiscard]] Body at(const sqmap::Pose& pose = {}) const { return {nullptr, &probe, pose}; }
    mesh::Mesh mesh;
    Probe probe;
};

struct Queried {
    std::vector<SurfaceContact> contacts;
    ContactResult result;
};
Queried queried(const Body& a, const Body& b, const ContactOptions& options = {})
{
    ContactWorkspace workspace(4096);
    Queried q;
    q.result = query_contacts(a, b, options, workspace);
    q.contacts.assign(q.result.contacts.begin(), q.result.contacts.end());
    q.result.contacts = {};  // the workspace ends here
    return q;
}

void expect_every_region_has_a_contact(const Queried& q)
{
    std::set<std::uint32_t> seen;
    for (const SurfaceContact& c : q.contacts)
        if (c.region != k_unnamed) seen.insert(c.region);
    EXPECT_EQ(seen.size(), q.result.regions);
    if (!seen.empty()) {
        EXPECT_EQ(*seen.rbegin() + 1, q.result.regions);
    }
}

TEST(TriangleFault, IsNamedWithItsTriangleAndSide)
{
    using Kind = TriangleFault::Kind;
    mesh::Mesh cube = test::box({0, 0, 0}, {1, 1, 1});
    EXPECT_EQ(find_fault(cube.vertices, cube.triangles).kind, Kind::None);
    EXPECT_EQ(find_fault({}, {}).kind, Kind::None);

    mesh::Mesh wrong = cube;
    wrong.triangles[5][1] = 8;
    EXPECT_EQ(find_fault(wrong.vertices, wrong.triangles).kind, Kind::OutOfRange);
    EXPECT_EQ(find_fault(wrong.vertices, wrong.triangles).triangle, 5u);
    EXPECT_EQ(find_fault(wrong.vertices, wrong.triangles).side, 1u);

    wrong = cube;
    wrong.vertices[0].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(find_fault(wrong.vertices, wrong.triangles).kind, Kind::NotFinite);

    wrong = cube;
    wrong.triangles.erase(wrong.triangles.begin() + 3);
    EXPECT_EQ(find_fault(wrong.vertices, wrong.triangles).kind, Kind::Open);

    wrong = cube;
    std::swap(wrong.triangles[3][0], wrong.triangles[3][1]);
    EXPECT_EQ(find_fault(wrong.vertices, wrong.triangles).kind, Kind::TurnedRound);

    wrong = cube;
    for (mesh::Triangle& t : wrong.triangles) std::swap(t[0], t[1]);
    EXPECT_EQ(find_fault(wrong.vertices, wrong.triangles).kind, Kind::Inverted);
}

#ifdef SQMAP_ASSERTS
TEST(TriangleFaultDeathTest, EndsAProgramThatMakesAProbeOfIt)
{
    const mesh::Mesh cube = test::box({0, 0, 0}, {1, 1, 1});
    EXPECT_DEATH(Probe(cube.vertices, std::span(cube.triangles).subspan(1)), "");
}
#endif

TEST(TriangleFault, AShellThatIsInsideOutIsNamedUnlessItBoundsACavity)
{
    using Kind = TriangleFault::Kind;
    const auto inverted = [](mesh::Mesh m) {
        for (mesh::Triangle& t : m.triangles) std::swap(t[0], t[1]);
        return m;
    };
    const auto fault_of = [](const std::vector<mesh::Mesh>& shells) {
        const mesh::Mesh all = test::joined(shells);
        return find_fault(all.vertices, all.triangles);
    };
    const mesh::Mesh large = test::box({-2, -2, -2}, {2, 2, 2}), hole = inverted(test::box({-1, -1, -1}, {1, 1, 1})),
                     pearl = mesh::sphere(0.5, 2), beside = inverted(test::moved(mesh::sphere(0.5, 2), {5, 0, 0}));
    EXPECT_EQ(fault_of({large, hole}).kind, Kind::None);
    EXPECT_EQ(fault_of({pearl, hole, large}).kind, Kind::None);
    EXPECT_EQ(fault_of({large, pearl}).kind, Kind::None) << "within another, not inside out";
    const auto count = [](const mesh::Mesh& m) { return static_cast<std::uint32_t>(m.triangles.size()); };
    for (const auto& [shells, triangle] :
         {std::pair{std::vector{large, beside}, count(large)}, std::pair{std::vector{beside, large, hole}, 0u},
          std::pair{std::vector{large, hole, inverted(pearl)}, count(large) + count(hole)}}) {
        EXPECT_EQ(fault_of(shells).kind, Kind::Inverted);
        EXPECT_EQ(fault_of(shells).triangle, triangle);
    }
    // At any height beside another one: no ray along an edge or through a corner counts twice.
    for (const double x : {-3., -2., 0., 1., 2.})
        for (const double y : {-2., -1., 2.})
            EXPECT_EQ(fault_of({large, inverted(test::moved(test::box({0, 0, 0}, {1, 1, 1}), {x, y, -7}))}).triangle, 12u);
}

TEST(TriangleFault, SizesAreRefusedWhereContactsWouldBeLost)
{
    const mesh::Mesh hand = test::small_hand(), ring = test::small_torus();
    test::Random random(14);
    std::vector<std::pair<sqmap::Pose, sqmap::Pose>> poses;
    for (int i = 0; i < 10; ++i) poses.emplace_back(test::random_pose(random, 0.5), test::random_pose(random, 0.5));
    std::vector<std::size_t> meetings;
    // Powers of two change no sign.
    for (int exponent = 0; exponent <= 140; ++exponent)
        for (const double scale : {std::ldexp(1, exponent), std::ldexp(1, -exponent)}) {
            mesh::Mesh a = ring, b = hand;
            for (mesh::Mesh* m : {&a, &b})
                for (Vec3d& v : m->vertices) v = scale * v;
            const double size_a = norm(size(box_of(a.vertices))), size_b = norm(size(box_of(b.vertices)));
            const auto is_taken = [](double size) { return size >= k_least_size && size <= k_largest_size; };
            const auto kind = [&](double size) {
                return is_taken(size) ? TriangleFault::Kind::None : TriangleFault::Kind::OutOfScale;
            };
            EXPECT_EQ(find_fault(a.vertices, a.triangles).kind, kind(size_a)) << scale;
            EXPECT_EQ(find_fault(b.vertices, b.triangles).kind, kind(size_b)) << scale;
            if (!is_taken(size_a) || !is_taken(size_b)) continue;
            const Probe probe_a(a.vertices, a.triangles), probe_b(b.vertices, b.triangles);
            std::vector<std::size_t> found;
            for (const auto& [pose_a, pose_b] : poses)
                found.push_back(queried({nullptr, &probe_a, {pose_a.rotation, scale * pose_a.translation}},
                                        {nullptr, &probe_b, {pose_b.rotation, scale * pose_b.translation}})
                                    .result.meetings);
            if (exponent == 0) meetings = found;
            EXPECT_EQ(found, meetings) << scale;
        }
    EXPECT_GT(*std::max_element(meetings.begin(), meetings.end()), 10u);
}

TEST(TriangleFault, PointsAtOnePositionCountAsOne)
{
    const mesh::Mesh cube = test::box({0, 0, 0}, {1, 1, 1});
    mesh::Mesh soup;
    for (const mesh::Triangle& t : cube.triangles) {
        const auto first = static_cast<std::uint32_t>(soup.vertices.size());
        for (const std::uint32_t v : t) soup.vertices.push_back(cube.vertices[v]);
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    EXPECT_EQ(find_fault(soup.vertices, soup.triangles).kind, TriangleFault::Kind::None);
    const Shell a(soup), b(test::diamond_bar(true, 3, 0.5, 1.4));
    const Queried q = queried(a.at(), b.at({{}, {0, 0.5, 0}}));
    EXPECT_FALSE(q.contacts.empty());
    expect_every_region_has_a_contact(q);
}

TEST(SurfaceContacts, CrossingRidgesTouchWithTheirEdges)
{
    // Ridges of unit height, the upper one 0.1 below the lower one's top; no vertex is in the other bar.
    const test::Solid lower(test::diamond_bar(true, 3, 1, 0)), upper(test::diamond_bar(false, 3, 1, 1.9));
    PairWorkspace vertices(1024);
    EXPECT_TRUE(query_pair(lower.at(), upper.at(), {.query = {.layer = Layer::Exact}}, vertices).contacts.empty());
    const Vec3d by{5, -2, 1};
    const Queried q = queried(lower.at(test::shifted(by)), upper.at(test::shifted(by)));
    ASSERT_EQ(q.contacts.size(), 1u);
    const SurfaceContact& c = q.contacts[0];
    EXPECT_EQ(q.result.regions, 1u);
    EXPECT_EQ(c.feature_a, Feature::Edge);
    EXPECT_EQ(c.feature_b, Feature::Edge);
    EXPECT_NEAR(c.depth, 0.1, 1e-6);
    EXPECT_NEAR(c.normal.z, 1, 1e-6);
    EXPECT_LE(norm(c.witness.on_a - (by + Vec3d{0, 0, 1})), 1e-9);
    EXPECT_LE(norm(c.witness.on_b - (by + Vec3d{0, 0, 0.9})), 1e-6);
    EXPECT_TRUE(c.certain);
    EXPECT_GE(c.part_a, 0);
    EXPECT_GE(c.part_b, 0);
    const auto on_edge = [](const mesh::Mesh& m, std::uint32_t edge, double z) {
        const mesh::Triangle& t = m.triangles[edge / 3];
        return std::abs(m.vertices[t[edge % 3]].z - z) < 1e-9 && std::abs(m.vertices[t[(edge % 3 + 1) % 3]].z - z) < 1e-9;
    };
    EXPECT_TRUE(on_edge(lower.mesh, c.index_a, 1));
    EXPECT_TRUE(on_edge(upper.mesh, c.index_b, 0.9));
    // Moved by its depth along the normal, b only touches.
    EXPECT_EQ(queried(lower.at(), upper.at(test::shifted({0, 0, 0.1 + 1e-6}))).contacts.size(), 0u);
}

TEST(SurfaceContacts, ANeedleThroughAPlateTouchesItOnBothSides)
{
    const Shell plate(test::box({-5, -5, -0.01}, {5, 5, 0.01})),
        needle(test::prism({{0.1, 0.2, -1}, {0.11, 0.2, -1}, {0.1, 0.21, -1}}, {{0.1, 0.2, 1}, {0.11, 0.2, 1}, {0.1, 0.21, 1}}));
    const Queried q = queried(plate.at(), needle.at());
    EXPECT_EQ(q.result.regions, 2u);
    EXPECT_EQ(q.contacts.size(), 2u);
    expect_every_region_has_a_contact(q);
}

TEST(SurfaceContacts, FacesThatLieOnEachOtherTouchWithDepthZero)
{
    const Shell box(test::box({0, 0, 0}, {2, 2, 1}));
    for (const Vec3d& by : {Vec3d{0, 0, 1}, Vec3d{0.5, 0.25, 1}, Vec3d{2, 0, 0}, Vec3d{2, 2, 1}, Vec3d{2, 1, 1}}) {
        const Queried q = queried(box.at(), box.at(test::shifted(by)));
        ASSERT_FALSE(q.contacts.empty());
        expect_every_region_has_a_contact(q);
        for (const SurfaceContact& c : q.contacts) {
            EXPECT_EQ(c.depth, 0.f);
            EXPECT_NEAR(norm(c.normal), 1.f, 1e-6f);
        }
    }
    EXPECT_TRUE(queried(box.at(), box.at(test::shifted({0, 0, std::nextafter(1, 2)}))).contacts.empty()) << "no tolerance";
}

TEST(SurfaceContacts, AShapeTouchesItselfEverywhere)
{
    const test::Solid torus(test::small_torus());
    const Queried q = queried(torus.at(), torus.at());
    EXPECT_GE(q.result.meetings, torus.mesh.triangles.size());
    EXPECT_EQ(q.result.regions, 1u);
    expect_every_region_has_a_contact(q);
}

TEST(SurfaceContacts, SwappedBodiesGiveTheSameEdgesTurnedRound)
{
    const Shell hand(test::small_hand()), ring(test::small_torus());
    test::Random random(4);
    std::size_t total = 0;
    for (int i = 0; i < 20; ++i) {
        const Body a = ring.at(test::random_pose(random, 0.5)), b = hand.at(test::random_pose(random, 0.5));
        const Queried there = queried(a, b), back = queried(b, a);
        EXPECT_EQ(there.result.meetings, back.result.meetings);
        EXPECT_EQ(there.result.regions, back.result.regions);
        ASSERT_EQ(there.contacts.size(), back.contacts.size());
        const auto key = [](const SurfaceContact& c) { return std::tuple(c.depth, c.witness.on_a.x + c.witness.on_b.x); };
        std::vector<SurfaceContact> t = there.contacts, r = back.contacts;
        for (std::vector<SurfaceContact>* v : {&t, &r})
            std::sort(v->begin(), v->end(), [&](const auto& x, const auto& y) { return key(x) < key(y); });
        for (std::size_t k = 0; k < t.size(); ++k) {
            EXPECT_NEAR(t[k].depth, r[k].depth, 1e-6);
            if (t[k].depth > 1e-4f) {
                EXPECT_LE(norm(t[k].normal + r[k].normal), 1e-3f);
            }
        }
        total += t.size();
    }
    EXPECT_GT(total, 15u);
}

TEST(SurfaceContacts, AnEdgeContactIsTheLeastTranslationOfItsTwoEdges)
{
    const Shell lower(test::diamond_bar(true, 3, 1, 0)), upper(test::diamond_bar(false, 3, 1, 2));
    test::Random random(5);
    for (int i = 0; i < 50; ++i) {
        // Ridges that cross at any angle from 30 degrees on, a little tilted.
        const Mat3d turn = test::rotation_about({0, 0, 1}, random.between(-1, 1)) * test::rotation_about(random.direction(), 0.1);
        const auto queried_at = [&](const Vec3d& by) {
            return queried(lower.at(), upper.at({turn, Vec3d{0, 0, 2} - turn * Vec3d{0, 0, 2} + by}));
        };
        const Vec3d by{random.between(-0.5, 0.5), random.between(-0.5, 0.5), random.between(-0.2, -0.05)};
        const Queried q = queried_at(by);
        ASSERT_EQ(q.contacts.size(), 1u);
        const SurfaceContact& c = q.contacts[0];
        EXPECT_EQ(c.feature_a, Feature::Edge);
        EXPECT_EQ(c.feature_b, Feature::Edge);
        const Vec3d n = cast<double>(c.normal);
        EXPECT_LE(norm(c.witness.on_b - (c.witness.on_a - static_cast<double>(c.depth) * n)), 1e-6);
        // Pushed out by its depth b is free, by less it is not.
        EXPECT_TRUE(queried_at(by + static_cast<double>(c.depth + 1e-6f) * n).contacts.empty());
        EXPECT_FALSE(queried_at(by + static_cast<double>(c.depth - 1e-6f) * n).contacts.empty());
    }
}

/// How far a witness point is from the feature that has it.
double distance_to(const mesh::Mesh& m, const sqmap::Pose& pose, Feature feature, std::uint32_t index, Vec3d p)
{
    const auto corner = [&](std::uint32_t t, std::uint32_t k) { return apply(pose, m.vertices[m.triangles[t][k % 3]]); };
    if (feature == Feature::Vertex) return norm(apply(pose, m.vertices[index]) - p);
    const std::uint32_t t = feature == Feature::Edge ? index / 3 : index, k = feature == Feature::Edge ? index % 3 : 0;
    const Vec3d a = corner(t, k), b = corner(t, k + 1), c = feature == Feature::Edge ? b : corner(t, k + 2);
    return norm(closest_point_on_triangle(p, a, b, c) - p);
}

TEST(SurfaceContacts, WitnessPointsLieOnTheirFeatures)
{
    const Shell shells[] = {Shell(test::small_hand()), Shell(test::small_torus()), Shell(mesh::ellipsoid({2, 0.7, 1.1}, 2)),
                            Shell(test::box({-0.4, -0.5, -0.6}, {0.4, 0.5, 0.6}))};
    test::Random random(11);
    std::size_t pairs[3][3]{};
    for (const Shell& one : shells)
        for (const Shell& other : shells)
            for (int i = 0; i < 20; ++i) {
                const sqmap::Pose pose_a = test::random_pose(random, 0.7), pose_b = test::random_pose(random, 0.7);
                for (const SurfaceContact& c : queried(one.at(pose_a), other.at(pose_b)).contacts) {
                    EXPECT_LE(distance_to(one.mesh, pose_a, c.feature_a, c.index_a, c.witness.on_a), 1e-6);
                    EXPECT_LE(distance_to(other.mesh, pose_b, c.feature_b, c.index_b, c.witness.on_b), 1e-6);
                    EXPECT_NEAR(norm(c.witness.on_a - c.witness.on_b), c.depth, 1e-6);
                    ++pairs[static_cast<int>(c.feature_a)][static_cast<int>(c.feature_b)];
                }
            }
    EXPECT_GT(pairs[1][1], 100u);
    EXPECT_GT(pairs[0][2] + pairs[2][0], 20u);
}

TEST(SurfaceContacts, TheDeepestTrianglesOfARegionTouchLastWhenPushedOut)
{
    test::Random random(12);
    const auto corners = [](const Shell& s, const sqmap::Pose& pose, std::uint32_t t, Vec3d by) {
        const mesh::Triangle& v = s.mesh.triangles[t];
        return TriangleCorners{apply(pose, s.mesh.vertices[v[0]]) + by, apply(pose, s.mesh.vertices[v[1]]) + by,
                               apply(pose, s.mesh.vertices[v[2]]) + by};
    };
    const Shell hand(test::small_hand()), ball(mesh::ellipsoid({2, 0.7, 1.1}, 2));
    std::size_t count = 0;
    for (int i = 0; i < 200; ++i) {
        const sqmap::Pose pose_a = test::random_pose(random, 0.7), pose_b = test::random_pose(random, 0.7);
        for (const SurfaceContact& c : queried(hand.at(pose_a), ball.at(pose_b)).contacts) {
            if (c.feature_a != Feature::Edge || c.feature_b != Feature::Edge || c.depth < 1e-4f) continue;
            const TriangleCorners a = corners(hand, pose_a, c.index_a / 3, {});
            const auto meets = [&](double by) {
                return crossing_of(a, corners(ball, pose_b, c.index_b / 3, by * cast<double>(c.normal))).meets();
            };
            EXPECT_TRUE(meets(c.depth - 1e-5)) << c.depth;
            EXPECT_FALSE(meets(c.depth + 1e-5)) << c.depth;
            ++count;
        }
    }
    EXPECT_GT(count, 50u);
}

TEST(SurfaceContacts, VerticesAreThoseOfTheExactPair)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    test::Random random(6);
    PairWorkspace workspace(4096);
    for (int i = 0; i < 10; ++i) {
        const Body a = ring.at(test::random_pose(random, 0.5)), b = hand.at(test::random_pose(random, 0.5));
        const Queried q = queried(a, b);
        const PairResult pair = query_pair(a, b, {.query = {.layer = Layer::Exact}, .merge_distance = 0}, workspace);
        ASSERT_GE(q.contacts.size(), pair.contacts.size());
        for (std::size_t k = 0; k < pair.contacts.size(); ++k) {
            EXPECT_EQ(q.contacts[k].depth, pair.contacts[k].depth);
            EXPECT_EQ(q.contacts[k].normal, pair.contacts[k].normal);
            EXPECT_EQ(pair.contacts[k].vertex_of == Side::A ? q.contacts[k].index_a : q.contacts[k].index_b,
                      pair.contacts[k].index);
        }
        EXPECT_EQ(q.result.found, q.contacts.size());
    }
}

TEST(SurfaceContacts, PartsAreThoseOfTheFeaturesInWhateverOrderAProbeHasItsTriangles)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    mesh::Mesh shuffled = hand.mesh;
    std::reverse(shuffled.triangles.begin(), shuffled.triangles.end());
    for (mesh::Triangle& t : shuffled.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
    const Probe other(shuffled.vertices, shuffled.triangles);
    const auto triangles = static_cast<std::uint32_t>(shuffled.triangles.size());
    test::Random random(13);
    std::set<int> parts;
    for (int i = 0; i < 20; ++i) {
        const Body a = ring.at(test::random_pose(random, 0.4)), b = hand.at(test::random_pose(random, 0.4));
        const Queried own = queried(a, b), turned = queried(a, {b.model, &other, b.pose});
        for (const SurfaceContact& c : own.contacts) {
            ASSERT_GE(c.part_b, 0);
            ASSERT_GE(c.part_a, 0);
            parts.insert(c.part_b);
            if (c.feature_b == Feature::Vertex) {
                std::set<std::uint32_t> around;
                for (std::uint32_t t = 0; t < triangles; ++t)
                    for (const std::uint32_t v : hand.mesh.triangles[t])
                        if (v == c.index_b) around.insert(model::part_of_triangle(hand.view, t));
                EXPECT_TRUE(around.count(static_cast<std::uint32_t>(c.part_b)) == 1);
            } else if (c.index_b != k_unnamed) {
                const std::uint32_t t = c.feature_b == Feature::Edge ? c.index_b / 3 : c.index_b;
                EXPECT_EQ(static_cast<std::uint32_t>(c.part_b), model::part_of_triangle(hand.view, t));
            }
        }
        for (const SurfaceContact& c : turned.contacts)
            if (c.feature_b != Feature::Vertex && c.index_b != k_unnamed) {
                const std::uint32_t t = triangles - 1 - (c.feature_b == Feature::Edge ? c.index_b / 3 : c.index_b);
                EXPECT_EQ(static_cast<std::uint32_t>(c.part_b), model::part_of_triangle(hand.view, t));
            }
    }
    EXPECT_GT(parts.size(), 2u);
}

TEST(SurfaceContacts, ARegionKeepsItsDeepestContactAndItsArea)
{
    // Four legs stand on a table top of two triangles, 0.01 deep.
    std::vector<mesh::Mesh> legs;
    for (const double x : {-3., 3.})
        for (const double y : {-2., 2.}) legs.push_back(test::moved(mesh::rounded_box({0.3, 0.3, 1}, 0.1, 4), {x, y, 0.99}));
    const test::Solid table(test::box({-5, -5, -1}, {5, 5, 0})), stool(test::joined(legs));
    const Queried all = queried(table.at(), stool.at()), few = queried(table.at(), stool.at(), {.per_region = 4});
    EXPECT_EQ(few.result.regions, 4u);
    EXPECT_EQ(few.contacts.size(), 16u);
    EXPECT_GT(all.contacts.size(), 16u);
    EXPECT_EQ(few.result.found, all.result.found);
    for (std::uint32_t r = 0; r < 4; ++r) {
        Vec3d lo{9, 9, 9}, hi{-9, -9, -9};
        float deepest = 0;
        for (const SurfaceContact& c : few.contacts) {
            if (c.region != r) continue;
            deepest = std::max(deepest, c.depth);
            for (int k = 0; k < 3; ++k) {
                lo[k] = std::min(lo[k], c.witness.on_a[k]);
                hi[k] = std::max(hi[k], c.witness.on_a[k]);
            }
        }
        EXPECT_NEAR(deepest, 0.01, 1e-5);
        EXPECT_GE(hi.x - lo.x, 0.3) << "of a foot whose flat is 0.4 wide";
        EXPECT_GE(hi.y - lo.y, 0.3);
    }
}

/// Area of the convex hull of the contacts that bear b along a direction, seen along it.
double bearing_area(const std::vector<SurfaceContact>& contacts, const Mat3d& frame)
{
    std::vector<Vec2d> points;
    for (const SurfaceContact& c : contacts) {
        const Vec3d p = transpose_mul(frame, c.witness.on_a), n = transpose_mul(frame, cast<double>(c.normal));
        if (n.z > 0.99) points.push_back({p.x, p.y});
    }
    std::sort(points.begin(), points.end(), [](Vec2d p, Vec2d q) { return p.x != q.x ? p.x < q.x : p.y < q.y; });
    double area = 0;
    for (int side = 0; side < 2; ++side, std::reverse(points.begin(), points.end())) {
        std::vector<Vec2d> chain;
        const auto turn = [](Vec2d a, Vec2d b, Vec2d c) { return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x); };
        for (const Vec2d p : points) {
            while (chain.size() > 1 && turn(chain[chain.size() - 2], chain.back(), p) <= 0) chain.pop_back();
            chain.push_back(p);
        }
        for (std::size_t i = 1; i < chain.size(); ++i) area += 0.5 * (chain[i - 1].x * chain[i].y - chain[i].x * chain[i - 1].y);
    }
    return area;
}

TEST(SurfaceContacts, ABoxOnABoxIsBorneByTheCornersOfWhatTheyShare)
{
    struct Stack {
        double x, y, size, turn, shared;
    };
    const double c = 1 / (1 + std::cos(0.5236) + std::sin(0.5236));
    const Stack stacks[] = {{0, 0, 1, 0, 1},
                            {0.3, 0, 1, 0, 0.7},
                            {0.3, -0.2, 1, 0, 0.56},
                            {1e-9, -1e-9, 1, 1e-9, 1},
                            {1e-5, 0, 1, 0, 1},
                            {0, 0, 0.5, 0, 0.25},
                            {0.5, 0.1, 0.5, 0, 0.25 * 0.5},
                            {0.2, 0.1, 0.5, 1e-7, 0.25},
                            {0, 0, 1, 0.5236, 1 - 2 * c * c * std::sin(0.5236) * std::cos(0.5236)}};
    test::Random random(21);
    const test::Solid lower(test::box({-0.5, -0.5, 0}, {0.5, 0.5, 1}));
    for (const Stack& s : stacks) {
        const double half = 0.5 * s.size;
        const test::Solid upper(test::box({-half, -half, 0}, {half, half, s.size}));
        for (const bool is_raised_turned : {false, true})
            for (const double depth : {0., 1e-7, 1e-4, 0.01}) {
                const Mat3d frame = is_raised_turned ? test::rotation_about(random.direction(), 1) : Mat3d{};
                if (depth == 0 && is_raised_turned) continue;  // rounding parts them
                const Mat3d tilt = test::rotation_about({1, 0, 0}, 1e-3 * depth);
                const sqmap::Pose a{frame, {}};
                const sqmap::Pose b{frame * (tilt * test::rotation_about({0, 0, 1}, s.turn)), frame * Vec3d{s.x, s.y, 1 - depth}};
                for (const std::uint32_t kept : {0u, s.turn > 0.1 ? 8u : 4u}) {
                    SCOPED_TRACE(testing::Message()
                                 << s.x << ' ' << s.size << ' ' << s.turn << " depth " << depth << " kept " << kept);
                    for (const bool has_models : {true, false}) {
                        const Body below = has_models ? lower.at(a) : Body{nullptr, &lower.probe, a};
                        const Body above = has_models ? upper.at(b) : Body{nullptr, &upper.probe, b};
                        const Queried there = queried(below, above, {.per_region = kept});
                        EXPECT_GE(bearing_area(there.contacts, frame), 0.9 * s.shared) << has_models;
                        expect_every_region_has_a_contact(there);
                        for (const SurfaceContact& found : there.contacts) EXPECT_LE(found.depth, 1.001 * depth + 1e-6);
                    }
                }
            }
    }
}

TEST(SurfaceContacts, EveryRegionKeepsAContactWhenReduced)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    test::Random random(7);
    for (int i = 0; i < 20; ++i) {
        const Body a = ring.at(test::random_pose(random, 0.5)), b = hand.at(test::random_pose(random, 0.5));
        const Queried all = queried(a, b), one = queried(a, b, {.per_region = 1}), few = queried(a, b, {.per_region = 6});
        EXPECT_EQ(one.contacts.size(), one.result.regions);
        expect_every_region_has_a_contact(one);
        expect_every_region_has_a_contact(few);
        float deepest = 0, kept = 0;
        for (const SurfaceContact& c : all.contacts) deepest = std::max(deepest, c.depth);
        for (const SurfaceContact& c : one.contacts) kept = std::max(kept, c.depth);
        EXPECT_EQ(kept, deepest);
    }
}

TEST(SurfaceContacts, ReducedContactsAreTheSameWhereAWorkspaceHasLessSpaceThanABodyVertices)
{
    const test::Solid ball(mesh::sphere(1, 4));
    test::Random random(15);
    std::size_t regions = 0;
    for (int i = 0; i < 10; ++i) {
        const Body a = ball.at(test::random_pose(random, 0)),
                   b = ball.at(test::shifted(random.between(1.96, 1.995) * random.direction()));
        ContactWorkspace small(100), large(10000);
        const ContactResult few = query_contacts(a, b, {.per_region = 4}, small),
                            all = query_contacts(a, b, {.per_region = 4}, large);
        EXPECT_EQ(few.status, k_ok);
        EXPECT_EQ(few.regions, all.regions);
        ASSERT_EQ(few.contacts.size(), all.contacts.size());
        for (std::size_t k = 0; k < all.contacts.size(); ++k) {
            EXPECT_EQ(few.contacts[k].witness.on_a, all.contacts[k].witness.on_a);
            EXPECT_EQ(few.contacts[k].region, all.contacts[k].region);
        }
        regions += all.regions;
    }
    EXPECT_GT(regions, 5u);
}

TEST(SurfaceContacts, FirstOnlySaysWhetherThereIsAny)
{
    const test::Solid hand(test::small_hand()), ring(test::small_torus());
    test::Random random(8);
    for (int i = 0; i < 40; ++i) {
        const Body a = ring.at(test::random_pose(random, 0.8)), b = hand.at(test::random_pose(random, 0.8));
        const Queried all = queried(a, b), first = queried(a, b, {.first_only = true});
        EXPECT_EQ(first.contacts.size(), all.contacts.empty() ? 0u : 1u);
        EXPECT_EQ(first.result.found, first.contacts.size());
    }
}

TEST(SurfaceContacts, BadInputHasAStatus)
{
    const Shell box(test::box({0, 0, 0}, {1, 1, 1}));
    const Probe points(box.mesh.vertices);
    sqmap::Pose nowhere;
    nowhere.translation.y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(queried(box.at(), box.at(nowhere)).result.status, k_not_finite);
    EXPECT_EQ(queried(box.at(), {nullptr, &points, {}}).result.status, k_no_triangles);
    EXPECT_EQ(queried({}, {}).result.status, k_no_triangles);
    for (const double far : {1e6, 1e30, 1e200, std::numeric_limits<double>::max()}) {
        const Queried q = queried(box.at(), box.at(test::shifted({far, -far, far})));
        EXPECT_EQ(q.result.status, k_ok);
        EXPECT_TRUE(q.contacts.empty());
    }
    ContactWorkspace tiny(2);
    const ContactResult r = query_contacts(box.at(), box.at(), {}, tiny);
    EXPECT_EQ(r.status, k_full);
    EXPECT_GT(r.found, r.contacts.size());
}

TEST(SurfaceContacts, AMovedProbeTouchesWhereItIs)
{
    const mesh::Mesh bar = test::diamond_bar(false, 3, 1, 1.9);
    const Shell lower(test::diamond_bar(true, 3, 1, 0));
    Probe upper(bar.vertices, bar.triangles);
    EXPECT_EQ(queried(lower.at(), {nullptr, &upper, {}}).contacts.size(), 1u);
    std::vector<Vec3d> raised = bar.vertices;
    for (Vec3d& v : raised) v.z += 0.2;
    upper.move(raised);
    EXPECT_TRUE(queried(lower.at(), {nullptr, &upper, {}}).contacts.empty());
    upper.move(bar.vertices);
    EXPECT_EQ(queried(lower.at(), {nullptr, &upper, {}}).contacts.size(), 1u);
}

}  // namespace
}  // namespace sqmap::query
