#include "sqmap/sim/cloth.h"

#include "sqmap/bake/skin_lattice.h"
#include "support/bodies.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::sim {
namespace {

constexpr double k_dt = 1.0 / 240;

const test::Parsed& ball()
{
    static const test::Parsed k_ball(mesh::sphere(0.3, 4));
    return k_ball;
}
const test::Parsed& plate()
{
    static const test::Parsed k_plate = [] {
        mesh::Mesh m = test::cube();
        for (Vec3d& v : m.vertices) v.y *= 0.02;
        return test::Parsed(m);
    }();
    return k_plate;
}
Collider still(const test::Parsed& p, Vec3d at = {}) { return {&p.view(), {{}, at}, {{}, at}}; }

double largest_y(const Cloth& cloth)
{
    double y = -INFINITY;
    for (const Vec3d& p : cloth.positions()) y = std::max(y, p.y);
    return y;
}

TEST(Cloth, ADrapeOverABallComesToRestOutsideIt)
{
    Cloth cloth(sheet({{0, 0.33, 0}, 0.7, 0.7, 0, 0, 900}), fabric("wool"));
    const Collider solid = still(ball());
    StepReport r;
    Drape drape;
    for (int i = 0; i < 6 * 240 && !drape.report().at_rest; ++i) {
        r = cloth.step(k_dt, {&solid, 1});
        ASSERT_EQ(r.status, k_cloth_ok);
        ASSERT_NEAR(norm(cloth.velocities()[r.fastest_node]), r.fastest, 1e-6);
        drape.add(r, (i + 1) * k_dt);
    }
    EXPECT_TRUE(drape.report().at_rest);
    EXPECT_LT(r.fastest, 0.05);
    EXPECT_GT(r.contacts, 100u);
    const Penetration deep = penetration(cloth.positions(), cloth.triangles(), {&solid, 1}, {.steps = 4});
    EXPECT_LE(deep.nodes, 0.002 * 0.6);
    EXPECT_LE(deep.interiors, 0.005 * 0.6);
    EXPECT_GT(largest_y(cloth), 0.3);   // it lies on the ball
    EXPECT_LT(largest_y(cloth), 0.31);  // and touches it
}

TEST(Drape, RestsOnceItHasBeenSlowForAQuarterOfASecond)
{
    Drape drape(0.05);
    const auto step = [&](double time, double fastest) {
        StepReport r;
        r.fastest = fastest;
        r.fastest_node = 7;
        drape.add(r, time);
        return drape.report();
    };
    EXPECT_FALSE(step(0.1, 0.01).at_rest);
    EXPECT_FALSE(step(0.2, 0.06).at_rest);  // a pause is no rest
    EXPECT_FALSE(step(0.3, 0.05).at_rest);
    EXPECT_FALSE(step(0.5, 0.02).at_rest);
    const DrapeReport rests = step(0.55, 0.01);
    EXPECT_TRUE(rests.at_rest);
    EXPECT_DOUBLE_EQ(rests.since, 0.3);
    const DrapeReport disturbed = step(0.6, 1.5);
    EXPECT_FALSE(disturbed.at_rest);
    EXPECT_EQ(disturbed.fastest_node, 7u);
    EXPECT_DOUBLE_EQ(disturbed.fastest, 1.5);
    EXPECT_FALSE(step(0.7, NAN).at_rest);
}

TEST(Cloth, EnergyNeverGrowsAtAnyTimeStep)
{
    for (const double dt : {k_dt, 10 * k_dt}) {
        Cloth cloth(sheet({{0, 0.5, 0}, 0.8, 0.8, 0, 0, 400}), fabric("cotton"));
        const Collider solid = still(ball());
        double first = NAN, mass = 0.15 * 0.64;
        for (int i = 0; i < static_cast<int>(1.5 / dt); ++i) {
            const StepReport r = cloth.step(dt, {&solid, 1});
            if (std::isnan(first)) first = r.kinetic + r.potential;
            // A node that is pushed out of the ball is lifted by the cloth's thickness at most.
            ASSERT_LE(r.kinetic + r.potential, first + mass * 9.81 * 0.003) << dt << " at step " << i;
        }
    }
}

TEST(Cloth, ThreadsThatLongStepsStretchAreSaid)
{
    for (const double dt : {k_dt, 10 * k_dt, 60 * k_dt}) {
        Cloth cloth(sheet({{0, 0.33, 0}, 0.7, 0.7, 0, 0, 1600}), fabric("wool"));
        const Collider solid = still(ball());
        std::uint32_t status = 0;
        for (int i = 0; i < static_cast<int>(2 / dt); ++i) status |= cloth.step(dt, {&solid, 1}).status;
        std::vector<double> strain = cloth.strain();
        std::nth_element(strain.begin(), strain.begin() + static_cast<std::ptrdiff_t>(strain.size() / 2), strain.end());
        const double median = strain[strain.size() / 2];
        EXPECT_EQ((status & k_cloth_stretched) != 0, median > k_max_stretch) << dt << ": " << median;
        EXPECT_EQ(median > k_max_stretch, dt > 10 * k_dt) << median;
    }
}

TEST(Cloth, NothingTunnelsThroughAThinPlateAtFiveMetresASecond)
{
    // Gravity that brings it to 5 m/s just above the plate: 20 mm a step, half the plate's thickness.
    ClothOptions options;
    options.gravity = {0, -25, 0};
    Fabric thin = fabric("cotton");
    thin.damping = 0;
    Cloth cloth(sheet({{0, 0.54, 0}, 0.9, 0.9, 0, 0, 900}), thin, options);
    const Collider solid = still(plate());
    double fastest = 0;
    for (int i = 0; i < 120; ++i) {
        fastest = std::max(fastest, cloth.step(k_dt, {&solid, 1}).fastest);
        for (const Vec3d& p : cloth.positions()) ASSERT_GT(p.y, 0.02 - 0.002) << "step " << i;
    }
    EXPECT_GT(fastest, 4.9);
}

TEST(Cloth, FrictionHoldsWithinItsConeAndLetsGoBeyond)
{
    for (const auto& [mu, holds] : {std::pair{0.8, true}, {0.2, false}}) {
        ClothOptions options;
        options.gravity = {9.81 * std::sin(0.5), -9.81 * std::cos(0.5), 0};  // tan 0.5 = 0.55
        Fabric f = fabric("cotton");
        f.friction = mu;
        f.damping = 0;
        Cloth cloth(sheet({{0, 0.0225, 0}, 0.3, 0.3, 0, 0, 100}), f, options);
        const Collider solid = still(plate());
        for (int i = 0; i < 96; ++i) cloth.step(k_dt, {&solid, 1});
        Vec3d mean{};
        for (const Vec3d& p : cloth.positions()) mean += p / static_cast<double>(cloth.size());
        if (holds) {
            EXPECT_LT(std::abs(mean.x), 0.005);
        } else {
            const double t = 0.4, expected = 0.5 * t * t * 9.81 * (std::sin(0.5) - 0.2 * std::cos(0.5));
            EXPECT_NEAR(mean.x, expected, 0.1 * expected);
        }
    }
}

TEST(Cloth, PaperFrictionSlowsByItsForceWhateverTheNormalForce)
{
    ClothOptions options;
    options.gravity = {2, -9.81, 0};
    options.friction = Friction::Paper;
    Fabric f = fabric("cotton");
    f.damping = 0;
    const Garment garment = sheet({{0, 0.0225, 0}, 0.3, 0.3, 0, 0, 100});
    const double node_mass = f.density * 0.09 / static_cast<double>(garment.start.size());
    options.paper_friction = 0.5 * 2 * node_mass;  // half of what pulls
    options.paper_stiffness = 0;
    Cloth cloth(garment, f, options);
    const Collider solid = still(plate());
    for (int i = 0; i < 96; ++i) cloth.step(k_dt, {&solid, 1});
    Vec3d mean{};
    for (const Vec3d& p : cloth.positions()) mean += p / static_cast<double>(cloth.size());
    EXPECT_NEAR(mean.x, 0.5 * 1.0 * 0.16, 0.02);
}

TEST(Cloth, ClothRidesASolidThatMoves)
{
    Fabric f = fabric("wool");
    f.damping = 0;
    Cloth cloth(sheet({{0, 0.0245, 0}, 0.3, 0.3, 0, 0, 100}), f);
    Collider solid = still(plate());
    for (int i = 1; i <= 240; ++i) {
        const double t = i * k_dt;
        solid.previous = solid.pose;
        solid.pose.translation = {0.25 * t * t, 0.1 * std::sin(3 * t), 0};  // 0.5 m/s^2 < 0.6 g
        cloth.step(k_dt, {&solid, 1});
    }
    Vec3d mean{};
    for (const Vec3d& p : cloth.positions()) mean += p / static_cast<double>(cloth.size());
    EXPECT_NEAR(mean.x, 0.25, 0.02);
    EXPECT_NEAR(mean.y, 0.024 + 0.1 * std::sin(3.0), 0.003);
}

TEST(Cloth, ASolidThatCatchesUpWithClothFromBehindDoesNotEnterIt)
{
    // The cloth rises at 0.5 m/s at most, the plate at 0.7: less than a thickness a step faster.
    ClothOptions options;
    options.gravity = {0, 2, 0};
    Cloth cloth(sheet({{0, 0.1, 0}, 0.5, 0.5, 0, 0, 400}), fabric("cotton"), options);
    Collider solid = still(plate());
    std::size_t largest = 0;
    for (int i = 0; i < 120; ++i) {
        solid.previous = solid.pose;
        solid.pose.translation.y += 0.7 * k_dt;
        largest = std::max(largest, cloth.step(k_dt, {&solid, 1}).contacts);
        ASSERT_LT(penetration(cloth.positions(), {}, {&solid, 1}, {.steps = 1}).nodes, 1e-4) << "step " << i;
    }
    EXPECT_EQ(largest, cloth.size());
}

TEST(Cloth, OverlappingSolidsAreOne)
{
    // Two plates, the right one overlapping the left: cloth lies flat across the hidden ends of both.
    Cloth cloth(sheet({{0.9, 0.05, 0}, 0.6, 0.6, 0, 0, 900}), fabric("wool"));
    const std::array solids{still(plate(), {0, 0, 0}), still(plate(), {1.8, 0, 0})};
    for (int i = 0; i < 300; ++i) ASSERT_EQ(cloth.step(k_dt, solids).status, k_cloth_ok);
    for (const Vec3d& p : cloth.positions()) EXPECT_NEAR(p.y, 0.024, 0.004);
}

TEST(Cloth, WhatIsNotFiniteIsStoppedAndSaid)
{
    ClothOptions options;
    options.gravity.y = std::numeric_limits<double>::quiet_NaN();
    Cloth cloth(sheet({{0, 1, 0}, 0.3, 0.3, 0, 0, 50}), fabric("silk"), options);
    const std::vector<Vec3d> before(cloth.positions().begin(), cloth.positions().end());
    EXPECT_NE(cloth.step(k_dt, {}).status & k_cloth_not_finite, 0u);
    EXPECT_TRUE(std::equal(before.begin(), before.end(), cloth.positions().begin()));
    EXPECT_EQ(cloth.step(0, {}).status, k_cloth_bad_step);
    Collider solid = still(ball());
    solid.pose.translation.x = INFINITY;
    EXPECT_EQ(cloth.step(k_dt, {&solid, 1}).status, k_cloth_bad_step);
}

TEST(Cloth, GarmentsThatContradictThemselvesAreRefused)
{
    Garment g = sheet({{0, 1, 0}, 0.3, 0.3, 0, 0, 50});
    g.triangles[0][0] = 1000;
    EXPECT_THROW(Cloth(g, fabric("silk")), std::invalid_argument);
    g = sheet({{0, 1, 0}, 0.3, 0.3, 0, 0, 50});
    g.start[3].x = NAN;
    EXPECT_THROW(Cloth(g, fabric("silk")), std::invalid_argument);
}

TEST(Cloth, SeamsCloseAreCutAndSewnAgain)
{
    Cloth cloth(shirt({.collar = {0, 0, 0}, .gap = 0.05, .vertices = 600}), fabric("cotton"), {.gravity = {0, -1, 0}});
    EXPECT_NEAR(cloth.gap(1), 0.1, 1e-6);
    for (int i = 0; i < 132; ++i) cloth.step(k_dt, {});
    EXPECT_LT(cloth.gap(0), 0.003);
    EXPECT_NEAR(cloth.gap(1), 0.1, 0.01);  // waits its turn
    for (int i = 0; i < 132; ++i) cloth.step(k_dt, {});
    EXPECT_LT(cloth.gap(0), 0.003);
    EXPECT_LT(cloth.gap(1), 0.003);
    cloth.cut(1);
    // Hold the front by its hem, let the back swing.
    const std::vector<std::uint32_t> top{0, 1, 2, 3};
    cloth.pin(top, Cloth::k_world, {});
    for (int i = 0; i < 60; ++i) cloth.step(k_dt, {});
    const double open = cloth.gap(1);
    EXPECT_GT(open, 0.005);
    cloth.sew(1);
    for (int i = 0; i < 180; ++i) cloth.step(k_dt, {});
    EXPECT_LT(cloth.gap(1), 0.003);
}

Garment sleeved(std::uint32_t vertices)
{
    return shirt({.collar = {0, 0.1, 0},
                  .chest = 0.52,
                  .length = 0.62,
                  .span = 1.0,
                  .sleeve = 0.24,
                  .neck = 0.24,
                  .gap = 0.14,
                  .vertices = vertices});
}

TEST(Cloth, SleevesCloseRoundTheArmsInThem)
{
    // Both seams at once closed them so that their edges stayed on either side of the arms.
    mesh::CapsuleSolid solid;
    solid.capsules = {{{-0.7, 0, 0}, {0.7, 0, 0}, 0.043, 0.043}};
    const test::Parsed arms(mesh::polygonized(solid, 0.02));
    const Collider body = still(arms);
    Cloth cloth(sleeved(4000), fabric("cotton"));
    for (int i = 0; i < 300; ++i) cloth.step(k_dt, {&body, 1});
    EXPECT_LT(cloth.gap(0), 0.003);
    EXPECT_LT(cloth.gap(1), 0.003);
    EXPECT_LE(penetration(cloth.positions(), cloth.triangles(), {&body, 1}, {.steps = 4}).interiors, 0.001);
}

TEST(Cloth, AClosedSeamIsShownClosedThoughAPullOpensIt)
{
    Cloth cloth(sleeved(1000), fabric("cotton"), {.iterations = 16});
    for (int i = 0; i < 300; ++i) cloth.step(k_dt, {});
    cloth.grasp(40, 0.02, cloth.positions()[40]);
    const Vec3d from = cloth.positions()[40];
    double open = 0;
    for (int i = 0; i < 60; ++i) {
        cloth.drag(from + Vec3d{0, 0.3, 0.004 * i});
        cloth.step(k_dt, {});
        open = std::max({open, cloth.gap(0), cloth.gap(1)});
    }
    EXPECT_GT(open, 1e-4);
    cloth.settle({});
    for (const std::size_t seam : {0u, 1u}) EXPECT_EQ(cloth.gap(seam), 0) << seam;
    cloth.cut(0);
    cloth.step(k_dt, {});
    cloth.settle({});
    EXPECT_GT(cloth.gap(0), 0);
}

TEST(Cloth, AToolBearsTheWeightOfWhatItHolds)
{
    const Fabric f = fabric("denim");
    Cloth cloth(sheet({{0, 1, 0}, 0.2, 0.2, 0, 0, 100}), f);
    cloth.grasp(0, 0.001, cloth.positions()[0]);
    Vec3d mean{};
    for (int i = 0; i < 1200; ++i) {
        cloth.step(k_dt, {});
        if (i >= 960) mean += cloth.tension() / 240.0;
    }
    const double weight = f.density * 0.04 * 9.81;
    EXPECT_NEAR(mean.y, -weight, 0.1 * weight);
    EXPECT_LT(std::hypot(mean.x, mean.z), 0.15 * weight);
    cloth.release();
    EXPECT_EQ(norm(cloth.tension()), 0);
}

TEST(Cloth, APullOfThirtyNewtonsDoesNotOpenSilk)
{
    // The far edge is fixed, and a hand pulls at the middle of the near one.
    const auto wide = sheet({{0, 1, 0}, 0.5, 0.5, 0, 0, 600});
    Cloth cloth(wide, fabric("silk"), {.iterations = 16});
    std::vector<std::uint32_t> edge;
    std::uint32_t grip = 0;
    for (std::uint32_t i = 0; i < wide.start.size(); ++i) {
        const Vec3d p = wide.start[i];
        if (p.x < -0.249) edge.push_back(i);
        if (norm(p - Vec3d{0.25, 1, 0}) < norm(wide.start[grip] - Vec3d{0.25, 1, 0})) grip = i;
    }
    cloth.pin(edge, Cloth::k_world, {});
    cloth.grasp(grip, 0.02, wide.start[grip]);
    double longest = 0, strongest = 0;
    for (int i = 0; i < 240; ++i) {
        if (norm(cloth.tension()) < 30) cloth.drag(wide.start[grip] + Vec3d{0.004 * i, 0, 0});
        EXPECT_EQ(cloth.step(1.0 / 120, {}).status & k_cloth_not_finite, 0u);
        strongest = std::max(strongest, norm(cloth.tension()));
        for (const double s : cloth.strain()) longest = std::max(longest, s);
    }
    EXPECT_GT(strongest, 30);
    EXPECT_LT(longest, 0.5);  // a share of the threads' length
}

TEST(Cloth, APullWhileSeamsAreDrawnTogetherThrowsNothing)
{
    Cloth cloth(sleeved(1000), fabric("cotton"));
    std::uint32_t status = 0;
    for (int i = 0; i < 120; ++i) {
        if (i == 20) cloth.grasp(40, 0.02, cloth.positions()[40]);
        status |= cloth.step(1.0 / 120, {}).status;
    }
    EXPECT_EQ(status & k_cloth_slowed, 0u);
}

TEST(Cloth, StrainIsWhatTheStartIsStretchedBy)
{
    Garment g = sheet({{0, 1, 0}, 0.3, 0.3, 0, 0, 64});
    std::vector<std::uint32_t> all;
    for (std::uint32_t i = 0; i < g.start.size(); ++i) {
        g.start[i] = 1.1 * g.start[i];
        all.push_back(i);
    }
    Cloth cloth(g, fabric("cotton"));
    cloth.pin(all, Cloth::k_world, {});
    for (const double s : cloth.strain()) EXPECT_NEAR(s, 0.1, 1e-5);
}

TEST(Cloth, PenetrationIsTheDepthOfPointsWithinTriangles)
{
    // A triangle whose corners are outside the ball and whose middle is 0.1 below its top.
    const std::array corners{Vec3d{-1, 0.2, -1}, Vec3d{1, 0.2, -1}, Vec3d{0, 0.2, 2}};
    const std::array<std::array<std::uint32_t, 3>, 1> triangle{{{0, 1, 2}}};
    const Collider solid = still(ball());
    const Penetration deep = penetration(corners, triangle, {&solid, 1}, {.steps = 3});
    EXPECT_EQ(deep.nodes, 0);
    EXPECT_NEAR(deep.interiors, 0.1, 0.002);
}

/// A bar along x whose right half turns about z, blended about its middle.
struct Bar {
    mesh::Mesh mesh = mesh::ellipsoid({0.5, 0.08, 0.3}, 4);
    mesh::Influences influences;
    test::Parsed model{mesh};
    query::SkinLattice lattice;

