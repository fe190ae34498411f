// Compares what the page shows of one point and of both projections with closed forms of a ball, and what another bake keeps.
#include "viewer/server/scene/inspect.h"

#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/model.h"
#include "viewer/objects.h"
#include "viewer/server/scene/edits.h"
#include "viewer/server/scene/facts.h"
#include "viewer/server/scene/fields.h"
#include "viewer/server/scene/geometry.h"
#include "viewer/server/scene/load.h"
#include "viewer/server/touch/feet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>
#include <span>
#include <sstream>

namespace sqmap::viewer {
namespace {

using nlohmann::ordered_json;

constexpr double k_radius = 0.1;  // m, of the ball in the world

std::shared_ptr<Object> baked(const mesh::Mesh& mesh, bool is_paper)
{
    AdmittedMesh loaded;
    loaded.admission = mesh::Admission::Accept;
    loaded.solid = true;
    loaded.mesh = mesh;
    BakeMeshOptions options;
    if (is_paper) options.paper_maps.emplace();
    return object_from_mesh(loaded, "ball", 2 * k_radius, options);
}
const Object& central_ball()
{
    static const auto object = baked(mesh::sphere(1, 4), false);
    return *object;
}
const Object& normal_ball()
{
    static const auto object = baked(mesh::sphere(1, 4), true);
    return *object;
}

Vec3d point_at(const std::string& bytes, std::size_t offset)
{
    return {static_cast<double>(at<float>(bytes, offset)), static_cast<double>(at<float>(bytes, offset + 4)),
            static_cast<double>(at<float>(bytes, offset + 8))};
}

const Vec3d k_directions[] = {{1, 0, 0}, {0.3, 0.5, 0.8}, {-0.6, 0.64, -0.48}, {0.1, -0.99, 0.1}, {-0.7, -0.1, 0.7}};

TEST(Feet, LieOnThePixelThatShowsTheSurfaceThere)
{
    for (const Object* object : {&central_ball(), &normal_ball()})
        for (const Vec3d& direction : k_directions) {
            const Vec3d p = object->position + 0.95 * k_radius * normalized(direction);
            for (std::uint32_t part = 0; part < object->view.parts.size(); ++part) {
                const std::string map = map_bytes(*object, part, 48);
                const auto width = at<std::uint32_t>(map, 4), height = at<std::uint32_t>(map, 8);
                const std::optional<Foot> foot = foot_of(*object, part, p);
                ASSERT_TRUE(foot);
                ASSERT_TRUE(foot->x >= 0 && foot->x < 1 && foot->y >= 0 && foot->y < 1);
                const auto column = static_cast<std::size_t>(foot->x * static_cast<float>(width)),
                           row = static_cast<std::size_t>(foot->y * static_cast<float>(height));
                const std::size_t pixel = 12 + 16 * (row * width + column);
                if (at<float>(map, pixel) < 0) continue;  // the surface there is another part's
                const Vec3d shown = normalized(point_at(map, pixel + 4) - object->position);
                // Half the diagonal of a pixel; those in the middle of a cube's face are the largest, 4 / pi of the mean.
                const double pixel_angle = 2 * std::numbers::pi / static_cast<double>(width);
                EXPECT_GT(dot(shown, normalized(direction)), std::cos(pixel_angle)) << part << ' ' << width;
            }
        }
}

TEST(Feet, OfATouchAreItsContactsAndNoMoreThanTheirLimit)
{
    const ObjectPtr object(&normal_ball(), [](const Object*) {});
    const Settings settings;
    const Forces forces({object}, settings);
    const double depth = 0.003;
    const Vec3d tool = object->position + Vec3d{0, 0, k_radius + settings.tool_radius - depth};
    const std::vector<Foot> feet = feet_of(forces, {{}, tool}, 0, query::Layer::Three);
    ASSERT_FALSE(feet.empty());
    EXPECT_LE(feet.size(), k_max_feet);
    float deepest = 0;
    for (const Foot& foot : feet) deepest = std::max(deepest, foot.depth);
    EXPECT_NEAR(static_cast<double>(deepest), depth, 3e-4);
    EXPECT_TRUE(feet_of(forces, {{}, tool + Vec3d{0, 0, 0.05}}, 0, query::Layer::Three).empty());
}

TEST(Slice, HasTheSignedDistanceOnBothSides)
{
    const Object& object = central_ball();
    const std::string slice = slice_bytes(object, 1, object.position + Vec3d{0, 0.02, 0});
    const auto side = at<std::uint32_t>(slice, 4);
    ASSERT_EQ(slice.size(), 44 + 4 * std::size_t{side} * side);
    const Vec3d corner = point_at(slice, 8), along = point_at(slice, 20), up = point_at(slice, 32);
    int inside = 0;
    for (std::size_t i = 0; i < std::size_t{side} * side; i += 7) {
        const double x = static_cast<double>(i % side) / (side - 1), y = static_cast<double>(i / side) / (side - 1);
        const double wanted = norm(corner + x * along + y * up - object.position) - k_radius;
        EXPECT_NEAR(static_cast<double>(at<float>(slice, 44 + 4 * i)), wanted, 0.01 * k_radius) << i;
        inside += wanted < 0 ? 1 : 0;
    }
    EXPECT_GT(inside, 100);
    EXPECT_NEAR(corner.y, object.position.y + 0.02, 1e-6);
}

TEST(Answers, OfBothProjectionsAreTheBallsOwn)
{
    const double depth = 0.01;
    for (const Object* object : {&central_ball(), &normal_ball()}) {
        const Vec3d out = normalized(k_directions[1]);
        const ordered_json inside = answers_json(*object, object->position + (k_radius - depth) * out);
        ASSERT_EQ(inside["layers"].size(), 4u);
        for (const ordered_json& layer : inside["layers"]) {
            EXPECT_TRUE(layer["contact"]) << layer;
            if (layer["layer"] == "1") continue;  // the superquadric's own depth
            EXPECT_NEAR(layer["depth"].get<double>(), depth, 5e-4) << layer;
            const Vec3d normal{layer["normal"][0], layer["normal"][1], layer["normal"][2]};
            EXPECT_GT(dot(normal, out), 0.99) << layer;
        }
        const ordered_json outside = answers_json(*object, object->position + 1.5 * k_radius * out);
        for (const ordered_json& layer : outside["layers"]) EXPECT_FALSE(layer["contact"]) << layer;
    }
    EXPECT_EQ(answers_json(central_ball(), {})["projection"], "central");
    EXPECT_EQ(answers_json(normal_ball(), {})["projection"], "normal");
}

TEST(Search, EndsAtTheFootThatTheMapIsAskedAt)
{
    const Object& o = normal_ball();
    const Vec3d p = o.position + 0.9 * k_radius * normalized(k_directions[2]);
    for (std::uint32_t part = 0; part < o.view.parts.size(); ++part) {
        const ordered_json found = search_json(o, part, p);
        if (!found["held"]) continue;
        ASSERT_EQ(found["searches"].size(), 3u);
        for (const ordered_json& search : found["searches"]) {
            ordered_json last;
            for (const ordered_json& step : search["steps"]) {
                // Distances are those of the points that are drawn.
                const Vec3d on{step[2], step[3], step[4]};
                EXPECT_NEAR(norm(on - p), step[5].get<double>(), 1e-6);
                if (step[8] == 1) last = step;
            }
            ASSERT_FALSE(last.is_null());
            EXPECT_NEAR(last[5].get<double>(), search["footDistance"].get<double>(), 1e-7) << search["projector"];
            if (search["projector"] == "newton") {
                EXPECT_GT(last[6].get<double>(), 0.9999);
                EXPECT_LT(search["steps"].size(), 20u);
            }
            EXPECT_TRUE(search["contact"]);
        }
    }
    EXPECT_FALSE(search_json(o, 0, o.position + Vec3d{1, 0, 0})["held"]);
}

TEST(Section, ShowsFAndTheCutSurfaceInItsPlane)
{
    const Object& o = central_ball();
    const Vec3d through = o.position + Vec3d{0.02, 0.01, -0.03};
    for (int axis = 0; axis < 3; ++axis) {
        const std::string bytes = section_bytes(o, o.parts, {0, axis, through});
        const std::size_t side = at<std::uint32_t>(bytes, 4), cuts = at<std::uint32_t>(bytes, 8);
        ASSERT_EQ(bytes.size(), 48 + 8 * side * side + 20 * cuts);
        const Vec3d corner = point_at(bytes, 12), along = point_at(bytes, 24), up = point_at(bytes, 36);
        EXPECT_NEAR(dot(through - corner, normalized(cross(along, up))), 0, 1e-6) << "the plane holds the point";
        for (std::size_t y = 0; y < side; y += 13)
            for (std::size_t x = 0; x < side; x += 13) {
                const Vec3d p = corner + static_cast<double>(x) / static_cast<double>(side - 1) * along +
                                static_cast<double>(y) / static_cast<double>(side - 1) * up;
                const double f = shape::implicit(o.parts.superquadrics[0], cast<double>(o.model_space(p)));
                EXPECT_NEAR(static_cast<double>(at<float>(bytes, 48 + 4 * (y * side + x))), f, 1e-3 * (1 + f));
            }
        ASSERT_GT(cuts, 20u);
        for (std::size_t i = 0; i < cuts; ++i) {
            const std::size_t from = 48 + 8 * side * side + 20 * i;
            const Vec3d p = corner + static_cast<double>(at<float>(bytes, from + 4)) * along +
                            static_cast<double>(at<float>(bytes, from + 8)) * up;
            EXPECT_NEAR(norm(p - o.position), k_radius, 4e-4);  // facets lie a little inside
        }
    }
}

TEST(Difference, OfTwoModelsOfOneBallIsTheirErrors)
{
    ASSERT_TRUE(are_of_one_mesh(central_ball(), normal_ball()));
    const std::string bytes = difference_bytes(central_ball(), normal_ball());
    ASSERT_EQ(bytes.size(), 8 + 4 * central_ball().mesh.triangles.size());
    for (std::size_t t = 0; t < central_ball().mesh.triangles.size(); ++t) {
        const float d = at<float>(bytes, 8 + 4 * t);
        EXPECT_TRUE(d >= 0 && d < 1) << d;
    }
}

/// A torus with a hole in it, as a file that the gate closes.
AdmittedMesh holed_torus()
{
    const mesh::Mesh torus = mesh::torus({.major_segments = 32, .minor_segments = 12});
    constexpr std::size_t k_missing = 6;
    std::ostringstream off;
    off << "OFF\n" << torus.vertices.size() << ' ' << torus.triangles.size() - k_missing << " 0\n";
    for (const Vec3d& v : torus.vertices) off << v.x << ' ' << v.y << ' ' << v.z << '\n';
    for (std::size_t t = k_missing; t < torus.triangles.size(); ++t)
        off << "3 " << torus.triangles[t][0] << ' ' << torus.triangles[t][1] << ' ' << torus.triangles[t][2] << '\n';
    const std::string text = off.str();
    return admit_mesh(MeshBytes{std::as_bytes(std::span(text)), "holed.off"});
}

TEST(MadeUp, IsShownAndKeptByAnotherBakeOfEitherProjection)
{
    const AdmittedMesh loaded = holed_torus();
    ASSERT_EQ(loaded.admission, mesh::Admission::Closed);
    const auto object = object_from_mesh(loaded, "holed.off", 0.2, {});
    const std::vector<std::uint8_t> made_up = made_up_triangles(*object);
    const auto count = std::accumulate(made_up.begin(), made_up.end(), 0);
    ASSERT_GT(count, 0);
    const std::string field = field_bytes(*object, Field::MadeUp);
    for (std::size_t t = 0; t < made_up.size(); ++t) EXPECT_EQ(at<float>(field, 8 + 4 * t), static_cast<float>(made_up[t]));
    const ordered_json facts = facts_json(*object, object->parts, false);
    EXPECT_EQ(facts["cure"]["rung"], "CLOSED");

    for (const bool is_paper : {false, true}) {
        BakeMeshOptions options;
        if (is_paper) options.paper_maps.emplace();
        const auto after = rebaked(*object, object->parts, options, {});
        EXPECT_EQ(paper::is_paper(after->view), is_paper);
        EXPECT_EQ(made_up_triangles(*after), made_up);
        EXPECT_EQ(facts_json(*after, after->parts, false)["cure"], facts["cure"]);
        EXPECT_TRUE(are_of_one_mesh(*object, *after));
    }
}

TEST(Edits, AreBakedWithWhatTheObjectWasBakedWith)
{
    BakeMeshOptions coarse;
    coarse.bake.target_error = 20;
    const auto object = object_from_mesh(holed_torus(), "holed.off", 0.2, coarse);
    Object of_a_model = *object;
    of_a_model.baked_with.reset();
    const auto kept = rebaked(*object, object->parts, {}, {}), plain = rebaked(of_a_model, object->parts, {}, {});
    ASSERT_TRUE(kept->baked_with);
    EXPECT_EQ(kept->baked_with->target_error, 20);
    EXPECT_LT(kept->file->size(), plain->file->size());
}

TEST(Forces, EquationThirtyThreeIsAddedAgainstTheMotion)
{
    // The same two ticks with and without it: what differs is f_c (1 + k_f depth), however hard the tool is pressed.
    const ObjectPtr object(&central_ball(), [](const Object*) {});
    const double depth = 0.002, f_c = 0.15, k_f = 120;
    const auto second_force = [&](Friction law) {
        Settings settings{.damping = 0, .law = law, .f_c = f_c, .k_f = k_f};
        Forces forces({object}, settings);
        const Vec3d start = object->position + Vec3d{0, 0, k_radius + settings.tool_radius - depth};
        haptic::Wrench wrench;
        forces.step({.pose = {{}, start}, .dt = 0.001}, wrench);
        forces.step({.pose = {{}, start + Vec3d{1e-5, 0, 0}}, .dt = 0.001}, wrench);
        return wrench.force;
    };
    const Vec3d friction = second_force(Friction::Paper) - second_force(Friction::None);
    EXPECT_NEAR(norm(friction), f_c * (1 + k_f * depth), 0.02 * f_c);
    EXPECT_LT(friction.x, -0.99 * norm(friction));
}

TEST(Forces, ThePapersForceIsOfItsOwnMapsAlone)
{
    const ObjectPtr normal(&normal_ball(), [](const Object*) {}), central(&central_ball(), [](const Object*) {});
    const std::vector<ObjectPtr> all{normal}, mixed{normal, central};
    EXPECT_TRUE(has_paper_force(all));
    EXPECT_FALSE(has_paper_force(mixed));
    const Settings settings{.paper_force = true, .damping = 0, .law = Friction::None};
    Forces forces(all, settings);
    const double depth = 0.003;
    haptic::Wrench wrench;
    const sqmap::Pose pose{{}, normal->position + Vec3d{0, 0, k_radius + settings.tool_radius - depth}};
    forces.step({.pose = pose, .dt = 0.001}, wrench);
    // The mean of the springs of the points that touch: less than that of the deepest, and outwards.
    EXPECT_GT(wrench.force.z, 0.2 * settings.stiffness * depth);
    EXPECT_LT(wrench.force.z, 1.05 * settings.stiffness * depth);
    EXPECT_GT(wrench.force.z, 0.99 * norm(wrench.force));
}

}  // namespace
}  // namespace sqmap::viewer
