#include "sqmap/haptic/step.h"

#include "haptic/rigid.h"
#include "sqmap/haptic/coupling.h"
#include "sqmap/mesh/solid.h"
#include "touching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <thread>

namespace sqmap::haptic::test {
namespace {

constexpr double k = 500;
const ZoneOptions exact{.layer = query::Layer::Exact, .stiffness = k};

ZoneOptions with(Averaging averaging, ZoneOptions options = exact)
{
    options.averaging = averaging;
    return options;
}

double angle_between(Vec3d a, Vec3d b) { return std::acos(std::clamp(dot(normalized(a), normalized(b)), -1., 1.)); }

TEST(Step, APointOnFlatGroundFeelsItsSpringAtAnyDepth)
{
    Tool tool = Tool::point(exact);
    for (const Shading shading : {Shading::Levelled, Shading::Consistent})
        for (const double depth : {0.0001, 0.0005, 0.001, 0.003, 0.008}) {
            tool.state().reset();
            tool.state().options(0).shading = shading;
            const Wrench w = tool.touch(frictionless(box()), Vec3d{0.003, 0.002, 0.03 - depth});
            // 48 samples stand for a sphere: a few micrometres.
            EXPECT_NEAR(w.force.z, k * depth, k * 1.5e-5 + 0.01 * k * depth) << depth;
            EXPECT_LT(std::hypot(w.force.x, w.force.y), 0.04 * k * depth) << depth;
            EXPECT_EQ(w.torque, Vec3d{});
        }
}

TEST(Step, ABallOnFlatGroundFeelsItsSpringAtAnyDepth)
{
    ZoneOptions o = with(Averaging::Ball);
    o.smoothing = {.radius = 0.004, .points = 500, .tolerance = 0.0005};
    Tool ball(stencil_points(o.smoothing), o);
    for (const double depth : {0.0003, 0.001, 0.003, 0.006, 0.009, 0.013}) {  // from 8 mm on, all of it is inside
        ball.state().reset();
        const Wrench w = ball.touch(frictionless(box()), Vec3d{0.003, 0.002, 0.034 - depth});
        EXPECT_NEAR(w.force.z, k * depth, k * 2e-5 + 0.01 * k * depth) << depth;
        EXPECT_LT(std::hypot(w.force.x, w.force.y), 0.04 * k * depth) << depth;
    }
}

TEST(Step, FrictionTurnsABallAboutItsCentre)
{
    ZoneOptions o = with(Averaging::Ball);
    o.layer = query::Layer::Exact;
    o.smoothing = {.radius = 0.005, .points = 500, .tolerance = 0};
    Tool ball(stencil_points(o.smoothing), o);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Coulomb;
    const double depth = 0.001;
    Wrench w;
    for (int i = 0; i < 100; ++i) w = ball.touch(solid, Vec3d{5e-5 * i, 0, 0.035 - depth});
    EXPECT_NEAR(-w.force.x, solid.material.mu_dynamic * w.force.z, 0.01 * w.force.z) << "it slips";
    // r x F, with r from the centre to the place on the ground.
    EXPECT_NEAR(w.torque.y, -(0.005 - depth) * w.force.x, 2e-2 * 0.005 * std::abs(w.force.x));
    EXPECT_LT(std::hypot(w.torque.x, w.torque.z), 2e-2 * std::abs(w.torque.y));
}

TEST(Step, ABallOnARidgeIsAsDeepAsItsNearestPointSays)
{
    ZoneOptions o = with(Averaging::Ball);
    o.blend_time = 0;
    o.layer = query::Layer::Exact;
    o.smoothing = {.radius = 0.005, .points = 500, .tolerance = 0};
    Tool ball(stencil_points(o.smoothing), o);
    const double cosine = std::cos(k_roof), sine = std::sin(k_roof);
    for (int i = -40; i <= 40; ++i) {
        // Its centre is over one slope, over the other, or nearest to the edge between them.
        const double x = 1e-4 * i, z = 0.0042, along = cosine * std::abs(x) - sine * z;
        const double distance = along > 0 ? cosine * z + sine * std::abs(x) : std::hypot(x, z);
        const Vec3d f = ball.touch(frictionless(roof(1)), Vec3d{x, 0.001, z}).force;
        EXPECT_NEAR(ball.report().deepest, std::max(0.005 - distance, 0.), 1e-7) << i;
        if (0.005 - distance > 1e-4) {
            EXPECT_NEAR(norm(f), k * (0.005 - distance), 1e-6 * k) << i;
        }
    }
}

TEST(Step, APointFeelsTheTrueDepthOnFacetsThatTurnMildly)
{
    // A ball of 5 cm as facets that turn by up to 10 degrees.
    static const sqmap::test::Solid facets(mesh::sphere(0.05, 3));
    static const mesh::Mesh ball = mesh::sphere(0.05, 3);
    static const mesh::Solid truth(ball);
    Tool tool = Tool::point(exact);
    const auto smooth_alone = [&](Vec3d at) {  // what the samples' mean square stands for
        double second = 0;
        const std::vector<Vec3d> points = stencil_points(exact.smoothing);
        for (std::size_t i = 0; i + 1 < points.size(); ++i)
            if (const Vec3d p = at + points[i]; truth.inside(p)) {
                const double d = truth.closest_boundary(p).distance;
                second += d * d / static_cast<double>(points.size() - 1);
            }
        return depth_of_stencil(exact.smoothing.radius, second).depth;
    };
    double worst = 0, of_smoothing = 0;
    for (int i = 0; i < 200; ++i) {
        const double a = 0.005 * i;
        const Vec3d at = 0.0488 * Vec3d{std::cos(a), std::sin(a) * 0.8, std::sin(a) * 0.6};
        const double depth = truth.closest_boundary(at).distance;
        tool.state().reset();
        const Wrench w = tool.touch(frictionless(facets), at);
        worst = std::max(worst, std::abs(norm(w.force) / k - depth));
        of_smoothing = std::max(of_smoothing, std::abs(smooth_alone(at) - depth));
    }
    EXPECT_GT(of_smoothing, 8e-5);
    EXPECT_LT(worst, 0.25 * of_smoothing);
}

TEST(Step, ABallThatCrossesAValleyIsAsDeepAsInItsWallsAndTurnsFromOneToTheOther)
{
    ZoneOptions o = with(Averaging::Ball);
    o.blend_time = 0;
    o.smoothing = {.radius = 0.005, .points = 500, .tolerance = 0.0003};
    Tool ball(stencil_points(o.smoothing), o);
    const double cosine = std::cos(k_roof), sine = std::sin(k_roof);
    Vec3d before{};
    for (int i = -40; i <= 40; ++i) {
        const Vec3d at{1e-4 * i, 0.001, 0.0038 / cosine};
        const double right = 0.005 - (cosine * at.z - sine * at.x), left = 0.005 - (cosine * at.z + sine * at.x);
        const Vec3d f = ball.touch(frictionless(roof(-1)), at).force;
        EXPECT_LT(norm(f), 1.03 * k * std::max(left, right)) << i;
        EXPECT_GT(norm(f), 0.85 * k * std::max(left, right)) << i;
        if (i > -40) {
            EXPECT_LT(angle_between(f, before), 0.05) << i;
        }
        before = f;
    }
}

TEST(Step, APointDeepUnderARidgeTurnsOverTheWidthOfItsSphere)
{
    ZoneOptions o = exact;
    o.blend_time = 0;
    Tool tool = Tool::point(o);
    Vec3d before{};
    double turned = 0;
    for (int i = -60; i <= 60; ++i) {
        const Vec3d f = tool.touch(frictionless(roof(1)), Vec3d{1e-4 * i, 0.001, -0.011}).force;
        if (i > -60) {
            EXPECT_LT(angle_between(f, before), 0.04) << i;
            turned += angle_between(f, before);
        }
        before = f;
    }
    EXPECT_NEAR(turned, 2 * k_roof, 0.05);
}

TEST(Step, NothingIsFeltOutside)
{
    for (const Averaging averaging : {Averaging::Stencil, Averaging::Patch}) {
        Tool tool(stencil_points({}), with(averaging));
        const double out = averaging == Averaging::Stencil ? 1e-6 : 0.002601;
        EXPECT_EQ(tool.touch(frictionless(box()), Vec3d{0, 0, 0.03 + out}), Wrench{});
        EXPECT_EQ(tool.result.status, k_step_ok);
    }
}

TEST(Step, ABallOnABallIsPushedAlongTheLineOfCentres)
{
    const sqmap::test::Solid ball(mesh::sphere(0.05, 5));
    const Smoothing smoothing{.radius = 0.01, .points = 500};
    ZoneOptions o = with(Averaging::Ball);
    o.smoothing = smoothing;
    Tool tool(stencil_points(smoothing), o);
    sqmap::test::Random random(3);
    for (int i = 0; i < 20; ++i)
        for (const double depth : {0.0005, 0.002, 0.005}) {
            const Vec3d d = random.direction();
            tool.state().reset();
            const Vec3d f = tool.touch(frictionless(ball), (0.06 - depth) * d).force;
            // The nearest place of the surface is known from samples 1.6 mm apart.
            EXPECT_NEAR(norm(f), k * depth, k * (smoothing.tolerance + 5e-5 + 0.02 * depth)) << depth;
            EXPECT_LT(angle_between(f, d), 0.04);
        }
}

/// The top of a box, as a tool: a flat square of 2 cm, n by n points, z = 0.
std::vector<Vec3d> square(int n)
{
    std::vector<Vec3d> points;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) points.push_back({0.02 * (i / (n - 1.) - 0.5), 0.02 * (j / (n - 1.) - 0.5), 0});
    return points;
}

TEST(Step, APatchOnFlatGroundFeelsItsSpringHoweverManyPoints)
{
    for (const Shading shading : {Shading::Levelled, Shading::Consistent})
        for (const int n : {2, 5, 30}) {
            ZoneOptions o = with(Averaging::Patch);
            o.shading = shading;
            Tool tool(square(n), o);
            const Wrench w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.029});
            EXPECT_NEAR(w.force.z, k * 0.001, 1e-3);
            EXPECT_LT(norm(w.torque), 1e-5);
        }
}

