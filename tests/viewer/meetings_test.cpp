// Compares the contacts that the page shows between objects with closed forms of bars, and with exact distances.
#include "viewer/server/scene/meetings.h"

#include "sqmap/query/distance.h"
#include "viewer/objects.h"
#include "viewer/server/touch/forces.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

constexpr double k_ridge_bar_size = 0.2;  ///< m, R_max of a bar

/// A bar of 6 x 1 x 1 along z or x, one of whose long edges is its ridge, y upwards.
std::shared_ptr<Object> ridge_bar(bool along_x)
{
    AdmittedMesh loaded;
    loaded.admission = mesh::Admission::Accept;
    loaded.solid = true;
    for (const auto& [p, q, r, s] : std::array<std::array<std::uint32_t, 4>, 6>{
             {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}}}) {
        loaded.mesh.triangles.push_back({p, q, r});
        loaded.mesh.triangles.push_back({p, r, s});
    }
    for (int i = 0; i < 8; ++i) {
        const double x = (i >> 2) - 0.5, y = ((i >> 1) & 1) - 0.5, z = (i & 1) - 0.5;
        const double across = (x - y) / std::numbers::sqrt2, up = (x + y) / std::numbers::sqrt2;
        loaded.mesh.vertices.push_back(along_x ? Vec3d{6 * z, up, -across} : Vec3d{across, up, 6 * z});
    }
    return object_from_mesh(loaded, "bar", k_ridge_bar_size, {});
}

ObjectPtr moved_to(const Object& object, Vec3d position)
{
    auto copy = std::make_shared<Object>(object);
    copy->put_at(object.metres_per_unit, position);
    return copy;
}

Vec3d witness_of(const ordered_json& contact, std::size_t first)
{
    return {contact[first], contact[first + 1], contact[first + 2]};
}

TEST(Meetings, RidgesThatCrossHaveOneContactEdgeOnEdge)
{
    const double unit = k_ridge_bar_size / std::sqrt(38.), height = unit * std::numbers::sqrt2, depth = 0.002;
    const ObjectPtr lower = moved_to(*ridge_bar(false), {0, 0, 0}),
                    upper = moved_to(*ridge_bar(true), {0.01, height - depth, 0.02});
    const std::vector<ObjectPtr> objects{lower, nullptr, upper};
    const ordered_json json = meetings_json(objects);
    ASSERT_EQ(json["pairs"].size(), 1u) << json;
    const ordered_json& pair = json["pairs"][0];
    EXPECT_EQ(pair["a"], 0);
    EXPECT_EQ(pair["b"], 2);
    ASSERT_EQ(pair["contacts"].size(), 1u) << pair;
    const ordered_json& contact = pair["contacts"][0];
    EXPECT_EQ(contact[0], 1) << "edge across edge";
    EXPECT_EQ(contact[1], 0) << "region";
    EXPECT_NEAR(contact[8].get<double>(), depth, 1e-7);
    EXPECT_NEAR(norm(witness_of(contact, 2) - Vec3d{0, height / 2, 0.02}), 0, 1e-7);
    EXPECT_NEAR(norm(witness_of(contact, 5) - Vec3d{0, height / 2 - depth, 0.02}), 0, 1e-7);
}

TEST(Meetings, OfObjectsApartOrHiddenThereAreNone)
{
    const ObjectPtr first = moved_to(*dumbbell(), {0, 0, 0}), second = moved_to(*dumbbell(), {0.5, 0, 0}),
                    within = moved_to(*dumbbell(), {0.01, 0, 0});
    EXPECT_TRUE(meetings_json(std::vector<ObjectPtr>{first, second})["pairs"].empty());
    EXPECT_TRUE(meetings_json(std::vector<ObjectPtr>{first, nullptr})["pairs"].empty());
    EXPECT_EQ(meetings_json(std::vector<ObjectPtr>{first, within})["pairs"].size(), 1u);
}

TEST(Meetings, JoinPointsOfBothSurfaces)
{
    const ObjectPtr first = moved_to(*dumbbell(), {0, 0, 0}), second = moved_to(*dumbbell(), {0.03, 0.004, 0.005});
    const ordered_json json = meetings_json(std::vector<ObjectPtr>{first, second});
    ASSERT_EQ(json["pairs"].size(), 1u);
    const ordered_json& contacts = json["pairs"][0]["contacts"];
    ASSERT_GT(contacts.size(), 10u);
    for (const ordered_json& c : contacts) {
        const Vec3d on_a = witness_of(c, 2), on_b = witness_of(c, 5);
        EXPECT_NEAR(norm(on_a - on_b), c[8].get<double>(), 1e-7);
        EXPECT_GE(c[1], 0) << "a region";
        for (const auto& [object, point] : {std::pair{first, on_a}, {second, on_b}})
            EXPECT_NEAR(object->metres_per_unit * query::exact_distance(object->view, object->mesh_units(point)).distance, 0,
                        2e-7)
                << c;
    }
}

TEST(Meetings, AToolWithEdgesIsFeltWhereRidgesCross)
{
    const double unit = k_ridge_bar_size / std::sqrt(38.), height = unit * std::numbers::sqrt2, depth = 0.001;
    const std::vector<ObjectPtr> objects{moved_to(*ridge_bar(false), {}), moved_to(*ridge_bar(true), {0.5, 0, 0})};
    Settings settings;
    settings.tool = ToolKind::Mesh;
    settings.tool_object = 1;
    settings.tool_size = 6 * unit;
    settings.stiffness = 400;
    settings.proxy = false;
    settings.law = Friction::None;
    const auto force_of = [&](bool has_edges) {
        settings.edges = has_edges;
        Forces forces(objects, settings);
        haptic::Wrench wrench;
        (void)forces.step({.pose = {{}, {0.01, height - depth, 0.02}}, .dt = 0.001}, wrench);
        return wrench.force;
    };
    EXPECT_EQ(norm(force_of(false)), 0) << "no point touches";
    EXPECT_NEAR(norm(force_of(true) - Vec3d{0, settings.stiffness * depth, 0}), 0, 1e-4);
}

}  // namespace
}  // namespace sqmap::viewer
