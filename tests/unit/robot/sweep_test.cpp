// sqmap urdf --sweep: verdicts against closed forms, against the exact layer, and the parts of its proof by themselves.
#include "sqmap/robot/sweep.h"

#include "math/random.h"
#include "math/triangle.h"
#include "robot/bodies.h"
#include "robot/chain.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/math/rotation.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/query/contacts.h"
#include "sqmap/query/distance.h"
#include "sqmap/robot/rewrite.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>

namespace sqmap::robot {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for each test.
fs::path own_folder()
{
    const fs::path folder =
        fs::path(testing::TempDir()) / "sqmap_sweep" / testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::create_directories(folder);
    return folder;
}

void write_obj(const fs::path& path, const mesh::Mesh& mesh)
{
    std::ofstream file(path);
    file.precision(17);
    for (const Vec3d& v : mesh.vertices) file << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
    for (const mesh::Triangle& t : mesh.triangles) file << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
}

std::string collision(const std::string& geometry, const std::string& xyz = "0 0 0")
{
    return "<collision><origin xyz='" + xyz + "'/><geometry>" + geometry + "</geometry></collision>";
}
std::string link(const std::string& name, const std::string& shapes) { return "<link name='" + name + "'>" + shapes + "</link>"; }
std::string joint(const std::string& name, const std::string& parent, const std::string& child, const std::string& rest,
                  const std::string& type = "revolute")
{
    return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent + "'/><child link='" + child + "'/>" + rest +
           "</joint>";
}
Sweep swept(const std::string& elements, SweepOptions options = {})
{
    return sweep("<robot name='made'>" + elements + "</robot>", own_folder() / "made.urdf", options);
}

/// A ball on an arm of length 1 that turns about z from one angle to the other; a ball at the end of angle 0. A second joint,
/// which cannot move, keeps the links from being neighbours.
std::string two_balls(double lower, double upper)
{
    return link("base", collision("<sphere radius='0.1'/>", "1 0 0")) + link("between", "") +
           link("arm", collision("<sphere radius='0.1'/>", "1 0 0")) +
           joint("turn", "base", "between",
                 "<axis xyz='0 0 1'/><limit lower='" + std::to_string(lower) + "' upper='" + std::to_string(upper) + "'/>") +
           joint("stop", "between", "arm", "<axis xyz='0 0 1'/><limit lower='0' upper='0'/>", "prismatic");
}

TEST(Sweep, BallsOnAnArmAreAsFarApartAsTheirChordSays)
{
    for (const double lower : {0.25, 0.5, 1.5}) {
        const Sweep result = swept(two_balls(lower, 2.5));
        ASSERT_EQ(result.pairs.size(), 1u);
        const SweptPair& pair = result.pairs[0];
        const double truth = 2 * std::sin(0.5 * lower) - 0.2;
        EXPECT_EQ(pair.verdict, PairVerdict::Free);
        EXPECT_GE(pair.seen, truth - 1e-9);
        EXPECT_LE(pair.seen, truth + 0.02);
        EXPECT_LE(pair.bound, truth);
        EXPECT_GE(pair.bound, 0.49 * truth);
        ASSERT_EQ(pair.pose.size(), 2u);
        EXPECT_EQ(pair.pose[0].joint, "turn");
        EXPECT_NEAR(2 * std::sin(0.5 * pair.pose[0].value) - 0.2, pair.seen, 1e-9);
    }
    const SweptPair hit = swept(two_balls(0.15, 2.5)).pairs[0];
    EXPECT_EQ(hit.verdict, PairVerdict::Colliding);
    EXPECT_LE(2 * std::sin(0.5 * hit.pose.at(0).value), 0.2 + 1e-9);
}

/// Two fingers; the second follows the first. gap: between the balls where both are at 0.
std::string fingers(double lower, double gap, const std::string& mimic)
{
    const std::string limit = "<limit lower='" + std::to_string(lower) + "' upper='0.04'/>";
    const std::string ball = collision("<sphere radius='0.01'/>"), half = std::to_string(0.01 + 0.5 * gap);
    return link("hand", "") + link("left", ball) + link("right", ball) +
           joint("one", "hand", "left", "<origin xyz='" + half + " 0 0'/><axis xyz='1 0 0'/>" + limit, "prismatic") +
           joint("two", "hand", "right", "<origin xyz='-" + half + " 0 0'/><axis xyz='-1 0 0'/>" + limit + mimic, "prismatic");
}

TEST(Sweep, AFingerThatFollowsAnotherKeepsItsDistance)
{
    const std::string follows = "<mimic joint='one'/>";
    const SweptPair apart = swept(fingers(-0.04, 0.1, follows)).pairs.at(0);
    EXPECT_EQ(apart.verdict, PairVerdict::Free);
    EXPECT_NEAR(apart.seen, 0.02, 1e-3);
    EXPECT_GT(apart.bound, 0.0095);
    ASSERT_EQ(apart.pose.size(), 1u);
    // The same fingers meet where they move one in the direction of the other: clearance does not depend on the position.
    const SweptPair steady = swept(fingers(-0.04, 0.1, "<mimic joint='one' multiplier='-1'/>")).pairs.at(0);
    EXPECT_EQ(steady.verdict, PairVerdict::Free);
    EXPECT_NEAR(steady.seen, 0.1, 1e-9);
    EXPECT_EQ(swept(fingers(-0.06, 0.1, follows)).pairs.at(0).verdict, PairVerdict::Colliding);
    // A follower at twice the speed stops at its own limits, -0.04: the gap closes to 0.1 - 0.02 - 0.04.
    const SweptPair stopped = swept(fingers(-0.04, 0.1, "<mimic joint='one' multiplier='2'/>")).pairs.at(0);
    EXPECT_EQ(stopped.verdict, PairVerdict::Free);
    EXPECT_NEAR(stopped.seen, 0.04, 1e-3);
}

TEST(Sweep, AShapeWithinASolidCollidesThoughNoSurfaceIsNear)
{
    const fs::path folder = own_folder();
    write_obj(folder / "shell.obj", mesh::sphere(1, 3));
    const std::string limit = "<axis xyz='1 0 0'/><limit lower='-0.1' upper='0.1'/>";
    const auto verdict = [&](const std::string& outer) {
        return swept(link("outer", collision(outer)) + link("between", "") + link("inner", collision("<sphere radius='0.1'/>")) +
                     joint("a", "outer", "between", limit) + joint("b", "between", "inner", limit, "prismatic"))
            .pairs.at(0)
            .verdict;
    };
    EXPECT_EQ(verdict("<mesh filename='shell.obj'/>"), PairVerdict::Colliding);
    EXPECT_EQ(verdict("<box size='2 2 2'/>"), PairVerdict::Colliding);
    EXPECT_EQ(verdict("<cylinder radius='1' length='2'/>"), PairVerdict::Colliding);
    EXPECT_EQ(verdict("<sphere radius='1'/>"), PairVerdict::Colliding);
}

TEST(Sweep, OnlyWhatIsProvenBecomesSrdf)
{
    // A floats; c's mesh is missing; d and e are fixed to the root, apart from one another; root and d are neighbours.
    const std::string ball = collision("<sphere radius='0.1'/>");
    const std::string text = link("root", ball) + link("a", ball) + link("c", collision("<mesh filename='gone.obj'/>")) +
                             link("d", ball) + link("e", ball) + joint("float", "root", "a", "", "floating") +
                             joint("jc", "root", "c", "<origin xyz='0 0 5'/>", "fixed") +
                             joint("jd", "root", "d", "<origin xyz='1 0 0'/>", "fixed") +
                             joint("je", "root", "e", "<origin xyz='0 1 0'/>", "fixed");
    const Sweep result = swept(text);
    std::map<std::string, const SweptPair*> by_name;
    for (const SweptPair& p : result.pairs) by_name[p.a + p.b] = &p;
    EXPECT_EQ(by_name.at("roota")->verdict, PairVerdict::Open);
    EXPECT_NE(by_name.at("roota")->reason.text().find("'float' has no limits"), std::string::npos);
    EXPECT_EQ(by_name.at("ce")->verdict, PairVerdict::Open);
    EXPECT_NE(by_name.at("ce")->reason.text().find("gone.obj"), std::string::npos);
    EXPECT_EQ(by_name.at("rootd")->verdict, PairVerdict::Adjacent);
    const SweptPair& fixed = *by_name.at("de");
    EXPECT_EQ(fixed.verdict, PairVerdict::Free);
    EXPECT_TRUE(fixed.fixed);
    EXPECT_NEAR(fixed.seen, std::sqrt(2.) - 0.2, 1e-12);
    EXPECT_NEAR(fixed.bound, std::sqrt(2.) - 0.2, 1e-6);
    const std::string srdf = srdf_text("made", result);
    const auto count = [&](const std::string& part) {
        std::size_t n = 0;
        for (std::size_t at = srdf.find(part); at != std::string::npos; at = srdf.find(part, at + 1)) ++n;
        return n;
    };
    EXPECT_EQ(count("reason=\"Never\""), 1u);
    EXPECT_EQ(count("reason=\"Adjacent\""), 3u);  // the root with c, d and e
    EXPECT_EQ(count("disable_collisions"), 4u);
    EXPECT_THROW((void)swept(text, {.pairs = {{"d", "nobody"}}}), DescriptionError);
    EXPECT_THROW((void)swept(text, {.pairs = {{"d", "d"}}}), DescriptionError);
    EXPECT_THROW((void)swept(text, {.seconds = 0}), mesh::InvalidInput);
}

TEST(Sweep, TrianglesAreAsFarApartAsAlternatingProjectionsFind)
{
    SplitMix64 random(5);
    const auto point = [&](double size) {
        return Vec3d{random.between(-size, size), random.between(-size, size), random.between(-size, size)};
    };
    int met = 0;
    for (int i = 0; i < 3000; ++i) {
        const Vec3d shift = point(2);
        const Vec3d a[3] = {point(1), point(1), point(1)}, b[3] = {shift + point(1), shift + point(1), shift + point(1)};
        const double found = distance_of(a, b);
        // Projections onto two convex sets in turn converge to the nearest points (W. Cheney, A. Goldstein, 1959).
        Vec3d p = a[0], q = b[0];
        for (int step = 0; step < 400; ++step) {
            q = closest_point_on_triangle(p, b[0], b[1], b[2]);
            p = closest_point_on_triangle(q, a[0], a[1], a[2]);
        }
        EXPECT_LE(found, norm(p - q) + 1e-12);
        EXPECT_GE(found, norm(p - q) - 2e-2) << i;
        met += found == 0 ? 1 : 0;
    }
    EXPECT_GT(met, 50);
}

/// A made arm: links like dumbbells and rounded bars along z, joints that turn about z and y by turns.
struct Arm {
    std::vector<mesh::Mesh> meshes;
    std::string text;
};
Arm made_arm(int joints, const fs::path& folder)
{
    Arm arm;
    std::string links, chain;
    for (int i = 0; i <= joints; ++i) {
        mesh::Mesh m;
        if (i % 2 == 0) {
            m = mesh::dumbbell({.ball_radius = 0.055, .bar_radius = 0.03, .half_distance = 0.08, .segments = 12});
        } else {
            m = mesh::rounded_box({0.045, 0.045, 0.1}, 0.02, 2);
        }
        for (Vec3d& v : m.vertices) v = v + Vec3d{0.01 * (i % 3), 0, 0.1};
        const std::string name = "link" + std::to_string(i);
        write_obj(folder / (name + ".obj"), m);
        links += link(name, collision("<mesh filename='" + name + ".obj'/>"));
        if (i > 0)
            chain += joint("joint" + std::to_string(i), "link" + std::to_string(i - 1), name,
                           std::string("<origin xyz='0 ") + (i % 2 == 0 ? "0" : "0.03") + " 0.23' rpy='0 0.2 0'/><axis xyz='" +
                               (i % 2 == 0 ? "0 1 0" : "0 0 1") + "'/><limit lower='-2.2' upper='2.4'/>");
        arm.meshes.push_back(std::move(m));
    }
    arm.text = "<robot name='arm'>" + links + chain + "</robot>";
    return arm;
}

/// Poses of all links of a chain of joints, each the parent of the next one.
std::vector<Pose> poses_of(const Description& robot, const std::vector<double>& values)
{
    std::vector<Pose> out(robot.links.size());
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
        const Joint& j = robot.joints[i];
        out[j.child] = compose(out[j.parent], compose(j.origin, Pose{rotation_by(values[i] * j.axis), {}}));
    }
    return out;
}