TEST(Step, DenserProbesFeelTheSame)
{
    // A ball's cap, pressed into flat ground: 4 times the points each time.
    double coarse = 0;
    for (const int subdivisions : {3, 4, 5}) {
        Tool tool(mesh::sphere(0.02, subdivisions).vertices, with(Averaging::Patch));
        const double f = tool.touch(frictionless(box()), Vec3d{0.001, 0.002, 0.045}).force.z;
        // Heights of a cap are spread evenly, and the shallowest half millimetre counts less.
        const double d = 0.005, e = 0.0005, mean = (e * e / 3 + (d * d - e * e) / 2) / (d - e / 2);
        EXPECT_NEAR(f, k * mean, 0.05 * k * mean) << subdivisions;
        if (coarse > 0) {
            EXPECT_NEAR(f, coarse, 0.05 * coarse);
        }
        coarse = f;
    }
}

TEST(Step, WeightsMakeUnevenProbesFeelTheSame)
{
    // One half of the ball has nine points where the other has one.
    std::vector<Vec3d> points;
    std::vector<float> areas;
    for (const Vec3d& p : mesh::sphere(0.02, 4).vertices)
        for (int i = 0; i < (p.x > 0 ? 9 : 1); ++i) {
            points.push_back(p);
            areas.push_back(p.x > 0 ? 1.f / 9 : 1.f);
        }
    Tool even(points, with(Averaging::Patch), areas), uneven(points, with(Averaging::Patch));
    const Vec3d at{0.001, 0.002, 0.045};
    EXPECT_LT(std::abs(even.touch(frictionless(box()), at).torque.y), 2e-4);
    EXPECT_GT(std::abs(uneven.touch(frictionless(box()), at).torque.y), 2e-3);
}

TEST(Step, TorqueIsLeverTimesForce)
{
    const Vec3d lever{0.02, -0.01, 0.004};
    std::vector<Vec3d> points = square(5);
    for (Vec3d& p : points) p += lever;
    Tool tool(points, with(Averaging::Patch));
    for (const double turn : {0.0, 0.7, 2.0}) {
        // Turned about the vertical, so that the square stays level.
        const Mat3d rotation = rotation_about({0, 0, 1}, turn);
        const Vec3d arm = rotation * lever;
        tool.state().reset();
        const Wrench w = tool.touch(frictionless(box()), Pose{rotation, Vec3d{0, 0, 0.029} - arm});
        const Vec3d torque = cross(arm, w.force);
        EXPECT_GT(norm(torque), 5e-3);
        EXPECT_LT(norm(w.torque - torque), 2e-2 * norm(torque));
    }
    tool.state().options(0).torque_share = 0;
    EXPECT_EQ(tool.touch(frictionless(box()), Vec3d{0, 0, 0.029} - lever).torque, Vec3d{});
}

TEST(Step, WhatATipFeelsTurnsTheTool)
{
    const Smoothing smoothing;
    std::vector<Vec3d> points = stencil_points(smoothing);
    const Vec3d tip{0, 0.05, 0};
    for (Vec3d& p : points) p += tip;
    const query::Probe probe(points);
    const Zone zone{.probe = &probe, .tip = tip, .options = with(Averaging::Stencil)};
    State state(std::span(&zone, 1));
    const TouchedBody solid = frictionless(box());
    const Pose pose = shifted(Vec3d{0, -0.05, 0.029});
    Wrench w;
    (void)step(state, {.touched = std::span(&solid, 1), .poses = std::span(&pose, 1)}, std::span(&w, 1));
    EXPECT_NEAR(w.force.z, k * 0.001, 0.02);
    EXPECT_NEAR(w.torque.x, 0.05 * w.force.z, 1e-9);
}

TEST(Step, ZonesTakeTheirOwnPointsOfOneProbe)
{
    std::vector<Vec3d> points = square(5);
    for (const Vec3d& p : square(5)) points.push_back(p + Vec3d{0, 0, -0.001});
    const query::Probe probe(points);
    const Zone zones[2] = {{.probe = &probe, .first = 0, .count = 25, .options = exact},
                           {.probe = &probe, .first = 25, .count = 25, .options = exact}};
    State state(zones);
    const TouchedBody solid = frictionless(box());
    const Pose poses[2] = {shifted({0, 0, 0.029}), shifted({0, 0, 0.029})};
    Wrench w[2];
    const StepResult r = step(state, {.touched = std::span(&solid, 1), .poses = poses}, w);
    EXPECT_NEAR(w[0].force.z, k * 0.001, 1e-3);
    EXPECT_NEAR(w[1].force.z, k * 0.002, 1e-3);
    EXPECT_EQ(r.contacts, 50u);
}

TEST(Step, AProbeInTheWorldIsFeltWhereItsPointsAre)
{
    const Vec3d at{0.01, 0, 0.029};
    std::vector<Vec3d> points = square(5);
    for (Vec3d& p : points) p += at;
    const query::Probe moved(points), fixed(square(5));
    const Zone zones[2] = {{.probe = &moved, .in_world = true, .options = exact}, {.probe = &fixed, .options = exact}};
    State state(zones);
    const TouchedBody solid = frictionless(box());
    const Pose poses[2] = {shifted(at), shifted(at)};
    Wrench w[2];
    (void)step(state, {.touched = std::span(&solid, 1), .poses = poses}, w);
    EXPECT_LT(norm(w[0].force - w[1].force), 1e-6);
    EXPECT_LT(norm(w[0].torque - w[1].torque), 1e-6);
    EXPECT_GT(norm(w[0].force), 0.4);
}

TEST(Step, ContactsOutsideTheImpactSphereDoNotCountAndEnterItSmoothly)
{
    const query::Probe probe(square(30));
    Zone zone{.probe = &probe, .radius = 0.006, .options = exact};
    const TouchedBody solid = frictionless(box(), {rotation_about({1, 0, 0}, 0.1), {}});
    const auto force_at = [&](double radius) {
        zone.radius = radius;
        State state(std::span(&zone, 1));
        const Pose pose = shifted({0, 0, 0.029});
        Wrench w;
        (void)step(state, {.touched = std::span(&solid, 1), .poses = std::span(&pose, 1)}, std::span(&w, 1));
        return w.force;
    };
    EXPECT_EQ(force_at(1e-5), Vec3d{});
    EXPECT_GT(norm(force_at(0.006)), 0.1);
    for (double r = 0.004; r < 0.012; r += 1e-5) EXPECT_LT(norm(force_at(r + 1e-5) - force_at(r)), 0.01) << r;
}

