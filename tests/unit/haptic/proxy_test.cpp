#include "sqmap/haptic/step.h"

#include "haptic/stencil.h"
#include "sqmap/mesh/solid.h"
#include "touching.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::haptic::test {
namespace {

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

TEST(Step, AProxyKeepsToTheSideThatItCameFrom)
{
    // A leg of 6 mm: pressed in by 12 mm, a millimetre beside its middle, the nearest way out is on the far side.
    static const sqmap::test::Solid k_leg(mesh::ellipsoid({0.003, 0.05, 0.003}, 4));
    for (const double side_path : {0., 0.005}) {
        ZoneOptions o = with(Averaging::Ball);
        o.mode = Mode::Proxy;
        o.side_path = side_path;
        o.smoothing = ball_of(0.006);
        Tool tool(stencil_points(o.smoothing), o);
        Wrench w;
        for (double z = 0.012; z > -0.003; z -= 2e-4) w = tool.touch(frictionless(k_leg), Vec3d{0.001, 0, z});
        for (int i = 0; i < 300; ++i) w = tool.touch(frictionless(k_leg), Vec3d{0.001, 0, -0.003});
        const Vec3d at = tool.report().body.translation;
        if (side_path > 0) {
            EXPECT_NEAR(at.x, 0.001 + 0.012 / 9, 2e-4) << "above it along the normal of the first contact";
            EXPECT_GT(at.z, 0.007);
            EXPECT_NEAR(w.force.z, k * 0.012, 0.1 * k * 0.012);
        } else {
            EXPECT_LT(at.z, 0) << "without it, this leg is no test";
        }
        // The device moves across the leg and takes the proxy round it.
        for (double x = 0.001; x < 0.012; x += 1e-4) w = tool.touch(frictionless(k_leg), Vec3d{x, 0, -0.003});
        for (double z = -0.003; z < 0.02; z += 2e-4) w = tool.touch(frictionless(k_leg), Vec3d{0.012, 0, z});
        EXPECT_EQ(w, Wrench{});
    }
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

TEST(Step, AProxyRubsAsPrintedWhereChosen)
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
    double largest = 0;
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
        if (i > 20) largest = std::max(largest, off);
    }
    EXPECT_LT(largest, 5e-4);
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

TEST(Step, AProxyOfAMeshThatPressesLightlyGetsTheForceOfItsPoints)
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

}  // namespace
}  // namespace sqmap::haptic::test