/// Sweeps the arm; at random poses no pair that is called free touches or is nearer than its bound by the exact layer, and the
/// poses that are given do collide.
void compare_with_the_exact_layer(int joints, int samples)
{
    const fs::path folder = own_folder();
    const Arm arm = made_arm(joints, folder);
    const Description robot = read_description(arm.text, "arm.urdf");
    const Sweep result = sweep(arm.text, folder / "arm.urdf", {});
    std::vector<BakedModel> models;
    std::vector<model::ModelView> views;
    std::vector<query::Probe> probes;
    for (const mesh::Mesh& m : arm.meshes) models.push_back(bake_mesh(m));
    for (std::size_t i = 0; i < models.size(); ++i) {
        const mesh::Mesh& m = models[i].mesh.mesh;
        views.push_back(models[i].view());
        probes.emplace_back(m.vertices, m.triangles);
    }
    query::ContactWorkspace workspace(256);
    const auto index = [](const std::string& name) { return static_cast<std::size_t>(std::stoi(name.substr(4))); };
    const auto touch = [&](const std::vector<Pose>& poses, std::size_t a, std::size_t b) {
        return query::query_contacts({&views[a], &probes[a], poses[a]}, {&views[b], &probes[b], poses[b]}, {.first_only = true},
                                     workspace)
                   .found > 0;
    };
    std::size_t count[4] = {}, hits = 0;
    for (const SweptPair& pair : result.pairs) {
        ++count[static_cast<std::size_t>(pair.verdict)];
        if (pair.verdict != PairVerdict::Colliding) continue;
        std::vector<double> values(robot.joints.size());
        for (const SweptPair::Position& p : pair.pose)
            values[static_cast<std::size_t>(std::stoi(p.joint.substr(5))) - 1] = p.value;
        EXPECT_TRUE(touch(poses_of(robot, values), index(pair.a), index(pair.b))) << pair.a << ' ' << pair.b;
    }
    EXPECT_EQ(count[static_cast<std::size_t>(PairVerdict::Open)], 0u);
    EXPECT_EQ(count[static_cast<std::size_t>(PairVerdict::Adjacent)], static_cast<std::size_t>(joints));
    EXPECT_GE(count[static_cast<std::size_t>(PairVerdict::Free)], 2u);
    EXPECT_GE(count[static_cast<std::size_t>(PairVerdict::Colliding)], 1u);
    SplitMix64 random(77);
    for (int i = 0; i < samples; ++i) {
        std::vector<double> values;
        for (const Joint& j : robot.joints) values.push_back(random.between(j.lower, j.upper));
        const std::vector<Pose> poses = poses_of(robot, values);
        for (const SweptPair& pair : result.pairs) {
            const std::size_t a = index(pair.a), b = index(pair.b);
            if (pair.verdict == PairVerdict::Free) {
                ASSERT_FALSE(touch(poses, a, b)) << pair.a << ' ' << pair.b << " at pose " << i;
                const Vec3d v = apply(poses[b], models[b].mesh.mesh.vertices[static_cast<std::size_t>(i) % 50]);
                ASSERT_GE(query::exact_distance({&views[a], nullptr, poses[a]}, v).distance, pair.bound);
            } else if (pair.verdict == PairVerdict::Colliding) {
                hits += touch(poses, a, b) ? 1 : 0;
            }
        }
    }
    // The oracle sees collisions where there are some.
    EXPECT_GT(hits, 0u);
}