TEST(Step, SolidsGetTheOppositeWrench)
{
    Tool tool(hand().mesh.vertices, with(Averaging::Patch));
    tool.on_touched.resize(2);
    sqmap::test::Random random(9);
    TouchedBody solids[2] = {frictionless(box()), frictionless(box())};
    for (TouchedBody& s : solids) s.material.friction = Friction::Coulomb;
    int touching = 0;
    for (int i = 0; i < 40; ++i) {
        const Pose pose = sqmap::test::random_pose(random, 0.06);
        for (int s = 0; s < 2; ++s) solids[s].pose = sqmap::test::random_pose(random, 0.05);
        tool.input.touched = solids;
        const Wrench w = tool.touch(solids, pose);
        Vec3d force = w.force, torque = w.torque + cross(pose.translation, w.force);
        for (int s = 0; s < 2; ++s) {
            const Wrench& o = tool.on_touched[static_cast<std::size_t>(s)];
            force += o.force;
            torque += o.torque + cross(solids[s].pose.translation, o.force);
        }
        EXPECT_LT(norm(force), 1e-9);
        EXPECT_LT(norm(torque), 1e-9);
        touching += norm(w.force) > 0.1 ? 1 : 0;
    }
    EXPECT_GT(touching, 10);
}

TEST(Step, OnlyThePlaceOfOneOverTheOtherCounts)
{
    const Pose world = sqmap::test::shifted({0.3, -0.2, 0.1});
    const Pose turned{rotation_about(normalized(Vec3d{1, 2, 3}), 1.1), world.translation};
    Tool a(hand().mesh.vertices, with(Averaging::Patch)), b(hand().mesh.vertices, with(Averaging::Patch));
    const Pose pose{rotation_about({0, 1, 0}, 0.4), {0.03, -0.07, 0.03}};
    const Wrench here = a.touch(frictionless(box()), pose);
    const Wrench there = b.touch(frictionless(box(), turned), sqmap::compose(turned, pose));
    EXPECT_GT(norm(here.force), 0.1);
    EXPECT_LT(norm(turned.rotation * here.force - there.force), 1e-3);
    EXPECT_LT(norm(turned.rotation * here.torque - there.torque), 1e-3);
}

TEST(Step, CoulombFrictionSticksThenSlipsWithinItsCone)
{
    Tool tool = Tool::point(exact);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Coulomb;
    Vec3d at{-0.01, 0, 0.029};
    (void)tool.touch(solid, at);
    bool stuck = false, slipped = false;
    double last = 0;
    for (int i = 0; i < 100; ++i) {
        at.x += 2e-5;
        const Vec3d f = tool.touch(solid, at).force;
        const double moved = 2e-5 * (i + 1), pull = -f.x;
        EXPECT_LE(pull, 0.4 * f.z + 2e-3);  // a sphere of samples is not quite level
        EXPECT_LT(std::abs(pull - last), 0.02) << "what lets go does not drop";
        last = pull;
        if ((tool.result.status & k_step_slipping) != 0) {
            EXPECT_GE(pull, 0.3 * f.z - 0.01);
            slipped = true;
        } else if (!slipped) {
            EXPECT_NEAR(pull, k * moved, 0.01);  // the sticking spring
            stuck = true;
        }
    }
    EXPECT_TRUE(stuck);
    EXPECT_TRUE(slipped);
    // Still: it holds, for ever.
    const Vec3d held = tool.touch(solid, at).force;
    EXPECT_NEAR(held.x, -0.3 * held.z, 0.01) << "the dynamic coefficient in the end";
    for (int i = 0; i < 1000; ++i) EXPECT_NEAR(tool.touch(solid, at).force.x, held.x, 1e-6);
    // Back by the stretch of the spring: nothing pulls.
    at.x -= 0.3 * held.z / k;
    EXPECT_NEAR(tool.touch(solid, at).force.x, 0, 0.02);
}

TEST(Step, FrictionNeverAddsEnergyAroundAClosedWay)
{
    Tool tool = Tool::point(exact);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Coulomb;
    double work = 0;
    Vec3d before{};
    Vec3d at{};
    for (int i = 0; i <= 2000; ++i) {
        const double a = 6.283185307179586 * i / 2000;
        const Vec3d next{0.004 * std::cos(a), 0.004 * std::sin(a), 0.029 + 0.0005 * std::sin(3 * a)};
        const Vec3d f = tool.touch(solid, next).force;
        if (i > 0) work += dot(0.5 * (f + before), next - at);
        before = f, at = next;
    }
    EXPECT_LT(work, -1e-3);
}

TEST(Step, PrintedFrictionIsEq33AndNothingWhileStill)
{
    Tool tool = Tool::point(exact);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Paper;
    (void)tool.touch(solid, Vec3d{0, 0, 0.029});
    Vec3d f = tool.touch(solid, Vec3d{0.0001, 0, 0.029}).force;
    EXPECT_NEAR(f.x, -0.2 * (1 + 100 * tool.report().depth), 0.01);
    f = tool.touch(solid, Vec3d{0.0001, 0, 0.029}).force;
    EXPECT_NEAR(f.x, 0, 0.01);
}

TEST(Step, DampingResistsPressingInAndNeverPulls)
{
    ZoneOptions o = exact;
    o.damping = 5;
    Tool tool = Tool::point(o);
    (void)tool.touch(frictionless(box()), Vec3d{0, 0, 0.0291});
    EXPECT_NEAR(tool.touch(frictionless(box()), Vec3d{0, 0, 0.029}).force.z, k * 0.001 + 5 * 0.1, 0.03);
    for (double z = 0.02905; z < 0.0300; z += 0.0002) EXPECT_GE(tool.touch(frictionless(box()), Vec3d{0, 0, z}).force.z, -1e-12);
}

TEST(Step, BrakingBeginsBeforeContactAndOnlyAgainstTheApproach)
{
    ZoneOptions o = exact;
    o.brake = 2;
    Tool tool = Tool::point(o);
    const Twist down{{0, 0, -0.4}, {}}, up{{0, 0, 0.4}, {}}, still{};
    const auto force = [&](const Twist& t, double z) {
        tool.state().reset();
        tool.input.twists = std::span(&t, 1);
        return tool.touch(frictionless(box()), Vec3d{0, 0, z}).force.z;
    };
    EXPECT_NEAR(force(down, 0.0305), 2 * 0.4 * 0.75, 0.05);  // 1.5 of the next 2 mm are in the solid
    EXPECT_EQ(force(down, 0.033), 0);
    EXPECT_EQ(force(up, 0.0305), 0);
    EXPECT_EQ(force(still, 0.0305), 0);
}

TEST(Step, ATouchThatCrossesTheMedialAxisIsBlended)
{
    // From one side of a plate to the other: the way out turns round.
    for (const double blend : {0.0, 0.01}) {
        ZoneOptions o = with(Averaging::Patch);
        o.blend_time = blend;
        Tool tool({{0, 0, 0}}, o);
        Vec3d before = tool.touch(frictionless(plate()), Vec3d{0, 0, 0.0009}).force;
        double most = 0;
        bool blended = false;
        for (double z = 0.00085; z > -0.0008; z -= 5e-5) {
            const Vec3d f = tool.touch(frictionless(plate()), Vec3d{0, 0, z}).force;
            most = std::max(most, norm(f - before));
            blended = blended || (tool.result.status & k_step_blended) != 0;
            before = f;
        }
        const double jump = 2 * k * 0.001;
        if (blend > 0)
            EXPECT_LT(most, 0.2 * jump);
        else
            EXPECT_GT(most, 0.9 * jump);
        EXPECT_EQ(blended, blend > 0);
        // And then it is gone.
        for (int i = 0; i < 200; ++i) before = tool.touch(frictionless(plate()), Vec3d{0, 0, -0.0008}).force;
        EXPECT_NEAR(before.z, -k * 0.0002, 1e-3);
        // Free at once.
        EXPECT_EQ(tool.touch(frictionless(plate()), Vec3d{0, 0, -0.002}), Wrench{});
    }
}

