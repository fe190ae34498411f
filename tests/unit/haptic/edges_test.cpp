// A tool with triangles touches by its edges and faces: a knife on a ridge, between whose points there are none of the other.
#include "sqmap/haptic/tool.h"

#include "touching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sqmap::haptic {
namespace {

/// A wedge of 8 cm along x whose edge points downwards, through the origin.
mesh::Mesh knife()
{
    const double slope = 0.04 * std::tan(test::k_roof);
    mesh::Mesh m;
    for (const double x : {-0.04, 0.04}) {
        m.vertices.push_back({x, 0, 0});
        m.vertices.push_back({x, 0.04, slope});
        m.vertices.push_back({x, -0.04, slope});
    }
    m.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}};
    return m;
}

/// The knife as a tool on the ridge of a roof along y, whose top is at z = 0.
struct KnifeOnRidge {
    explicit KnifeOnRidge(ZoneOptions force, bool has_edges = true)
    {
        const mesh::Mesh m = knife();
        ToolDescription d{.force = force};
        take_surface(d, m.vertices, m.triangles, 0, false);
        if (has_edges) d.triangles.assign(m.triangles.begin(), m.triangles.end());
        tool = Tool(std::move(d));
        state.emplace(tool.state());
    }
    Wrench at(Vec3d position, double turn = 0)
    {
        const TouchedBody body{.model = &roof.view, .material = {.friction = Friction::None}, .surface = &roof.probe};
        const Pose pose{test::rotation_about({0, 0, 1}, turn), position};
        Wrench w;
        result = step(*state, {.touched = {&body, 1}, .poses = {&pose, 1}}, {&w, 1});
        return w;
    }
    const sqmap::test::Solid& roof = test::roof(1);
    Tool tool;
    std::optional<State> state;
    StepResult result{};
};

TEST(Edges, AKnifeOnARidgePushesByItsDepthWhereNoPointTouches)
{
    KnifeOnRidge with(test::exact), without(test::exact, false);
    for (const double depth : {0.0005, 0.001, 0.003}) {
        const Wrench w = with.at({0.001, 0.002, -depth});
        EXPECT_NEAR(norm(w.force - Vec3d{0, 0, test::k * depth}), 0, 1e-5 * test::k * depth) << depth;
        EXPECT_EQ(with.result.contacts, 1u);
        // The spring is where the edges cross, on the ridge and on the knife.
        EXPECT_NEAR(w.torque.x, 0, 1e-6) << "the pose is above the knife's edge";
        EXPECT_NEAR(w.torque.y, test::k * depth * 0.001, 1e-6);
        EXPECT_EQ(norm(without.at({0.001, 0.002, -depth}).force), 0);
    }
    EXPECT_EQ(norm(with.at({0, 0, 1e-6}).force), 0);
}

TEST(Edges, AKnifeSlidesAndTurnsOnARidgeWithoutAJump)
{
    for (const query::Layer layer : {query::Layer::Three, query::Layer::Exact}) {
        ZoneOptions force = test::exact;
        force.layer = layer;
        KnifeOnRidge knife(force);
        const double step = 0.00005, depth = 0.001;
        Vec3d before = knife.at({-0.02, -0.02, -depth}).force;
        for (int i = 1; i < 800; ++i) {
            const Vec3d now = knife.at({-0.02 + i * step, -0.02 + 0.7 * i * step, -depth}, 0.0005 * i).force;
            EXPECT_LE(norm(now - before), 3 * test::k * 1.3 * step) << i;
            EXPECT_NEAR(now.z, test::k * depth, 0.01 * test::k * depth) << i;
            before = now;
        }
    }
}

TEST(Edges, AProxyStaysOnARidge)
{
    ZoneOptions force = test::exact;
    force.mode = Mode::Proxy;
    force.proxy_depth = 0.001;
    KnifeOnRidge knife(force);
    Wrench w;
    for (int i = 0; i <= 100; ++i) w = knife.at({0, 0, 0.002 - 0.0001 * i});
    EXPECT_GT(w.force.z, 0.8 * test::k * 0.008);
    EXPECT_GT(knife.state->report(0).body.translation.z, -0.0015);
}

TEST(Edges, TheSameBitsTwice)
{
    KnifeOnRidge a(test::exact), b(test::exact);
    for (int i = 0; i < 50; ++i) {
        const Vec3d position{0.0001 * i, 0.0002 * i, -0.00002 * i};
        EXPECT_EQ(a.at(position, 0.01 * i), b.at(position, 0.01 * i));
    }
}

}  // namespace
}  // namespace sqmap::haptic
