#include "sqmap/io/read_skin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>
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
    for (const float t : {1.f, 3.f}) put(t);                                                // 224: times
    for (const float q : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.70710678f, 0.70710678f}) put(q);  // 232: a quarter turn about z
    for (const float c : {0.f, 0.f, 0.f, 0.f, 1.f, 0.f, 2.f, 0.f, 0.f,                      // 264: tangents and places
                          -2.f, 0.f, 0.f, 0.f, 3.f, 0.f, 0.f, 0.f, 0.f})
        put(c);
    std::string json = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,3]}],
"nodes":[{"name":"root","children":[1]},{"translation":[0,0.25,0],"children":[2]},{"name":"tip","translation":[0,0.75,0]},{"mesh":0,"skin":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":1,"WEIGHTS_0":2}}]}],
"skins":[{"joints":[2,0],"inverseBindMatrices":3}],
"animations":[{"name":"bend","channels":[{"sampler":0,"target":{"node":0,"path":"rotation"}},{"sampler":1,"target":{"node":2,"path":"translation"}},
{"sampler":0,"target":{"node":3,"path":"rotation"}},{"sampler":0,"target":{"node":0,"path":"weights"}}],
"samplers":[{"input":4,"output":5},{"input":4,"output":6,"interpolation":"CUBICSPLINE"}]}],
"buffers":[{"byteLength":336}],
"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":12},{"buffer":0,"byteOffset":48,"byteLength":48},{"buffer":0,"byteOffset":96,"byteLength":128},
{"buffer":0,"byteOffset":224,"byteLength":8},{"buffer":0,"byteOffset":232,"byteLength":32},{"buffer":0,"byteOffset":264,"byteLength":72}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1,"componentType":5121,"count":3,"type":"VEC4"},
{"bufferView":2,"componentType":5126,"count":3,"type":"VEC4"},{"bufferView":3,"componentType":5126,"count":2,"type":"MAT4"},
{"bufferView":4,"componentType":5126,"count":2,"type":"SCALAR"},{"bufferView":5,"componentType":5126,"count":2,"type":"VEC4"},
{"bufferView":6,"componentType":5126,"count":6,"type":"VEC3"}]})";
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

TEST(ReadSkin, AnimationsTurnAndMoveJointsAsTheSpecificationHasIt)
{
    const SkinnedSoup s = read_skinned_file(skinned_file()).skin;
    ASSERT_EQ(s.animations.size(), 1u);
    const SkinAnimation& bend = s.animations[0];
    EXPECT_EQ(bend.name, "bend");
    EXPECT_EQ(bend.tracks.size(), 2u);
    EXPECT_EQ(bend.ignored, 2u);  // the mesh's own node, and weights
    EXPECT_EQ(bend.duration, 3);
    // Held before the first key and after the last; half a quarter turn in the middle.
    EXPECT_EQ(poses_at(s, bend, 0)[1].rotation[3], 1);
    EXPECT_NEAR(poses_at(s, bend, 9)[1].rotation[2], std::sqrt(0.5), 1e-7);
    EXPECT_NEAR(poses_at(s, bend, 2)[1].rotation[2], std::sin(0.125 * std::numbers::pi), 1e-7);
    // Hermite: half of each value, an eighth of two seconds times each tangent.
    const Vec3d middle = poses_at(s, bend, 2)[0].translation;
    EXPECT_NEAR(middle.x, 0.125 * 2 * (2 + 2), 1e-12);
    EXPECT_NEAR(middle.y, 0.5 * (1 + 3), 1e-12);
    // The joint that stands first is below the other: it goes round with it, through the node in between.
    const std::vector<Affine> maps = joint_maps(s, poses_at(s, bend, 9));
    const Vec3d tip = apply(maps[0], {0, 0, 0});  // its own place 3 up, the node's 0.25
    EXPECT_LT(norm(tip - Vec3d{-3.25, 0, 0}), 1e-6);
    const std::vector<Affine> rest = joint_maps(s, rest_poses(s));
    EXPECT_LT(norm(apply(rest[0], {0, 0, 0}) - s.skeleton[0].local.shift), 1e-12);
    const auto half = blended(rest_poses(s), poses_at(s, bend, 9), 0.5);
    EXPECT_NEAR(half[0].translation.y, 0.5 * (0.75 + 3), 1e-12);
    EXPECT_NEAR(half[1].rotation[2], std::sin(0.125 * std::numbers::pi), 1e-7);
}

TEST(ReadSkin, WhatIsWrongIsSaid)
{
    for (const auto& [replace, by] : {std::pair{R"("skin":0)", R"("note":0)"},
                                      {R"("joints":[2,0])", R"("joints":[2])"},
                                      {R"("joints":[2,0])", R"("joints":[9,0])"},
                                      {R"("JOINTS_0":1,)", ""},
                                      {R"("type":"MAT4")", R"("type":"VEC4")"},
                                      {R"("output":6)", R"("output":5)"},
                                      {R"("CUBICSPLINE")", R"("BEZIER")"},
                                      {R"("sampler":1,)", R"("sampler":7,)"},
                                      {R"("children":[1])", R"("children":[1,0])"}}) {
        const SkinResult read = read_skinned_file(skinned_file(replace, by));
        ASSERT_TRUE(read.error) << by;
        EXPECT_EQ(read.error->code, "E_FORMAT") << by;
    }
    EXPECT_TRUE(read_skinned_file("nowhere.glb").error);
    std::filesystem::remove(skinned_file());
}

}  // namespace
}  // namespace sqmap::io