TEST(Step, AJumpOfTheFootPointLeavesForceAndTorqueAsTheyWereWithFrictionAndDamping)
{
    // A ball through the middle of a box, 3.5 cm deep, where the way out turns from up to down: 17.5 N, and the point where it
    // rubs is on its other side.
    const Smoothing smoothing = ball_of(0.005);
    ZoneOptions o = with(Averaging::Ball);
    o.smoothing = smoothing;
    o.damping = 2;
    Tool tool(stencil_points(smoothing), o);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Coulomb;
    const Vec3d motion{3e-5, 0, -1e-4};
    const double fade = 250 * 0.001, explained = 3 * k * norm(motion);
    Vec3d at{-0.01, 0, 0.034};
    Wrench before = tool.touch(solid, at);
    bool jumped = false;
    double most = 0, rubbed = 0;
    for (int i = 0; i < 500; ++i) {
        at += motion;
        const Wrench w = tool.touch(solid, at);
        const double force = norm(w.force - before.force), torque = norm(w.torque - before.torque);
        if (!jumped && (tool.result.status & k_step_blended) != 0) {
            jumped = true;
            EXPECT_LT(force, 1.001 * explained);
            EXPECT_LT(torque, 0.002);
        }
        EXPECT_LT(force, explained + fade);
        EXPECT_LT(torque, 0.003);
        most = std::max(most, norm(w.force));
        rubbed = std::max(rubbed, norm(w.torque));
        before = w;
    }
    EXPECT_TRUE(jumped);
    EXPECT_GT(most, 17);
    EXPECT_GT(rubbed, 0.02) << "it rubs";
    EXPECT_LT(before.force.z, -9) << "and in the end the way out is down";
}

TEST(Step, ATorqueThatJumpsWhereTheForceDoesNotIsBlended)
{
    // A seesaw in a plate: both ends pass to the other side at once.
    for (const double blend : {0.0, 0.01}) {
        ZoneOptions o = with(Averaging::Patch);
        o.blend_time = blend;
        Tool tool({{0.03, 0, 0}, {-0.03, 0, 0}}, o);
        const auto at = [](double angle, double x) { return Pose{rotation_about({0, 1, 0}, angle), {x, 0, 1e-6}}; };
        Wrench before = tool.touch(frictionless(plate()), at(-0.00205, 0));
        double most = 0, force = 0;
        for (int i = 1; i <= 41; ++i) {
            const Wrench w = tool.touch(frictionless(plate()), at(-0.00205 + 1e-4 * i, 1e-5 * i));
            most = std::max(most, norm(w.torque - before.torque));
            force = std::max(force, norm(w.force));
            before = w;
        }
        EXPECT_LT(force, 0.01);
        if (blend > 0)
            EXPECT_LT(most, 0.01);
        else
            EXPECT_GT(most, 0.05);
    }
}

TEST(Step, ALightTouchTurnsNoFasterThanADeepOne)
{
    // A point under a plate's edge passes from the top to the side: a right angle, and less than stiffness times motion explains.
    for (const double depth : {0.0002, 0.0009}) {
        Tool tool({{0, 0, 0}}, with(Averaging::Patch));
        const auto touch = [&](double x) { return tool.touch(frictionless(plate()), Vec3d{x, 0, 0.001 - depth}).force; };
        Vec3d before = touch(0.04998 - depth);
        EXPECT_GT(before.z, 0.05);
        const Vec3d after = touch(0.05002 - depth);
        EXPECT_LT(angle_between(before, after), 1.01 * 4e-5 / 0.001);
        Vec3d f = after;
        for (int i = 0; i < 100; ++i) {
            before = f;
            f = touch(0.05002 - depth);
            EXPECT_LT(angle_between(before, f), 0.15);
        }
        EXPECT_GT(angle_between(f, {0, 0, 1}), 1.5) << "and in the end it has turned";
    }
}

TEST(Step, AProxyHoldsWhereThinPartsLetGo)
{
    ZoneOptions o = exact;
    o.mode = Mode::Proxy;
    Tool proxy = Tool::point(o), direct = Tool::point(exact);
    for (double z = 0.003; z > -0.004; z -= 1e-4) {
        const Vec3d f = proxy.touch(frictionless(plate()), Vec3d{0, 0, z}).force;
        const double depth = std::max(0.001 - z, 0.);
        EXPECT_NEAR(f.z, k * depth, 0.02 + 0.02 * k * depth) << z;
        EXPECT_LT(std::hypot(f.x, f.y), 0.05 * k * std::max(depth, 0.0005));
        EXPECT_GE(proxy.report().body.translation.z, 0.001 - 1e-4);
        (void)direct.touch(frictionless(plate()), Vec3d{0, 0, z});
    }
    EXPECT_EQ(direct.touch(frictionless(plate()), Vec3d{0, 0, -0.004}), Wrench{});  // through
    for (double z = -0.004; z < 0.003; z += 1e-4) (void)proxy.touch(frictionless(plate()), Vec3d{0, 0, z});
    EXPECT_EQ(proxy.touch(frictionless(plate()), Vec3d{0, 0, 0.003}), Wrench{});
}

TEST(Step, AProxyOfAMeshHoldsOnAPlateThinnerThanItWouldLie)
{
    ZoneOptions o = with(Averaging::Patch);
    o.mode = Mode::Proxy;
    Tool tool(square(8), o);
    Vec3d before{};
    for (double z = 0.003; z > -0.02; z -= 1e-4) {
        const Vec3d f = tool.touch(frictionless(plate()), Vec3d{0, 0, z}).force;
        EXPECT_LT(norm(f - before), 0.26 + 1.1 * k * 1e-4) << z;
        if (z < -0.001) {
            EXPECT_NEAR(f.z, k * (0.001 - z), 0.3 * k * (0.001 - z)) << z;
        }
        before = f;
    }
    EXPECT_GT(tool.report().body.translation.z, 0);
    for (int i = 0; i < 200; ++i) before = tool.touch(frictionless(plate()), Vec3d{0, 0, -0.02}).force;
    EXPECT_NEAR(before.z, k * 0.021, 0.05);
    EXPECT_LT(norm(tool.touch(frictionless(plate()), Vec3d{0, 0, -0.02}).force - before), 1e-4);
}

TEST(Step, AProxyThatBeganInsideIsWithTheDeviceOnceThatIsFree)
{
    for (const bool patch : {false, true}) {
        ZoneOptions o = patch ? with(Averaging::Patch) : exact;
        o.mode = Mode::Proxy;
        o.averaging = patch ? Averaging::Patch : Averaging::Stencil;
        Tool tool(patch ? square(4) : stencil_points(o.smoothing), o);
        // Nearer to the bottom: there it comes out.
        for (double z = -0.01; z < 0.0301; z += 5e-4) (void)tool.touch(frictionless(box()), Vec3d{0, 0, z});
        EXPECT_EQ(tool.touch(frictionless(box()), Vec3d{0, 0, 0.033}), Wrench{});
        for (double z = 0.033; z > 0.028; z -= 1e-4) (void)tool.touch(frictionless(box()), Vec3d{0, 0, z});
        EXPECT_NEAR(tool.touch(frictionless(box()), Vec3d{0, 0, 0.028}).force.z, k * 0.002, 0.05);
    }
}

TEST(Step, AProxyRubsAsPrintedWhereAsked)
{
    ZoneOptions o = exact;
    o.mode = Mode::Proxy;
    Tool tool = Tool::point(o);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Paper;
    solid.material.f_c = 0.2;
    solid.material.k_f = 100;
    Vec3d f;
    for (int i = 0; i < 100; ++i) f = tool.touch(solid, Vec3d{1e-4 * i, 0, std::max(0.0305 - 1e-4 * i, 0.028)}).force;
    EXPECT_NEAR(f.x, -0.2 * (1 + 100 * 0.002), 0.02);
    for (int i = 0; i < 100; ++i) f = tool.touch(solid, Vec3d{0.0099, 0, 0.028}).force;
    EXPECT_NEAR(f.x, 0, 0.01) << "none while still";
}

