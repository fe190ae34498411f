// Sessions of the C interface: ticks allocate nothing, a tick that fails leaves no force, modes place the tool.
#include "capi/allocations.h"
#include "capi/fixture.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace sqmap {
namespace {

using test::Capi;
using test::expect_refused;
using test::k_nan;

TEST_F(Capi, TicksAllocateNothing)
{
    points_[17].y = 0;
    const std::size_t n = points_.size();
    const sqmap_points in = points();
    std::vector<double> distance(n);
    std::vector<sqmap_contact> space(n);
    sqmap_probe probe{};
    sqmap_workspace workspace{};
    sqmap_session session{};
    ASSERT_EQ(sqmap_make_probe(&in, &probe), SQMAP_OK);
    ASSERT_EQ(sqmap_make_workspace(n, &workspace), SQMAP_OK);
    ASSERT_EQ(sqmap_make_session(model_, nullptr, &session), SQMAP_OK);
    const sqmap_bodies bodies{sizeof bodies, {model_, probe, nullptr}, {model_, probe, nullptr}};
    sqmap_distances distances{sizeof distances, distance.data(), nullptr, nullptr, nullptr, nullptr, nullptr, nullptr};
    sqmap_contacts contacts{};
    contacts.size = sizeof contacts;
    contacts.depth = distance.data();
    sqmap_contact_list list{};
    list.size = sizeof list;
    list.contacts = space.data();
    list.capacity = n;
    sqmap_pair_list pairs{};
    pairs.size = sizeof pairs;
    sqmap_tick tick{};
    tick.size = sizeof tick;
    tick.pose = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {1, 0, 0.2}};
    sqmap_force force{};
    force.size = sizeof force;
    const std::size_t before = test::allocations();
    bool ok = sqmap_query_points(model_, &in, nullptr, &contacts) == SQMAP_OK;
    ok = ok && sqmap_signed_distances(model_, &in, nullptr, &distances) == SQMAP_OK;
    ok = ok && sqmap_query_probe(&bodies, nullptr, &list) == SQMAP_OK;
    ok = ok && sqmap_query_pair(&bodies, nullptr, workspace, &pairs) == SQMAP_OK;
    for (tick.sequence = 1; tick.sequence < 20; ++tick.sequence) {
        tick.time = tick.sample_time += 0.001;
        ok = ok && sqmap_tick_session(session, &tick, &force) == SQMAP_OK;
    }
    EXPECT_EQ(test::allocations(), before);
    EXPECT_TRUE(ok);
    EXPECT_GT(list.found, 0u);
    EXPECT_GT(force.depth, 0);
    sqmap_close_session(session);
    sqmap_close_workspace(workspace);
    sqmap_close_probe(probe);
    const std::size_t again = test::allocations();
    ASSERT_EQ(sqmap_make_probe(&in, &probe), SQMAP_OK);
    EXPECT_GT(test::allocations(), again);  // the count sees the library
    sqmap_close_probe(probe);
}

TEST_F(Capi, ATickThatFailsLeavesNoForce)
{
    sqmap_session session{};
    ASSERT_EQ(sqmap_make_session(model_, nullptr, &session), SQMAP_OK) << sqmap_last_error()->message;
    sqmap_force force{};
    force.size = sizeof force;
    const auto expect_none = [&] {
        for (int i = 0; i < 3; ++i) {
            EXPECT_EQ(force.force[i], 0);
            EXPECT_EQ(force.torque[i], 0);
        }
    };
    force.force[1] = 7;
    expect_refused(sqmap_tick_session(session, nullptr, &force), SQMAP_E_ARGUMENT, "tick");
    expect_none();
    sqmap_tick tick{};
    tick.size = sizeof tick;
    for (const double bad : {k_nan, std::numeric_limits<double>::infinity(), 0.0}) {
        for (double& r : tick.pose.rotation) r = bad;  // zero is no rotation either
        ++tick.sequence;
        tick.time = tick.sample_time += 0.001;
        force.force[1] = 7;
        EXPECT_EQ(sqmap_tick_session(session, &tick, &force), SQMAP_OK);
        expect_none();
    }
    EXPECT_EQ(sqmap_close_session(session), SQMAP_OK);
    force.force[1] = 7;
    expect_refused(sqmap_tick_session(session, &tick, &force), SQMAP_E_HANDLE, "session");
    expect_none();
}

