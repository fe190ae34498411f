#include "sqmap/query/skin.h"

#include "sqmap/bake/skin_lattice.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "support/bodies.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace sqmap::query {
namespace {

/// A finger of three bones along x, at its joints blended over a quarter of its length.
struct Finger {
    static constexpr double k_joints[2] = {-0.3, 0.35};
    mesh::Mesh mesh = mesh::ellipsoid({1, 0.25, 0.2}, 4);
    mesh::Influences influences;
    test::Parsed model{mesh};
    SkinLattice lattice;
    double r_max = mesh::largest_vertex_distance(mesh);

    Finger()
    {
        for (const Vec3d& v : mesh.vertices) {
            const auto past = [&](double joint) { return std::clamp(0.5 + (v.x - joint) / 0.25, 0.0, 1.0); };
            const double first = past(k_joints[0]), second = past(k_joints[1]);
            influences.joints.push_back({0, 1, 2, 0});
            influences.weights.push_back({1 - first, first - second, second, 0});
        }
        lattice = bake::skin_lattice(mesh, influences);
    }
    static const Finger& get()
    {
        static const Finger k_finger;
        return k_finger;
    }
    /// Each joint bent by an angle.
    static std::vector<Affine> bent(double angle)
    {
        const Mat3d turn = test::rotation_about({0, 0, 1}, angle);
        const auto about = [&](double x) { return Affine{turn, Vec3d{x, 0, 0} - turn * Vec3d{x, 0, 0}}; };
        const Affine first = about(k_joints[0]);
        return {{}, first, first * about(k_joints[1])};
    }
    mesh::Mesh posed(std::span<const Affine> maps) const
    {
        mesh::Mesh m = mesh;
        m.vertices = mesh::skinned(mesh.vertices, influences, maps);
        return m;
    }
};

/// Beside the surface, up to a share of r_max.
std::vector<Vec3d> points_near(const mesh::Mesh& mesh, double reach, std::size_t count, test::Random& random)
{
    std::vector<Vec3d> points;
    while (points.size() < count) {
        const mesh::Triangle& t = mesh.triangles[random.below(mesh.triangles.size())];
        double u = random.between(0, 1), v = random.between(0, 1);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        points.push_back(mesh.vertices[t[0]] + u * (mesh.vertices[t[1]] - mesh.vertices[t[0]]) +
                         v * (mesh.vertices[t[2]] - mesh.vertices[t[0]]) + random.between(0, reach) * random.direction());
    }
    return points;
}

struct SkinAnswer {
    ProbeResult result;
    std::vector<SkinContact> contacts;
    std::vector<double> depth;  // of each point, -1 where free
};

SkinAnswer answer_of(const PosedSkin& skin, std::span<const Vec3d> points, Layer layer, std::size_t space_for = 100000)
{
    const Finger& finger = Finger::get();
    SkinWorkspace workspace(finger.lattice, points);
    SkinAnswer answer;
    answer.contacts.resize(std::min(space_for, points.size()));
    answer.result = query_skin({&finger.model.view(), &skin, points, {}}, {.layer = layer}, workspace, answer.contacts);
    answer.contacts.resize(std::min(answer.contacts.size(), answer.result.contacts));
    answer.depth.assign(points.size(), -1);
    for (const SkinContact& c : answer.contacts) answer.depth[c.index] = c.depth;
    return answer;
}

TEST(Skin, VerdictsAreThoseOfTheSkinnedMeshFromStraightToRolledUp)
{
    const Finger& finger = Finger::get();
    PosedSkin skin(finger.lattice);
    test::Random random(3);
    for (const double angle : {0.0, 0.5, 1.0, 1.5, 2.0, 2.5}) {
        const std::vector<Affine> maps = Finger::bent(angle);
        ASSERT_TRUE(skin.pose(maps));
        const mesh::Mesh posed = finger.posed(maps);
        const mesh::Bvh truth(posed);
        // As far as the lattice's own surface is beside the skinned one verdicts may differ, and no farther.
        const double deviation = bake::skin_deviation(finger.lattice, finger.mesh, finger.influences, maps);
        EXPECT_LT(deviation, (angle <= 1 ? 0.005 : 0.01) * finger.r_max) << "bent by " << angle;
        const std::vector<Vec3d> points = points_near(posed, 0.03 * finger.r_max, 10000, random);
        for (const Layer layer : {Layer::Three, Layer::Exact}) {
            const SkinAnswer answer = answer_of(skin, points, layer);
            const double band = layer == Layer::Exact ? deviation + 1e-4 * finger.r_max : 0.005 * finger.r_max;
            std::size_t inside = 0, wrong = 0;
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (truth.closest_point(points[i]).distance <= band) continue;
                const bool is_inside = truth.winding_number(points[i]) > 0;
                inside += is_inside ? 1 : 0;
                wrong += is_inside != (answer.depth[i] >= 0) ? 1 : 0;
            }
            EXPECT_EQ(wrong, 0u) << "bent by " << angle << ", layer " << static_cast<int>(layer);
            EXPECT_GT(inside, 1500u);
        }
    }
}