TEST(Step, AProxyFollowsASurface)
{
    ZoneOptions o = exact;
    o.mode = Mode::Proxy;
    Tool tool = Tool::point(o);
    const mesh::Solid solid(hand().mesh);
    double most = 0;
    Vec3d before{};
    // Along a finger, 3 mm below its skin.
    for (int i = 0; i < 600; ++i) {
        const double a = 0.0001 * i;
        const Vec3d probe{0, 0.05 + a, 0};
        const mesh::ClosestPoint c = solid.closest_boundary(probe);
        const Vec3d n = (solid.inside(probe) ? 1. : -1.) * normalized(c.point - probe);
        if (i == 0) before = c.point + 0.004 * n;
        (void)tool.touch(frictionless(hand()), i == 0 ? before : c.point - 0.003 * n);
        const Vec3d p = tool.report().body.translation;
        const double off = solid.closest_boundary(p).distance;
        if (i > 20) most = std::max(most, off);
    }
    EXPECT_LT(most, 5e-4);
}

TEST(Step, AProxyBallKeepsItsForceAlongACurvedSurface)
{
    ZoneOptions o = with(Averaging::Ball);
    o.mode = Mode::Proxy;
    o.layer = query::Layer::Exact;
    o.smoothing = {.radius = 0.005, .points = 500, .tolerance = 0.0003};
    Tool tool(stencil_points(o.smoothing), o);
    static const sqmap::test::Solid k_ball(mesh::sphere(0.05, 3));
    const auto at = [](double angle, double height) {
        return (0.055 + height) * normalized(Vec3d{std::sin(angle), 0.3 * std::sin(2 * angle), std::cos(angle)});
    };
    Vec3d before{};
    for (int i = 0; i < 100; ++i) before = tool.touch(frictionless(k_ball), at(0, 0.001 - 3e-5 * i)).force;
    for (int i = 0; i < 1000; ++i) {
        const Vec3d f = tool.touch(frictionless(k_ball), at(0.002 * i, -0.002)).force;
        ASSERT_GT(norm(f), 0.5 * k * 0.002) << i;
        ASSERT_LT(norm(f - before), 0.1 * k * 0.002) << i;
        before = f;
    }
}

TEST(Step, FrictionHoldsAProxyWithinItsCone)
{
    ZoneOptions o = exact;
    o.mode = Mode::Proxy;
    Tool tool = Tool::point(o);
    TouchedBody solid = frictionless(box());
    solid.material.friction = Friction::Coulomb;
    bool slipped = false;
    for (double z = 0.0301; z > 0.028; z -= 1e-4) (void)tool.touch(solid, Vec3d{0, 0, z});
    for (double x = 0; x < 0.003; x += 5e-5) {
        const Vec3d f = tool.touch(solid, Vec3d{x, 0, 0.028}).force;
        EXPECT_LE(-f.x, 0.4 * f.z + 0.01);
        if (x > 0 && x < 0.0007) {
            EXPECT_NEAR(-f.x, k * x, 0.03);
        }
        slipped = slipped || (tool.result.status & k_step_slipping) != 0;
    }
    EXPECT_TRUE(slipped);
}

TEST(Step, ACoupledBodyComesToRestOnTheSurfaceAndPullsTheHand)
{
    ZoneOptions o = with(Averaging::Patch);
    o.mode = Mode::Coupled;
    o.stiffness = 3000;
    Tool tool(square(8), o);
    // 5 mm into the box: springs in series.
    Wrench w;
    for (int i = 0; i < 50; ++i) w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.03 + 0.001 * (50 - i) / 50});
    for (int i = 0; i < 50; ++i) w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.03 - 0.005 * i / 50});
    std::vector<double> last;
    for (int i = 0; i < 2000; ++i) {
        w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.025});
        if (i >= 1900) last.push_back(w.force.z);
    }
    const double series = o.coupling_stiffness * 3000 / (o.coupling_stiffness + 3000) * 0.005;
    EXPECT_NEAR(w.force.z, series, 0.05 * series);
    EXPECT_LT(0.03 - tool.report().body.translation.z, 0.002);
    const auto [lo, hi] = std::minmax_element(last.begin(), last.end());
    EXPECT_LT(*hi - *lo, 1e-4);
    // Free: nothing but the body's own inertia.
    for (int i = 0; i < 300; ++i) w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.06});
    EXPECT_LT(norm(w.force), 1e-3);
    EXPECT_LT(norm(w.torque), 1e-5);
}

TEST(Step, AProxyOfAMeshIsBorneByManyPointsAndNotByTheDeepest)
{
    // A ball of points 2 to 4 mm apart slides over another, pressed in by 1 cm: by turns one or the other is the deepest.
    static const sqmap::test::Solid k_ball(mesh::sphere(0.05, 3));
    const mesh::Mesh ball = mesh::sphere(0.03, 3);
    double steps[2] = {}, turns[2] = {};
    for (const bool borne : {false, true}) {
        ZoneOptions o = with(Averaging::Patch);
        o.mode = Mode::Proxy;
        o.proxy_depth = borne ? 0.002 : 0;
        Tool tool(ball.vertices, o);
        const auto touch = [&](double angle, double depth) {
            return tool.touch(frictionless(k_ball), (0.08 - depth) * Vec3d{std::sin(angle), 0, std::cos(angle)});
        };
        for (int i = 0; i < 200; ++i) (void)touch(0, 5e-5 * i);
        Wrench before = touch(0, 0.01);
        double weakest = INFINITY;
        for (int i = 0; i < 400; ++i) {
            const Wrench w = touch(0.001 * i, 0.01);
            steps[borne] = std::max(steps[borne], norm(w.force - before.force));
            turns[borne] = std::max(turns[borne], norm(w.torque - before.torque));
            weakest = std::min(weakest, norm(w.force));
            before = w;
        }
        EXPECT_GT(weakest, 0.7 * k * 0.01) << "the mean depth of a patch is less than that of the deepest";
        for (int i = 0; i < 300; ++i) before = touch(0.4, 0.01);
        const Wrench still = touch(0.4, 0.01);
        if (borne) {
            EXPECT_LT(norm(still.force - before.force), 1e-4);
            EXPECT_LT(norm(still.torque - before.torque), 1e-5);
        }
    }
    EXPECT_LT(steps[1], 1.2 * k * 0.07 * 0.001);
    EXPECT_LT(turns[1], 0.6 * turns[0]);
}

TEST(Step, AProxyOfAMeshThatPressesLightlyFeelsWhatItsPointsFeel)
{
    ZoneOptions o = with(Averaging::Patch);
    Tool direct(square(8), o);
    o.mode = Mode::Proxy;
    Tool proxy(square(8), o);
    for (double z = 0.0305; z > 0.0282; z -= 5e-5) {
        const Wrench a = direct.touch(frictionless(box()), Vec3d{0, 0, z}), b = proxy.touch(frictionless(box()), Vec3d{0, 0, z});
        EXPECT_NEAR(b.force.z, a.force.z, 1e-3) << z;
        EXPECT_NEAR(norm(b.torque), norm(a.torque), 1e-4) << z;
    }
    const Wrench before = proxy.touch(frictionless(box()), Vec3d{0, 0, 0.0282});
    proxy.input.degraded = true;
    const Wrench late = proxy.touch(frictionless(box()), Vec3d{0, 0, 0.0282});
    EXPECT_NEAR(norm(late.force - before.force), 0, 1e-3);
    EXPECT_NEAR(norm(late.torque - before.torque), 0, 1e-4);
}

TEST(Step, ACoupledBodyThatLeapsIsFeltBlended)
{
    // A ball through the middle of a box, as above, through a coupling: the body leaps to the other side.
    for (const double blend : {0.0, 0.01}) {
        const Smoothing smoothing = ball_of(0.005);
        ZoneOptions o = with(Averaging::Ball);
        o.smoothing = smoothing;
        o.mode = Mode::Coupled;
        o.coupling_stiffness = 2000;
        o.blend_time = blend;
        Tool tool(stencil_points(smoothing), o);
        Wrench before = tool.touch(frictionless(box()), Vec3d{0, 0, 0.036});
        double most = 0, strongest = 0;
        for (int i = 0; i < 800; ++i) {
            const Wrench w = tool.touch(frictionless(box()), Vec3d{0, 0, 0.036 - 1e-4 * i});
            most = std::max(most, norm(w.force - before.force));
            strongest = std::max(strongest, norm(w.force));
            before = w;
        }
        EXPECT_GT(strongest, 8);
        if (blend > 0)
            EXPECT_LT(most, 250 * 0.001 + 3 * 2000 * 1e-4);
        else
            EXPECT_GT(most, 1.5);
    }
}

