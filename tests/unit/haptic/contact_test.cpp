#include "sqmap/haptic/step.h"

#include "haptic/stencil.h"
#include "sqmap/mesh/solid.h"
#include "touching.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::haptic::test {
namespace {

TEST(Step, APointOnFlatGroundGetsItsSpringAtAnyDepth)
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

TEST(Step, ABallOnFlatGroundGetsItsSpringAtAnyDepth)
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

TEST(Step, APointHasTheTrueDepthOnFacetsThatTurnMildly)
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

TEST(Step, NoForceOutside)
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

TEST(Step, APatchOnFlatGroundGetsItsSpringHoweverManyPoints)
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

TEST(Step, DenserProbesGetTheSameForce)
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

TEST(Step, WeightsMakeUnevenProbesGetTheSameForce)
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

TEST(Step, TheForceAtATipTurnsTheTool)
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

TEST(Step, AProbeInTheWorldTouchesWhereItsPointsAre)
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

TEST(Step, TouchedBodiesGetTheOppositeWrench)
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

TEST(Step, OnlyThePoseOfOneInTheOtherCounts)
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

TEST(Step, TwoBodiesPushTogether)
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

}  // namespace
}  // namespace sqmap::haptic::test