TEST(Skin, CoverageWithSignIsTheWindingNumber)
{
    // Bent so far that the finger passes through itself and its inner side is turned inside out.
    const Finger& finger = Finger::get();
    const std::vector<Affine> maps = Finger::bent(2.5);
    PosedSkin skin(finger.lattice);
    ASSERT_TRUE(skin.pose(maps));
    const mesh::Mesh posed = finger.posed(maps);
    const mesh::Bvh truth(posed), bound(finger.mesh);
    const double deviation = bake::skin_deviation(finger.lattice, finger.mesh, finger.influences, maps);
    test::Random random(8);
    std::size_t twice = 0, turned = 0;
    for (const Vec3d p : points_near(posed, 0.1 * finger.r_max, 20000, random)) {
        if (truth.closest_point(p).distance <= deviation + 1e-4 * finger.r_max) continue;
        PreImage positions[16];
        const std::size_t count = skin.carry_back(p, positions);
        ASSERT_LE(count, 16u);
        int covered = 0;
        for (const PreImage& position : std::span(positions).first(count)) {
            const bool inside = bound.winding_number(position.bound) > 0;
            covered += inside ? position.sign : 0;
            turned += inside && position.sign < 0 ? 1 : 0;
            EXPECT_LT(norm(apply(position.local, position.bound) - p), 1e-9);
        }
        EXPECT_EQ(covered, truth.winding_number(p));
        twice += covered > 1 ? 1 : 0;
    }
    EXPECT_GT(twice, 20u);
    EXPECT_GT(turned, 20u);
}

TEST(Skin, WhatIsCarriedForwardIsFoundAgain)
{
    const Finger& finger = Finger::get();
    PosedSkin skin(finger.lattice);
    ASSERT_TRUE(skin.pose(Finger::bent(1.2)));
    test::Random random(9);
    for (int i = 0; i < 3000; ++i) {
        const Vec3d p = random.in_box({-1, -0.25, -0.2}, {1, 0.25, 0.2});
        Affine local;
        if (!skin.carry_forward(p, local)) continue;
        PreImage positions[16];
        const std::size_t count = skin.carry_back(apply(local, p), positions);
        EXPECT_TRUE(std::any_of(positions, positions + count, [&](const PreImage& at) { return norm(at.bound - p) < 1e-6; }));
    }
}