TEST(Step, ATeleportForgetsWhatWasTouchedBefore)
{
    for (const Mode mode : {Mode::Direct, Mode::Proxy, Mode::Coupled}) {
        ZoneOptions o = with(Averaging::Patch);
        o.mode = mode;
        Tool tool(square(8), o), fresh(square(8), o);
        TouchedBody solid = frictionless(box());
        solid.material.friction = Friction::Coulomb;
        for (int i = 0; i < 60; ++i) (void)tool.touch(solid, Vec3d{1e-4 * i, 0, 0.031 - 5e-5 * i});
        EXPECT_GT(std::fabs(tool.touch(solid, Vec3d{0.006, 0, 0.028}).force.x), 0.05) << "it rubs";
        EXPECT_EQ(tool.touch(solid, Vec3d{0.006, 0, 0.2}).force.z, 0);
        EXPECT_TRUE(tool.result.status & k_step_teleport);
        const Wrench back = tool.touch(solid, Vec3d{0.006, 0, 0.0295}), first = fresh.touch(solid, Vec3d{0.006, 0, 0.0295});
        EXPECT_TRUE(tool.result.status & k_step_teleport);
        EXPECT_EQ(back, first) << "as though it had never been there";
    }
}

TEST(Step, ACoupledBodyTurnsOffAnEdge)
{
    ZoneOptions o = with(Averaging::Patch);
    o.mode = Mode::Coupled;
    Tool tool(square(12), o);
    // Pressed down half off the box's flat top: the box pushes one side up.
    Wrench w;
    for (int i = 0; i < 500; ++i) w = tool.touch(frictionless(box()), Vec3d{0.05, 0, 0.030 - std::min(i, 50) * 4e-5});
    EXPECT_GT(w.force.z, 0.3);
    EXPECT_GT(w.torque.y, 1e-3);
}

TEST(Step, CouplingDampingLeavesTheDevicePassive)
{
    const double most = coupling_damping({.stiffness = 800, .mass = 0.05, .period = 0.001, .device_damping = 2});
    EXPECT_DOUBLE_EQ(most, 2 - 0.5 * 800 * 0.001);  // b - K T / 2
    EXPECT_DOUBLE_EQ(coupling_damping({.stiffness = 800, .mass = 0.05, .period = 0.001, .device_damping = 100}),
                     2 * std::sqrt(800 * 0.05));
    EXPECT_DOUBLE_EQ(coupling_damping({.stiffness = 8000, .mass = 0.05, .period = 0.001, .device_damping = 2}), 0);
}

TEST(Step, CouplingDampingCountsDelayAndEncoder)
{
    const CouplingPhysics p{.stiffness = 200, .mass = 0.05, .period = 0.001, .device_damping = 1, .delay = 0.003};
    EXPECT_DOUBLE_EQ(coupling_damping(p), 1 - 200 * 0.0035);
    CouplingPhysics coarse = p;
    coarse.friction = 0.02;
    coarse.resolution = 1e-4;
    EXPECT_DOUBLE_EQ(coupling_damping(coarse), 0.02 * 0.001 / 1e-4);  // a step in a tick: 0.1 m/s and 0.02 N
}

TEST(Step, AChosenCouplingIsWithinWhatTheDeviceCanShow)
{
    for (const double b : {0.0, 0.1, 1.0, 5.0})
        for (const double delay : {0.0, 0.001, 0.003})
            for (const double resolution : {0.0, 10e-6, 100e-6})
                for (const double period : {0.00025, 0.001, 0.01}) {
                    const DeviceLimits device{
                        .damping = b, .coulomb_friction = 0.05, .resolution = resolution, .delay = delay, .period = period};
                    ZoneOptions o;
                    o.coupling_stiffness = 5000;
                    choose_coupling(o, device);
                    EXPECT_GT(o.coupling_stiffness, 0);
                    EXPECT_GT(o.coupling_damping, 0);
                    EXPECT_TRUE(check_stiffness(device, o.coupling_stiffness, o.coupling_damping).safe)
                        << b << ' ' << delay << ' ' << resolution << ' ' << period;
                    EXPECT_EQ(o.resolution, resolution);
                    ZoneOptions softer;
                    softer.coupling_stiffness = 5;
                    choose_coupling(softer, device);
                    EXPECT_EQ(softer.coupling_stiffness, 5) << "never stiffer than asked";
                }
}

TEST(Step, ATorqueShareKeepsTheTurningSpringWithinWhatTheDeviceShows)
{
    const DeviceLimits device{.damping = 1, .coulomb_friction = 0.05, .resolution = 25e-6, .delay = 0.001, .period = 0.001};
    EXPECT_EQ(largest_torque_share(device, 500, 0.01), 1);
    const double reach = 0.1, share = largest_torque_share(device, 500, reach);
    EXPECT_NEAR(share * 500 * reach * reach * 0.0015, 1 * 0.02 * 0.02, 1e-9);  // K (T/2 + delay) = b, turning
    EXPECT_EQ(largest_torque_share(device, 0, reach), 1);
}

TEST(Step, AnEncodersStepsAreNotFeltThroughACoupling)
{
    // In free air at 5 mm/s an encoder of 25 um gives one step in 5 ticks: 25 mm/s for one tick, 0 for four.
    double worst[2] = {};
    for (const bool told : {false, true}) {
        ZoneOptions o = with(Averaging::Patch);
        o.mode = Mode::Coupled;
        o.coupling_damping = 5;
        o.resolution = told ? 25e-6 : 0;
        o.blend_time = 0;  // or the steps would be taken for jumps
        Tool tool(square(4), o);
        for (int i = 0; i < 400; ++i) {
            const double x = 25e-6 * std::round(5e-6 * i / 25e-6);
            const Wrench w = tool.touch(frictionless(box()), Vec3d{x, 0, 0.06});
            if (i > 100) worst[told] = std::max(worst[told], norm(w.force));
        }
    }
    EXPECT_GT(worst[0], 0.04);
    EXPECT_LT(worst[1], 0.25 * worst[0]);
}

TEST(Step, ADamperFeelsTheDevicesVelocityAndNotItsEncodersSteps)
{
    // Going in at a steady speed: a difference of two poses would make 0.05 N or nothing of it, by turns.
    constexpr double step = 25e-6;
    for (const double speed : {0.004, 0.01, 0.02, 0.05}) {
        ZoneOptions o = with(Averaging::Stencil);
        o.damping = 2;
        o.resolution = step;
        Tool tool(stencil_points({}), o);
        for (int i = 0; i < 60; ++i) {
            const double z = step * std::round((0.029 - speed * 0.001 * i) / step);
            const double felt = tool.touch(frictionless(box()), Vec3d{0, 0, z}).force.z;
            const double damped = felt - o.stiffness * tool.report().depth;
            if (i < 20) continue;
            EXPECT_NEAR(damped, 2 * speed, 0.4 * 2 * step / 0.001) << speed << ' ' << i;
        }
    }
}

TEST(Step, ALateTickIsAnsweredFromThePlanesOfTheLastOne)
{
    for (const Averaging averaging : {Averaging::Stencil, Averaging::Patch}) {
        Tool tool(averaging == Averaging::Patch ? square(9) : stencil_points({}), with(averaging)),
            sure(averaging == Averaging::Patch ? square(9) : stencil_points({}), with(averaging));
        (void)tool.touch(frictionless(box()), Vec3d{0, 0, 0.029});
        (void)sure.touch(frictionless(box()), Vec3d{0, 0, 0.029});
        tool.input.degraded = true;
        for (const double z : {0.0289, 0.0288, 0.0292, 0.0297, 0.0299}) {
            const Wrench late = tool.touch(frictionless(box()), Vec3d{0.0001, 0, z});
            EXPECT_NE(tool.result.status & k_step_degraded, 0u);
            EXPECT_NEAR(tool.result.deepest, 0.03 - z, 1e-4);
            EXPECT_GT(tool.result.contacts, 0u);
            EXPECT_LT(norm(late.force - sure.touch(frictionless(box()), Vec3d{0.0001, 0, z}).force), 0.02) << z;
        }
        EXPECT_EQ(tool.touch(frictionless(box()), Vec3d{0, 0, 0.0301}), Wrench{});
        EXPECT_EQ(tool.state().degraded_steps(), 6u);
        // Nothing was ever touched: nothing is felt, deep though it be.
        tool.state().reset();
        EXPECT_EQ(tool.touch(frictionless(box()), Vec3d{0, 0, 0.02}), Wrench{});
    }
}