TEST(Sweep, NoPairThatCollidesIsCalledFree) { compare_with_the_exact_layer(4, 1500); }
TEST(SweepOfSevenJoints, NoPairThatCollidesIsCalledFreeIn100000Poses) { compare_with_the_exact_layer(7, 100000); }

TEST(Sweep, DoesNotDependOnThreads)
{
    const fs::path folder = own_folder();
    const Arm arm = made_arm(3, folder);
    const Sweep one = sweep(arm.text, folder / "arm.urdf", {.threads = 1}),
                two = sweep(arm.text, folder / "arm.urdf", {.threads = 3});
    ASSERT_EQ(one.pairs.size(), two.pairs.size());
    for (std::size_t i = 0; i < one.pairs.size(); ++i) {
        EXPECT_EQ(one.pairs[i].verdict, two.pairs[i].verdict);
        EXPECT_EQ(one.pairs[i].bound, two.pairs[i].bound);
        EXPECT_EQ(one.pairs[i].seen, two.pairs[i].seen);
        EXPECT_EQ(one.pairs[i].cells, two.pairs[i].cells);
    }
}

TEST(LoadMesh, AUnitScalesTheTrianglesAsTheSolid)
{
    const fs::path folder = own_folder();
    write_obj(folder / "ball.obj", mesh::sphere(50, 2));
    const CollisionMesh as{.filename = "ball.obj", .scale = {1, 2, 1}, .pose = {{}, {0.5, 0, 0}}};
    MeshOptions options;
    options.admit.unit = 1e-3;
    const LinkMesh loaded = load_mesh(folder / "ball.obj", as, options);
    const Box soup = box_of(loaded.soup.vertices), solid = box_of(loaded.admitted.mesh.vertices);
    for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(soup.lo[k], solid.lo[k], 1e-15);
        EXPECT_NEAR(soup.hi[k], solid.hi[k], 1e-15);
    }
    EXPECT_NEAR(soup.hi.x, 0.55, 1e-12);
    EXPECT_NEAR(soup.hi.y, 0.1, 1e-12);
}

}  // namespace
}  // namespace sqmap::robot