    Bar()
    {
        for (const Vec3d& v : mesh.vertices) {
            const double right = std::clamp(0.5 + v.x / 0.3, 0.0, 1.0);
            influences.joints.push_back({0, 1, 0, 0});
            influences.weights.push_back({1 - right, right, 0, 0});
        }
        lattice = bake::skin_lattice(mesh, influences);
    }
    static std::vector<Affine> bent(double angle) { return {{}, {test::rotation_about({0, 0, 1}, angle), {}}}; }
};

TEST(Cloth, LiesOnASkinThatBendsUnderItAndRidesIt)
{
    const Bar bar;
    query::MovingSkin skin(bar.lattice);
    const Collider solid{&bar.model.view(), {}, {}, &skin};
    Cloth cloth(sheet({{0.1, 0.1, 0}, 0.5, 0.3, 0, 0, 400}), fabric("wool"));
    // No room was made for a skin.
    EXPECT_EQ(cloth.step(k_dt, {&solid, 1}).status, k_cloth_bad_step);
    cloth.expect(bar.lattice);
    double angle = 0;
    StepReport r;
    for (int i = 0; i < 480; ++i) {
        if (i > 120 && i < 360) angle += 0.6 / 240;  // the half goes up by 0.6 in a second, and the cloth with it
        ASSERT_TRUE(skin.step(Bar::bent(angle)));
        r = cloth.step(k_dt, {&solid, 1});
        ASSERT_EQ(r.status & ~std::uint32_t{k_cloth_slowed}, 0u);
    }
    EXPECT_GT(r.contacts, 100u);
    EXPECT_GT(largest_y(cloth), 0.1);  // lifted
    const Penetration deep = penetration(cloth.positions(), cloth.triangles(), {&solid, 1}, {.steps = 3});
    EXPECT_LT(deep.nodes, 0.002);
    // Against the skinned mesh itself, which nothing of the lattice knows.
    mesh::Mesh posed = bar.mesh;
    posed.vertices = mesh::skinned(bar.mesh.vertices, bar.influences, Bar::bent(angle));
    const mesh::Solid exact(posed, mesh::find_self_intersections(posed).crossed);
    double deepest = 0;
    for (const Vec3d& p : cloth.positions())
        if (exact.inside(p)) deepest = std::max(deepest, exact.bvh().closest_point(p, INFINITY).distance);
    EXPECT_LT(deepest, 0.002);
    EXPECT_NEAR(deepest, deep.nodes, 0.001);
}

TEST(Cloth, AStripHangsAsABeamDoesWhateverItsPitch)
{
    // Clamped level along one end; bends by q L^4 / (8 B) at the other (Euler and Bernoulli), a tenth of its length. The first
    // threads that bend stand for half a pitch on either side: the clamp is half a pitch before the last clamped node.
    Fabric f = fabric("cotton");
    f.density = 0.3;
    f.damping = 20;
    std::vector<double> hangs;
    for (const std::uint32_t columns : {4u, 8u}) {
        const double pitch = 0.06 / columns, length = 0.06 + 0.5 * pitch, all = 0.06 + 2 * pitch;
        f.bend = f.density * 9.81 * length * length * length / (8 * 0.1);
        Cloth cloth(sheet({{0.5 * all, 0, 0}, all, 4 * pitch, 0, 0, 4 * (columns + 2)}), f, {.iterations = 24});
        std::vector<std::uint32_t> clamped;
        double lowest = 0;
        for (std::uint32_t i = 0; i < cloth.size(); ++i)
            if (cloth.positions()[i].x < 2.5 * pitch) clamped.push_back(i);
        cloth.pin(clamped, Cloth::k_world, {});
        for (int i = 0; i < 480; ++i) (void)cloth.step(k_dt, {});
        for (const Vec3d& p : cloth.positions()) lowest = std::min(lowest, p.y);
        hangs.push_back(-lowest / length);
        EXPECT_NEAR(hangs.back(), 0.1, 0.033) << columns;
    }
    EXPECT_NEAR(hangs[1], hangs[0], 0.1 * hangs[0]);
}

TEST(Cloth, SettledNothingOfItIsInASkin)
{
    // Pulled down hard over a bar that bends, so that its threads cut in.
    const Bar bar;
    query::MovingSkin skin(bar.lattice);
    const Collider solid{&bar.model.view(), {}, {}, &skin};
    Cloth cloth(sheet({{0.1, 0.1, 0}, 0.5, 0.9, 0, 0, 400}), fabric("silk"));
    EXPECT_EQ(cloth.settle({&solid, 1}), 0u);  // no room was made for a skin
    cloth.expect(bar.lattice);
    ASSERT_TRUE(skin.step(Bar::bent(0)));
    double angle = 0, before = 0;
    for (int i = 0; i < 360; ++i) {
        if (i == 60) cloth.grasp(0, 0.05, cloth.positions()[0]);
        if (i > 60) cloth.drag(Vec3d{-0.3, -0.1 - 0.002 * (i - 60), -0.4});
        angle += 0.6 / 240;
        ASSERT_TRUE(skin.step(Bar::bent(angle)));
        (void)cloth.step(k_dt, {&solid, 1});
        if (i % 30 != 29) continue;
        const Penetration was = penetration(cloth.positions(), cloth.triangles(), {&solid, 1}, {.steps = 3});
        before = std::max({before, was.nodes, was.interiors});
        const std::vector<Vec3d> speeds(cloth.velocities().begin(), cloth.velocities().end());
        (void)cloth.settle({&solid, 1});
        EXPECT_TRUE(std::equal(speeds.begin(), speeds.end(), cloth.velocities().begin()));
        const Penetration is = penetration(cloth.positions(), cloth.triangles(), {&solid, 1}, {.steps = 3});
        EXPECT_LE(is.nodes, 1e-5) << "step " << i;
        EXPECT_LE(is.interiors, 1e-3) << "step " << i;
    }
    EXPECT_GT(before, 1.5e-3);  // there was something to settle
}

TEST(Cloth, CrumpledOnASharpRidgeItIsStillInTheEnd)
{
    // A roof of 50 degrees, its ridge a fold: a node beside it is thrown from one slope to the other.
    mesh::Mesh roof = test::cube();
    for (Vec3d& v : roof.vertices) v = {0.3 * v.x, v.y > 0 ? 0.28 : 0.0, v.y > 0 ? 0.004 * v.z : 0.13 * v.z};
    const test::Parsed model(roof);
    const Collider solid = still(model);
    Cloth cloth(sheet({{0, 0.3, 0}, 0.4, 0.4, 0, 0, 1600}), fabric("wool"));
    Drape drape;
    for (int i = 0; i < 5 * 240; ++i) drape.add(cloth.step(k_dt, {&solid, 1}), (i + 1) * k_dt);
    EXPECT_TRUE(drape.report().at_rest) << drape.report().fastest;
    EXPECT_LE(penetration(cloth.positions(), cloth.triangles(), {&solid, 1}, {.steps = 1}).nodes, 0.002 * 0.28);
}

TEST(Cloth, ASharpTipStaysInATriangleByMillimetresAtMost)
{
    // A horn as wide as the cloth's triangles. The first bounds were 1 mm, of a spike thinner than the triangles. A step queries
    // a fixed number of points within triangles, so a tip may stay that no node touches: 0.8 to 5.6 mm here, 11.3 mm in all. A
    // spike thinner than the triangles is held 0 to 3.6 mm deep, or goes through the cloth altogether, as in 2 of 5 such drapes:
    // finer cloth is the remedy (docs/algorithms/cloth.md).
    mesh::Mesh horn = test::cube();
    for (Vec3d& v : horn.vertices) v = {(v.y > 0 ? 0.004 : 0.03) * v.x, v.y > 0 ? 0.15 : 0.0, (v.y > 0 ? 0.004 : 0.03) * v.z};
    const test::Parsed model(horn);
    const Collider solid = still(model);
    double sum = 0;
    for (const double shift : {0.0, 0.003, 0.006, 0.009, 0.012}) {
        Cloth cloth(sheet({{shift, 0.2, 0.5 * shift}, 0.3, 0.3, 0, 0, 900}), fabric("wool"));
        for (int i = 0; i < 2 * 240; ++i) (void)cloth.step(k_dt, {&solid, 1});
        const double deepest = penetration(cloth.positions(), cloth.triangles(), {&solid, 1}, {.steps = 8}).interiors;
        EXPECT_LE(deepest, 0.006) << shift;
        EXPECT_GT(largest_y(cloth), 0.13) << shift << ": it hangs on the horn";
        sum += deepest;
    }
    EXPECT_LE(sum, 0.013);  // 27 mm where only nodes are queried
}

TEST(Cloth, BetweenTwoCollidersItYieldsToBoth)
{
    // Two plates close on a sheet until there is half as much room as its thickness takes on one side.
    Cloth cloth(sheet({{0, 0.03, 0}, 0.4, 0.4, 0, 0, 400}), fabric("cotton"));
    std::vector<Collider> solids{still(plate()), still(plate(), {0, 0.1, 0})};
    for (int i = 0; i < 240; ++i) {
        solids[1].previous = solids[1].pose;
        solids[1].pose.translation.y = std::max(0.041, 0.1 - 0.1 * i * k_dt);
        (void)cloth.step(k_dt, solids);
    }
    for (int i = 0; i < 60; ++i) {
        solids[1].previous = solids[1].pose;
        (void)cloth.step(k_dt, solids);
    }
    EXPECT_LE(penetration(cloth.positions(), cloth.triangles(), solids, {.steps = 1}).nodes, 2e-4);
    for (const Vec3d& p : cloth.positions()) {
        EXPECT_NEAR(p.y, 0.0205, 4e-4);  // half way
    }
}

}  // namespace
}  // namespace sqmap::sim