TEST(Step, ALateTickInTheSamePlaceFeelsTheSame)
{
    for (const Averaging averaging : {Averaging::Stencil, Averaging::Ball})
        for (const Shading shading : {Shading::Levelled, Shading::Consistent}) {
            ZoneOptions o = with(averaging);
            o.shading = shading;
            Tool tool(stencil_points(o.smoothing), o);
            const Vec3d on_ridge{0.0002, 0, averaging == Averaging::Ball ? 0.001 : -0.001};
            const Wrench in_time = tool.touch(frictionless(roof(1)), on_ridge);
            tool.input.degraded = true;
            EXPECT_GT(norm(in_time.force), 0.1);
            EXPECT_LT(norm(tool.touch(frictionless(roof(1)), on_ridge).force - in_time.force), 1e-9);
        }
}

TEST(Step, WhatIsNotFiniteGivesNoForceAndHarmsNoOtherZone)
{
    const query::Probe probe(square(5));
    const Zone zones[2] = {{.probe = &probe, .options = exact}, {.probe = &probe, .options = exact}};
    State state(zones);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    TouchedBody solid = frictionless(box());
    Pose poses[2] = {shifted({0, 0, 0.029}), shifted({0, 0, 0.029})};
    Wrench w[2];
    (void)step(state, {.touched = std::span(&solid, 1), .poses = poses}, w);
    poses[1].translation.y = nan;
    const StepResult r = step(state, {.touched = std::span(&solid, 1), .poses = poses}, w);
    EXPECT_NE(r.status & k_step_not_finite, 0u);
    EXPECT_NEAR(w[0].force.z, k * 0.001, 1e-3);
    EXPECT_EQ(w[1], Wrench{});
    for (const double dt : {nan, 0., -1., std::numeric_limits<double>::infinity()}) {
        (void)step(state, {.touched = std::span(&solid, 1), .poses = poses, .dt = dt}, w);
        EXPECT_EQ(w[0], Wrench{});
    }
    poses[1].translation.y = 0;
    // A force whose components are finite and whose size is not.
    state.options(0).stiffness = 1e200;
    EXPECT_NE(step(state, {.touched = std::span(&solid, 1), .poses = poses}, w).status & k_step_not_finite, 0u);
    EXPECT_EQ(w[0], Wrench{});
    state.options(0).stiffness = k;
    solid.pose.rotation.row[1].x = nan;
    EXPECT_NE(step(state, {.touched = std::span(&solid, 1), .poses = poses}, w).status & k_step_not_finite, 0u);
    EXPECT_EQ(w[0], Wrench{});
    EXPECT_NE(step(state, {.touched = std::span(&solid, 1), .poses = poses}, std::span(w).first(1)).status & k_step_short_span,
              0u);
}

/// Work around closed ways of 3 mm about places of the hand's skin, by the trapezium rule; and what the force is worth.
struct Work {
    double around = 0, passed = 0;
};
template <class MakePose>
Work work_around(Tool& tool, const TouchedBody& solid, MakePose&& pose_at)
{
    Work work;
    constexpr int n = 1500;
    Wrench before{};
    Pose at{};
    for (int i = 0; i <= n; ++i) {
        const Pose next = pose_at(6.283185307179586 * (i % n) / n);
        const Wrench w = tool.touch(solid, next);
        if (i > 0) {
            const Twist moved = twist_between(at, next, 1);
            work.around +=
                dot(0.5 * (w.force + before.force), moved.linear) + dot(0.5 * (w.torque + before.torque), moved.angular);
            work.passed += norm(w.force) * norm(moved.linear) + norm(w.torque) * norm(moved.angular);
        }
        before = w, at = next;
    }
    return work;
}

TEST(Step, ConsistentForcesGiveNoEnergyAroundAClosedWay)
{
    ZoneOptions o = exact;
    o.shading = Shading::Consistent;
    o.blend_time = 0;
    Tool point = Tool::point(o);
    o.averaging = Averaging::Patch;
    Tool patch(mapped(mesh::sphere(0.008, 3), 1, {0.01, 0, 0}).vertices, o);
    sqmap::test::Random random(21);
    int touching = 0;
    for (int i = 0; i < 12; ++i) {
        const auto& t = hand().mesh.triangles[random.below(hand().mesh.triangles.size())];
        const Vec3d at = hand().mesh.vertices[t[0]], u = random.direction(), v = normalized(cross(u, random.direction()));
        point.state().reset();
        const Work a = work_around(point, frictionless(hand()),
                                   [&](double s) { return shifted(at + 0.003 * std::cos(s) * u + 0.003 * std::sin(s) * v); });
        EXPECT_LT(std::abs(a.around), 0.01 * a.passed + 1e-7);
        patch.state().reset();
        const Work b = work_around(patch, frictionless(hand()), [&](double s) {
            return Pose{rotation_about(u, 0.2 * std::sin(s)), at + 0.003 * std::cos(s) * u + 0.003 * std::sin(s) * v};
        });
        EXPECT_LT(std::abs(b.around), 0.03 * b.passed + 1e-7);  // some depths of the map are another surface's
        touching += a.passed > 1e-4 && b.passed > 1e-4 ? 1 : 0;
    }
    EXPECT_GT(touching, 6);
}

TEST(Step, AConsistentForceIsTheSlopeOfItsPotential)
{
    ZoneOptions o = exact;
    o.shading = Shading::Consistent;
    o.blend_time = 0;
    for (const Averaging averaging : {Averaging::Stencil, Averaging::Patch}) {
        Tool tool(averaging == Averaging::Patch ? mesh::sphere(0.008, 3).vertices : stencil_points({}), with(averaging, o));
        for (const Vec3d at : {Vec3d{0.01, 0.02, 0.0295}, Vec3d{0.0455, 0.01, 0.0255}}) {  // flat, and on a rounded edge
            const auto potential = [&](Vec3d p) {
                tool.state().reset();
                (void)tool.touch(frictionless(box()), p);
                return tool.report().potential;
            };
            tool.state().reset();
            const Vec3d force = tool.touch(frictionless(box()), at).force;
            ASSERT_GT(norm(force), 0.05);
            Vec3d slope{};
            for (int axis = 0; axis < 3; ++axis) {
                Vec3d h{};
                h[axis] = 2e-5;
                slope[axis] = -(potential(at + h) - potential(at - h)) / 4e-5;
            }
            EXPECT_LT(norm(slope - force), 0.03 * norm(force));
        }
    }
}

TEST(Step, ReplaysToTheLastBit)
{
    const auto hash_of_run = [] {
        ZoneOptions o = exact;
        o.layer = query::Layer::Three;
        Tool tool(hand().mesh.vertices, o);
        Tool point = Tool::point(exact);
        TouchedBody solid = frictionless(box());
        solid.material.friction = Friction::Coulomb;
        std::uint64_t hash = 14695981039346656037ull;
        for (int i = 0; i < 10000; ++i) {
            const double a = 0.001 * i;
            tool.input.degraded = i % 17 == 0;
            const Pose pose{rotation_about({0, 0, 1}, 0.3 * a), {0.05 + 0.01 * std::sin(a), -0.05, 0.02 + 0.01 * std::cos(a)}};
            for (const Wrench& w : {tool.touch(solid, pose), point.touch(solid, Vec3d{0.01 * std::sin(a), 0, 0.029})})
                for (const Vec3d& v : {w.force, w.torque})
                    for (int k3 = 0; k3 < 3; ++k3) {
                        const double x = v[k3];
                        std::uint64_t bits = 0;
                        std::memcpy(&bits, &x, sizeof bits);
                        hash = (hash ^ bits) * 1099511628211ull;
                    }
        }
        return hash;
    };
    const std::uint64_t alone = hash_of_run();
    std::uint64_t together[3] = {};
    std::thread threads[3];
    for (int i = 0; i < 3; ++i) threads[i] = std::thread([&, i] { together[i] = hash_of_run(); });
    for (std::thread& t : threads) t.join();
    for (const std::uint64_t hash : together) EXPECT_EQ(hash, alone);
}

