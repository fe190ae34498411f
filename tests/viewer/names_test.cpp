#include "viewer/server/scene/names.h"

#include "sqmap/mesh/shapes.h"
#include "viewer/objects.h"
#include "viewer/server/protocol/text.h"
#include "viewer/server/scene/load.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

namespace sqmap::viewer {
namespace {

std::vector<std::string> names_with(const Words& words)
{
    const Object& o = *dumbbell();
    return part_names(o.mesh, o.dual, o.parts.partition, o.parts.superquadrics, words, o.frame());
}

/// The part that a place of the mesh belongs to.
std::uint32_t part_at(Vec3d position)
{
    const Object& o = *dumbbell();
    std::uint32_t best = 0;
    for (std::uint32_t t = 0; t < o.mesh.triangles.size(); ++t) {
        const auto gap = [&](std::uint32_t i) {
            return norm(o.frame().origin + o.frame().unit * mesh::triangle_centroid(o.mesh, i) - position);
        };
        if (gap(t) < gap(best)) best = t;
    }
    return o.parts.partition.part_of_triangle[best];
}

TEST(Names, APartIsCalledAfterTheLandmarkOnIt)
{
    const std::vector<std::string> names = names_with({.landmarks = {{"left hand", {0, 0, 2.8}}, {"right hand", {0, 0, -2.8}}}});
    EXPECT_EQ(names[part_at({0, 0, 2.8})], "left hand");
    EXPECT_EQ(names[part_at({0, 0, -2.8})], "right hand");
    // The bar holds none, and the words do not speak of the whole.
    EXPECT_NE(names[part_at({0.35, 0, 0})].find("part,"), std::string::npos);
}

TEST(Names, WholeWordsNameWhatLiesBetweenAfterTheNearest)
{
    const std::vector<std::string> names = names_with({.landmarks = {{"head", {0, 0, 2.8}}}, .whole = true});
    for (const std::string& name : names) EXPECT_EQ(name.rfind("head", 0), 0u) << name;
    EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
}

TEST(Names, PartsOfOneNameAreToldApartAlongTheObjectsOwnAxes)
{
    Words words{.landmarks = {{"ball", {0, 0, 2.8}}, {"ball", {0, 0, -2.8}}}, .forward = {0, 0, 1}};
    EXPECT_EQ(names_with(words)[part_at({0, 0, 2.8})], "ball, the front one");
    words.forward = {0, 0, -1};
    EXPECT_EQ(names_with(words)[part_at({0, 0, 2.8})], "ball, the back one");
    words.up = {0, 0, 1};
    words.forward = {1, 0, 0};
    EXPECT_EQ(names_with(words)[part_at({0, 0, 2.8})], "ball, the upper one");
    words.up = {0, 1, 0};  // left is up x forward: -z
    EXPECT_EQ(names_with(words)[part_at({0, 0, 2.8})], "ball, the right one");
}

TEST(Names, RenamingReplacesWhatWasThereAndAnEmptyNameTakesItAway)
{
    const Object& o = *dumbbell();
    const std::uint32_t part = part_at({0, 0, 2.8});
    const Words one = renamed({}, o.mesh, o.parts.partition, part, "head", o.frame());
    const Words two = renamed(one, o.mesh, o.parts.partition, part, "skull", o.frame());
    ASSERT_EQ(two.landmarks.size(), 1u);
    EXPECT_EQ(names_with(two)[part], "skull");
    EXPECT_TRUE(renamed(two, o.mesh, o.parts.partition, part, "", o.frame()).landmarks.empty());
}

TEST(Names, ComeBackFromTheirFile)
{
    const Words words{.landmarks = {{"a \"b\" \xc3\xa9", {1, -2.5, 1e-9}}}, .whole = true, .forward = {1, 0, 0}, .up = {0, 0, 1}};
    const std::optional<Words> back = read_names(names_json(words).dump());
    ASSERT_TRUE(back);
    EXPECT_EQ(back->landmarks[0].name, words.landmarks[0].name);
    EXPECT_EQ(back->landmarks[0].at, words.landmarks[0].at);
    EXPECT_TRUE(back->whole);
    EXPECT_EQ(back->forward, words.forward);
    EXPECT_EQ(back->up, words.up);
}

TEST(Names, AreReadFromBesideTheModel)
{
    const auto folder = std::filesystem::path(testing::TempDir()) / "sqmap names";
    std::filesystem::create_directories(folder);
    EXPECT_EQ(names_file_of(folder / "cow.sqmap"), folder / "cow.names.json");
    std::ofstream(folder / "cow.names.json") << names_json({.landmarks = {{"horn", {0, 0, 2.8}}}});
    const Words words = words_beside(folder / "cow.sqmap");
    const auto object = object_from_model(*dumbbell()->file, "cow.sqmap", 0.2, words);
    EXPECT_EQ(object->parts.names[part_at({0, 0, 2.8})], "horn");
    EXPECT_TRUE(words_beside(folder / "pig.sqmap").landmarks.empty());
    std::filesystem::remove_all(folder);
}

TEST(Names, RefusesWhatIsNoFileOfNames)
{
    for (const char* const text :
         {"", "[]", "{}", R"({"names":3})", R"({"names":[{"name":"x"}]})", R"({"names":[{"name":"x","at":[1,2]}]})",
          R"({"names":[{"name":"","at":[1,2,3]}]})", R"({"names":[{"name":"x\u0007","at":[1,2,3]}]})",
          R"({"names":[{"name":"x","at":[1,2,1e40]}]})", R"({"names":[],"whole":1})", R"({"names":[],"up":[0,0,0]})",
          R"({"names":[],"up":[0,0,1],"forward":[0,0,2]})"})
        EXPECT_FALSE(read_names(text)) << text;
    EXPECT_FALSE(read_names(R"({"names":)" + std::string(30000, '[') + std::string(30000, ']') + "}"));
    EXPECT_FALSE(is_name(std::string(k_max_name + 1, 'x')));
    std::string many = R"({"names":[)";
    for (int i = 0; i < 300; ++i) many += std::string(i > 0 ? "," : "") + R"({"name":"x","at":[0,0,0]})";
    EXPECT_FALSE(read_names(many + "]}"));
}

}  // namespace
}  // namespace sqmap::viewer