TEST(Skin, BonesThatMoveAlikeMoveTheModel)
{
    const Finger& finger = Finger::get();
    const Mat3d turn = test::rotation_about(normalized(Vec3d{1, 2, -1}), 1.1);
    const Affine map{turn, {3, -2, 5}};
    PosedSkin skin(finger.lattice);
    ASSERT_TRUE(skin.pose(std::array{map, map, map}));
    test::Random random(10);
    const std::vector<Vec3d> points = points_near(finger.posed(std::array{map, map, map}), 0.1, 4000, random);
    const SkinAnswer answer = answer_of(skin, points, Layer::Exact);
    Probe probe(points);
    std::vector<Contact> rigid(points.size());
    const Body posed{.model = &finger.model.view(), .pose = {turn, map.shift}};
    const ProbeResult r = query_probe(posed, {.probe = &probe}, {.layer = Layer::Exact}, rigid);
    ASSERT_EQ(r.contacts, answer.result.contacts);
    ASSERT_GT(r.contacts, 1000u);
    rigid.resize(r.contacts);
    std::sort(rigid.begin(), rigid.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
    int ties = 0;
    for (std::size_t i = 0; i < rigid.size(); ++i) {
        EXPECT_EQ(rigid[i].index, answer.contacts[i].index);
        EXPECT_NEAR(rigid[i].depth, answer.contacts[i].depth, 1e-5);
        const Vec3d point = points[rigid[i].index], one = r.position(rigid[i]), other = answer.contacts[i].witness;
        if (norm(one - other) > 1e-5) {
            // Two places of the surface are equally near within rounding: each answer is at one of them.
            ++ties;
            EXPECT_NEAR(norm(one - point), rigid[i].depth, 1e-5);
            EXPECT_NEAR(norm(other - point), rigid[i].depth, 1e-5);
            continue;
        }
        EXPECT_GT(dot(cast<double>(rigid[i].normal), answer.contacts[i].normal), 1 - 1e-6);
    }
    EXPECT_LE(ties, 2);
}

TEST(Skin, DepthAndNormalFollowTheBend)
{
    const Finger& finger = Finger::get();
    const std::vector<Affine> maps = Finger::bent(0.8);
    PosedSkin skin(finger.lattice);
    ASSERT_TRUE(skin.pose(maps));
    const mesh::Mesh posed = finger.posed(maps);
    const mesh::Solid truth(posed, mesh::find_self_intersections(posed).crossed);
    test::Random random(11);
    const std::vector<Vec3d> points = points_near(posed, 0.03 * finger.r_max, 4000, random);
    std::vector<double> depth, normal;
    for (const SkinContact& c : answer_of(skin, points, Layer::Exact).contacts) {
        const mesh::ClosestPoint closest = truth.closest_boundary(points[c.index]);
        depth.push_back(std::abs(c.depth - closest.distance) / finger.r_max);
        if (closest.distance > 1e-3 * finger.r_max) normal.push_back(dot(normalized(closest.point - points[c.index]), c.normal));
        EXPECT_NEAR(norm(c.witness - points[c.index] - c.depth * c.normal), 0, 1e-12);
    }
    std::sort(depth.begin(), depth.end());
    std::sort(normal.begin(), normal.end());
    ASSERT_GT(depth.size(), 1000u);
    EXPECT_LT(depth[depth.size() / 2], 0.0005);
    EXPECT_LT(depth[depth.size() * 95 / 100], 0.004);
    EXPECT_GT(normal[normal.size() / 2], std::cos(0.05));
    EXPECT_GT(normal[normal.size() * 5 / 100], std::cos(0.35));
}

TEST(Skin, WhatCannotBeAskedIsFreeAndSaid)
{
    const Finger& finger = Finger::get();
    PosedSkin skin(finger.lattice);
    ASSERT_TRUE(skin.pose(Finger::bent(0.5)));
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<Affine> bad = Finger::bent(1);
    bad[1].linear.row[2].y = nan;
    EXPECT_FALSE(skin.pose(bad));
    EXPECT_FALSE(skin.pose(std::span(bad).first(2)));
    // The pose before still stands.
    const std::vector<Vec3d> points{{-0.7, 0, 0}, {nan, 0, 0},  {0, std::numeric_limits<double>::infinity(), 0},
                                    {1e30, 0, 0}, {-0.6, 0, 0}, {-0.6, 0, 1}};
    const SkinAnswer answer = answer_of(skin, points, Layer::Exact);
    ASSERT_EQ(answer.result.contacts, 2u);
    EXPECT_EQ(answer.contacts[0].index, 0u);
    EXPECT_EQ(answer.contacts[1].index, 4u);
    const SkinAnswer narrow = answer_of(skin, points, Layer::Exact, 1);
    EXPECT_EQ(narrow.result.contacts, 2u);
    EXPECT_NE(narrow.result.status & k_full, 0);
    SkinWorkspace workspace(finger.lattice, points);
    std::vector<SkinContact> contacts(6);
    const model::ModelView& bound = finger.model.view();
    EXPECT_EQ(query_skin({&bound, &skin, std::span(points).first(3), {}}, {}, workspace, contacts).contacts, 0u);
    EXPECT_EQ(query_skin({&bound, &skin, points, {}}, {.first_only = true}, workspace, contacts).contacts, 1u);
    // A bone that is shrunk to nothing takes what it alone moves with it.
    std::vector<Affine> flat = Finger::bent(0);
    for (Vec3d& row : flat[0].linear.row) row = {};
    ASSERT_TRUE(skin.pose(flat));
    EXPECT_EQ(answer_of(skin, points, Layer::Exact).result.contacts, 0u);
}

TEST(Skin, LatticesOfNothingAreRefused)
{
    const Finger& finger = Finger::get();
    EXPECT_THROW((void)bake::skin_lattice({}, {}), mesh::InvalidInput);
    EXPECT_THROW((void)bake::skin_lattice(finger.mesh, {}), mesh::InvalidInput);
    EXPECT_THROW((void)bake::skin_lattice(finger.mesh, finger.influences, {.cell = 1}), mesh::InvalidInput);
    mesh::Influences none = finger.influences;
    none.weights[5] = {};
    EXPECT_THROW((void)bake::skin_lattice(finger.mesh, none), mesh::InvalidInput);
}

/// A finger that bends in one step, and points that move in it.
struct SweptFinger {
    MovingSkin skin{Finger::get().lattice};
    std::vector<SkinContact> contacts;
    SweptResult result;

    SweptFinger(double from, double to, std::span<const Vec3d> previous, std::span<const Vec3d> now, double step)
    {
        EXPECT_TRUE(skin.step(Finger::bent(from)));
        EXPECT_TRUE(skin.step(Finger::bent(to)));
        SkinWorkspace workspace(Finger::get().lattice, now);
        contacts.resize(now.size());
        SweptOptions options;
        options.step = step;
        result = query_swept_skin({&Finger::get().model.view(), &skin, previous, now, {}}, options, workspace, contacts);
        contacts.resize(std::min(contacts.size(), result.probe.contacts));
    }
};

TEST(SweptSkin, PointsThatJumpThroughItAreCaughtOnTheSideTheyCameFrom)
{
    std::vector<Vec3d> above, below;
    for (double x = -0.8; x < 0.81; x += 0.05) {
        above.push_back({x, 0, 0.5});
        below.push_back({x, 0.01, -0.45});
    }
    EXPECT_EQ(SweptFinger(0, 0, above, below, 10).result.probe.contacts, 0u);  // a frame alone sees nothing
    const SweptFinger swept(0, 0, above, below, 0.1);
    ASSERT_EQ(swept.contacts.size(), above.size());
    EXPECT_EQ(swept.result.caught, above.size());
    for (const SkinContact& c : swept.contacts) {
        EXPECT_GT(c.normal.z, 0.5);
        // The plane at the ellipsoid's surface, straight above where the point came in or near it.
        EXPECT_GT(c.depth, 0.45);
        EXPECT_LT(c.depth, 0.45 + 0.2 + 0.02);
        EXPECT_LT(norm(c.witness - below[c.index] - c.depth * c.normal), 1e-12);
    }
}

TEST(SweptSkin, AFingerThatSweepsOverPointsCatchesThemToo)
{
    // The surface near its tip goes up by about 0.8; the points stand still where it passes.
    const std::vector<Vec3d> points{{0.8, 0.02, 0}, {0.83, 0, 0.02}, {0.78, 0.04, -0.03}};
    EXPECT_EQ(SweptFinger(-0.25, 0.3, points, points, 100).result.probe.contacts, 0u);
    const SweptFinger swept(-0.25, 0.3, points, points, 0.05);
    EXPECT_EQ(swept.contacts.size(), points.size());
    for (const SkinContact& c : swept.contacts) {
        // On the upper side as the finger ends: the surface's normal there, turned with it.
        EXPECT_GT(c.bound_normal.y, 0.5);
        EXPECT_GT(c.normal.y, 0);
        EXPECT_GT(c.depth, 0);
    }
}

TEST(SweptSkin, WhatHardlyMovesAnswersAsAQueryDoes)
{
    test::Random random(7);
    const std::vector<Vec3d> points = points_near(Finger::get().posed(Finger::bent(0.5)), 0.05, 400, random);
    const SweptFinger swept(0.499, 0.5, points, points, 0.05);
    const PosedSkin& end = swept.skin.to();
    const SkinAnswer alone = answer_of(end, points, Layer::Three);
    EXPECT_EQ(swept.result.fast, 0u);
    EXPECT_GT(swept.skin.motion(), 0.001 * 0.3);  // of the tip, two joints away
    ASSERT_EQ(swept.contacts.size(), alone.contacts.size());
    for (std::size_t c = 0; c < swept.contacts.size(); ++c) {
        EXPECT_EQ(swept.contacts[c].index, alone.contacts[c].index);
        EXPECT_EQ(swept.contacts[c].depth, alone.contacts[c].depth);
    }
}

}  // namespace
}  // namespace sqmap::query