TEST(Step, AnEdgeIsCrossedWithoutAJump)
{
    // A coarse ball: its edges turn by 8 to 18 degrees.
    const sqmap::test::Solid ball(mesh::sphere(0.05, 2));
    const mesh::Solid oracle(ball.mesh);
    Tool tool = Tool::point(exact);
    Vec3d ours_before{}, mesh_before{};
    double ours = 0, of_mesh = 0;
    for (int i = 0; i < 3000; ++i) {
        const double a = 1e-4 * i / 0.049;
        const Vec3d at = 0.0485 * normalized(Vec3d{std::cos(a), std::sin(a), 0.3 * std::sin(0.7 * a)});
        const mesh::ClosestPoint c = oracle.closest_boundary(at);
        ASSERT_TRUE(oracle.inside(at));
        const auto& t = ball.mesh.triangles[c.triangle];
        const Vec3d n = normalized(
            cross(ball.mesh.vertices[t[1]] - ball.mesh.vertices[t[0]], ball.mesh.vertices[t[2]] - ball.mesh.vertices[t[0]]));
        const Vec3d m = (k * c.distance) * n, f = tool.touch(frictionless(ball), at).force;
        if (i > 0) ours = std::max(ours, norm(f - ours_before)), of_mesh = std::max(of_mesh, norm(m - mesh_before));
        ours_before = f, mesh_before = m;
        EXPECT_NEAR(norm(f), k * c.distance, k * 2.1e-4);
    }
    EXPECT_GT(of_mesh, 0.05);
    EXPECT_LT(ours, 0.1 * of_mesh);
}

TEST(Step, TwoSolidsAreFeltTogether)
{
    // In a slot between two boxes, one above the other.
    Tool tool(square(5), exact);
    const TouchedBody below = frictionless(box()), above = frictionless(box(), shifted({0, 0, 0.0575}));
    const TouchedBody both[2] = {below, above};
    const Vec3d at{0, 0, 0.029};
    const double up = tool.touch(below, at).force.z;
    tool.state().reset();
    const double down = tool.touch(above, at).force.z;
    tool.state().reset();
    EXPECT_GT(up, 0.4);
    EXPECT_LT(down, -0.2);
    EXPECT_NEAR(tool.touch(both, shifted(at)).force.z, up + down, 1e-9);
}

TEST(Step, TheShellKernelTakesTheMapsNormals)
{
    ZoneOptions o = exact;
    o.smoothing.kernel = Kernel::Shell;
    Tool tool = Tool::point(o);
    const Vec3d f = tool.touch(frictionless(box()), Vec3d{0.003, 0.002, 0.029}).force;
    EXPECT_NEAR(f.z, k * 0.001, 0.01);
    EXPECT_LT(std::hypot(f.x, f.y), 1e-6);  // a plane's normal, whatever the samples
}

TEST(Step, AModelInMetresIsTheSameModelSmaller)
{
    const sqmap::test::Solid big(mapped(box().mesh, 1000, {300, 0, 0}));  // millimetres, off its origin
    const model::ModelView view = in_metres(big.view, 0.001);
    TouchedBody solid = frictionless(box());
    solid.model = &view;
    Tool tool(square(5), exact);
    const Wrench w = tool.touch(solid, Vec3d{0.3, 0, 0.029});
    EXPECT_NEAR(w.force.z, k * 0.001, 1e-3);
}

/// Ticks whose force changes by more than `least` after it has changed by as much the other way.
int reversals(const std::vector<Vec3d>& forces, double least)
{
    int n = 0;
    for (std::size_t i = 2; i < forces.size(); ++i) {
        const Vec3d a = forces[i - 1] - forces[i - 2], b = forces[i] - forces[i - 1];
        n += norm(a) > least && norm(b) > least && dot(a, b) < 0 ? 1 : 0;
    }
    return n;
}

TEST(Step, AProxyDoesNotChatterOnFacetsNorOnTextures)
{
    static const sqmap::test::Solid k_ball(mesh::sphere(0.05, 3));
    std::vector<float> values;
    const Texture texture = gaussian_texture({.amplitude = 0.0002}, values);
    for (const bool rough : {false, true})
        for (const Averaging averaging : {Averaging::Ball, Averaging::Stencil, Averaging::Patch}) {
            ZoneOptions o = with(averaging);
            o.mode = Mode::Proxy;
            const double radius = averaging == Averaging::Ball ? 0.02 : 0;
            if (averaging != Averaging::Patch) {
                o.layer = query::Layer::Exact;
                o.smoothing = averaging == Averaging::Ball ? ball_of(radius) : Smoothing{};
            }
            const std::vector<Vec3d> patch = mesh::sphere(0.01, 3).vertices;
            Tool tool(averaging == Averaging::Patch ? patch : stencil_points(o.smoothing), o);
            TouchedBody solid = frictionless(k_ball);
            if (rough) solid.material.texture = &texture;
            const double far = averaging == Averaging::Patch ? 0.01 : radius;
            std::vector<Vec3d> forces;
            for (int i = 0; i < 1500; ++i) {
                const double angle = 0.0007 * i, depth = std::min(1e-5 * i, 0.003);
                forces.push_back(tool.touch(solid, (0.05 + far - depth) * Vec3d{std::sin(angle), 0, std::cos(angle)}).force);
            }
            EXPECT_GT(norm(forces.back()), 0.5);
            EXPECT_LE(reversals(forces, 0.02), 2) << int(averaging) << (rough ? " rough" : " smooth");
        }
}

TEST(Step, ALateTickFeelsTheTextureToo)
{
    std::vector<float> values;
    const Texture texture = gaussian_texture({.amplitude = 0.0002}, values);
    for (const Mode mode : {Mode::Direct, Mode::Proxy})
        for (const bool patch : {false, true}) {
            ZoneOptions o = patch ? with(Averaging::Patch) : exact;
            o.mode = mode;
            o.averaging = patch ? Averaging::Patch : Averaging::Stencil;
            Tool late(patch ? square(4) : stencil_points(o.smoothing), o),
                other(patch ? square(4) : stencil_points(o.smoothing), o);
            TouchedBody rough = frictionless(box());
            rough.material.texture = &texture;
            double most = 0, flat = 0;
            for (int i = 0; i < 400; ++i) {
                const Vec3d at{-0.02 + 1e-4 * i, 0, 0.029};
                late.input.degraded = i % 5 == 4;
                const double a = late.touch(rough, at).force.z, b = other.touch(rough, at).force.z;
                most = std::max(most, std::fabs(a - b));
                flat = std::max(flat, std::fabs(k * 0.001 - b));
            }
            EXPECT_GT(flat, patch ? 0.02 : 0.1) << "the relief is felt";
            EXPECT_LT(most, 0.02) << int(mode) << patch;
        }
}

TEST(Step, TextureIsFeltInTheSamePlaceTheSameWayAndNeverOutside)
{
    std::vector<float> values;
    const Texture texture = gaussian_texture({.amplitude = 0.0001}, values);
    Tool tool(square(3), exact);
    TouchedBody rough = frictionless(box()), smooth = rough;
    rough.material.texture = &texture;
    double least = 1e9, most = 0;
    for (int i = 0; i < 200; ++i) {
        const Vec3d at{-0.01 + 1e-4 * i, 0, 0.029};
        tool.state().reset();
        const Wrench first = tool.touch(rough, at);
        tool.state().reset();
        EXPECT_EQ(tool.touch(rough, at), first);
        tool.state().reset();
        EXPECT_LE(first.force.z, tool.touch(smooth, at).force.z);
        least = std::min(least, first.force.z), most = std::max(most, first.force.z);
    }
    EXPECT_GT(most - least, 0.02);
    EXPECT_EQ(tool.touch(rough, Vec3d{0, 0, 0.0301}), Wrench{});
}

}  // namespace
}  // namespace sqmap::haptic::test
