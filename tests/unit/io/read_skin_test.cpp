#include "sqmap/io/read_skin.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <unistd.h>

namespace sqmap::io {
namespace {

/// A triangle on two joints, the second one unit above the first; joints and weights as the strings say.
std::filesystem::path skinned_file(const std::string& replace = {}, const std::string& by = {})
{
    std::string bytes;
    const auto put = [&bytes](auto value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
    for (const float f : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 2.f, 0.f}) put(f);                  // 0: places
    for (const int j : {0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0}) put(static_cast<std::uint8_t>(j));  // 36: joints
    for (const float w : {1.f, 0.f, 0.f, 0.f, .5f, .5f, 0.f, 0.f, 2.f, 0.f, 0.f, 0.f}) put(w);   // 48: weights
    for (const float y : {0.f, -1.f})                                                            // 96: inverse binds
        for (int i = 0; i < 16; ++i) put(i == 13 ? y : i % 5 == 0 ? 1.f : 0.f);
    std::string json = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,3]}],
"nodes":[{"name":"root","children":[1]},{"translation":[0,0.25,0],"children":[2]},{"name":"tip","translation":[0,0.75,0]},{"mesh":0,"skin":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}]}],
"skins":[{"joints":[2,0],"inverseBindMatrices":3}],
"buffers":[{"byteLength":224}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12},{"buffer":0,"byteOffset":48,"byteLength":48},{"buffer":0,"byteOffset":96,"byteLength":128}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"},
{"bufferView":2,"componentType":5126,"count":3,"type":"VEC4"},{"bufferView":3,"componentType":5126,"count":2,"type":"MAT4"}]})";
    if (!replace.empty()) json.replace(json.find(replace), replace.size(), by);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string file = "glTF";
    const auto word = [&file](std::size_t v) {
        const auto w = static_cast<std::uint32_t>(v);
        file.append(reinterpret_cast<const char*>(&w), 4);
    };
    word(2);
    word(12 + 8 + json.size() + 8 + bytes.size());
    word(json.size());
    file += "JSON" + json;
    word(bytes.size());
    file += std::string("BIN\0", 4) + bytes;
    const auto path = std::filesystem::temp_directory_path() / ("skin" + std::to_string(::getpid()) + ".glb");
    std::ofstream(path, std::ios::binary) << file;
    return path;
}

TEST(ReadSkin, JointsWeightsAndBindsComeAsTheFileHasThem)
{
    const SkinResult read = read_skinned_file(skinned_file());
    ASSERT_FALSE(read.error) << read.error->message;
    const SkinnedSoup& s = read.skin;
    ASSERT_EQ(s.skeleton.size(), 2u);
    EXPECT_EQ(s.skeleton[0].name, "tip");
    EXPECT_EQ(s.skeleton[0].parent, 1);  // through a node that is no joint
    EXPECT_EQ(s.skeleton[0].local.shift, (Vec3d{0, 1, 0}));
    EXPECT_EQ(s.skeleton[1].parent, -1);
    EXPECT_EQ(s.skeleton[1].inverse_bind.shift, (Vec3d{0, -1, 0}));
    ASSERT_EQ(s.soup.positions.size(), 3u);
    EXPECT_EQ(s.soup.positions[2], (Vec3d{0, 2, 0}));
    EXPECT_EQ(s.weights[1], (std::array<double, 4>{0.5, 0.5, 0, 0}));
    EXPECT_EQ(s.weights[2][0], 1);  // made to sum to 1
    EXPECT_EQ(s.joints[2][0], 1);
}

TEST(ReadSkin, WhatIsWrongIsSaid)
{
    for (const auto& [replace, by] : {std::pair{R"("skin":0)", R"("note":0)"},
                                      {R"("joints":[2,0])", R"("joints":[2])"},
                                      {R"("joints":[2,0])", R"("joints":[9,0])"},
                                      {R"("JOINTS_0":1,)", ""},
                                      {R"("type":"MAT4")", R"("type":"VEC4")"}}) {
        const SkinResult read = read_skinned_file(skinned_file(replace, by));
        ASSERT_TRUE(read.error) << by;
        EXPECT_EQ(read.error->code, "E_FORMAT") << by;
    }
    EXPECT_TRUE(read_skinned_file("nowhere.glb").error);
    std::filesystem::remove(skinned_file());
}

}  // namespace
}  // namespace sqmap::io