/// Sessions on the torus, whose tube is 2.5 cm thick here, touched from above.
class CapiModes : public Capi {
protected:
    static sqmap_session_options options_of(std::int32_t mode)
    {
        sqmap_session_options options{};
        options.size = sizeof options;
        options.metres_per_unit = 0.05;
        options.stiffness = 300;
        options.friction = -1;
        options.layer = SQMAP_LAYER_EXACT;
        options.side_path = 0.005;
        options.mode = mode;
        return options;
    }
    void make(const sqmap_session_options& options)
    {
        ASSERT_EQ(sqmap_make_session(model_, &options, &session_), SQMAP_OK) << sqmap_last_error()->message;
        tick_ = {};
        tick_.size = sizeof tick_;
        tick_.pose = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.05, 0, k_above}};
    }
    /// The last tick's result when the device has gone down to a height, m.
    sqmap_force pressed_to(double height)
    {
        sqmap_force force{};
        force.size = sizeof force;
        for (int i = 0; i < k_ticks; ++i) {
            ++tick_.sequence;
            tick_.time = tick_.sample_time += 0.001;
            tick_.pose.translation[2] += (height - tick_.pose.translation[2]) / (k_ticks - i);
            EXPECT_EQ(sqmap_tick_session(session_, &tick_, &force), SQMAP_OK);
        }
        return force;
    }

    static constexpr double k_above = 0.015, k_surface = 0.0125, k_in = 0.0095, k_through = -0.008;
    static constexpr int k_ticks = 400;
    sqmap_session session_{};
    sqmap_tick tick_{};
};

TEST_F(CapiModes, TheToolIsWhereTheModePutsIt)
{
    make(options_of(SQMAP_MODE_DIRECT));
    sqmap_force force = pressed_to(k_in);
    EXPECT_NEAR(force.tool.translation[2], k_in, 1e-12);
    EXPECT_GT(force.commanded[2], 0.5);
    EXPECT_LT(pressed_to(k_through).commanded[2], 0);  // out of the other side
    sqmap_close_session(session_);

    make(options_of(SQMAP_MODE_PROXY));
    for (const double height : {k_in, k_through}) {
        force = pressed_to(height);
        EXPECT_NEAR(force.tool.translation[2], k_surface, 2e-4);
        EXPECT_NEAR(force.commanded[2], 300 * (k_surface - height), 0.1);
        EXPECT_NEAR(force.depth, k_surface - height, 3e-4);
        EXPECT_GT(force.normal[2], 0.99);
    }
    sqmap_close_session(session_);

    make(options_of(SQMAP_MODE_COUPLED));
    force = pressed_to(k_in);
    EXPECT_GT(force.tool.translation[2], k_in + 1e-4);
    EXPECT_LT(force.tool.translation[2], k_surface);
    EXPECT_GT(force.commanded[2], 0.1);
    sqmap_close_session(session_);
}

TEST_F(CapiModes, AnOlderHeaderHasTheDirectOne)
{
    sqmap_session_options options = options_of(SQMAP_MODE_PROXY);
    options.size = offsetof(sqmap_session_options, side_path);
    make(options);
    EXPECT_NEAR(pressed_to(k_in).tool.translation[2], k_in, 1e-12);
    sqmap_close_session(session_);
}

TEST_F(CapiModes, ToolsOfTrianglesAreFeltWithTheirEdges)
{
    // A blade across the tube: its lower edge touches, far from its ends.
    const double vertices[] = {-0.03, 0, 0, 0.03, 0, 0, 0, -0.01, 0.02, 0, 0.01, 0.02};
    const std::int64_t triangles[] = {0, 1, 2, 1, 0, 3, 0, 2, 3, 1, 3, 2};
    const sqmap_mesh blade{sizeof(sqmap_mesh), vertices, 4, triangles, 4};
    sqmap_session_options options = options_of(SQMAP_MODE_DIRECT);
    ASSERT_EQ(sqmap_make_solid_probe(&blade, &options.tool), SQMAP_OK);
    make(options);
    EXPECT_GT(pressed_to(k_in).commanded[2], 0.1);
    sqmap_close_session(session_);

    options.without_edges = 1;
    make(options);
    EXPECT_EQ(pressed_to(k_in).commanded[2], 0);
    sqmap_close_session(session_);

    options.radius = 0.001;
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_ARGUMENT, "options.radius");
    options.radius = 0;
    sqmap_close_probe(options.tool);
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_HANDLE, "options.tool");
    const sqmap_points points{sizeof(sqmap_points), vertices, 4, nullptr};
    ASSERT_EQ(sqmap_make_probe(&points, &options.tool), SQMAP_OK);
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_MISSING, "options.tool");
    sqmap_close_probe(options.tool);
}

TEST_F(CapiModes, OthersAreRefused)
{
    sqmap_session_options options = options_of(7);
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_ARGUMENT, "options.mode");
    options = options_of(SQMAP_MODE_PROXY);
    options.side_path = -1;
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_ARGUMENT, "options.side_path");
}

}  // namespace
}  // namespace sqmap
