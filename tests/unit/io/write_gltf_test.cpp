#include "sqmap/io/write_mesh.h"

#include "sqmap/io/read.h"
#include "support/bodies.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <unistd.h>

namespace sqmap::io {
namespace {

std::filesystem::path scratch(const char* name)
{
    return std::filesystem::temp_directory_path() / (std::string(name) + std::to_string(::getpid()) + ".glb");
}

MovingMesh triangle()
{
    MovingMesh m;
    m.name = "sail";
    m.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5}};
    m.triangles = {{0, 1, 2}};
    return m;
}

TEST(WriteGltf, AReaderGetsBackWhereBodiesStand)
{
    test::Random random(1);
    const auto path = scratch("stand");
    for (int i = 0; i < 40; ++i) {
        MovingMesh m = triangle();
        // Half turns too, where a quaternion's largest part is not the scalar one.
        const RigidKey key{test::rotation_about(random.direction(), i % 2 == 0 ? 3.14159 : random.between(0, 3)), {1, 2, 3}};
        m.times = {0, 1};
        m.keys = {key, key};
        write_glb(path, {&m, 1});
        const ReadResult read = read_mesh_file(path);
        ASSERT_FALSE(read.error) << read.error->message;
        ASSERT_EQ(read.soup.positions.size(), 3u);
        for (std::size_t v = 0; v < 3; ++v)
            EXPECT_LT(norm(read.soup.positions[v] - (key.rotation * m.positions[v] + key.translation)), 1e-5);
    }
    std::filesystem::remove(path);
}

TEST(WriteGltf, ShapesBecomeMorphTargetsOneATime)
{
    MovingMesh m = triangle();
    m.times = {0, 0.5, 1};
    m.shapes = {m.positions, m.positions, m.positions};
    m.shapes[2][2] = {0, 2, 0.5};
    const auto path = scratch("shapes");
    write_glb(path, {&m, 1});
    std::ifstream in(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    std::filesystem::remove(path);
    const auto word = [&](std::size_t at) {
        std::uint32_t v;
        std::memcpy(&v, &bytes[at], 4);
        return v;
    };
    EXPECT_EQ(word(8), bytes.size());
    const auto json = nlohmann::json::parse(&bytes[20], &bytes[20] + word(12));
    const auto& primitive = json["meshes"][0]["primitives"][0];
    ASSERT_EQ(primitive["targets"].size(), 2u);
    const auto& accessor = json["accessors"][primitive["targets"][1]["POSITION"].get<std::size_t>()];
    EXPECT_EQ(accessor["max"], nlohmann::json({0.0, 1.0, 0.0}));
    const std::size_t binary = 20 + word(12) + 8;
    const auto& sampler = json["animations"][0]["samplers"][0];
    const auto& view =
        json["bufferViews"][json["accessors"][sampler["output"].get<std::size_t>()]["bufferView"].get<std::size_t>()];
    float weights[6];
    std::memcpy(weights, &bytes[binary + view["byteOffset"].get<std::size_t>()], sizeof weights);
    const float expected[6] = {0, 0, 1, 0, 0, 1};
    for (int i = 0; i < 6; ++i) EXPECT_EQ(weights[i], expected[i]);
}

TEST(WriteGltf, WhatContradictsItselfIsRefusedAndNothingWritten)
{
    const auto path = scratch("bad");
    MovingMesh m = triangle();
    m.triangles[0][1] = 7;
    EXPECT_THROW(write_glb(path, {&m, 1}), std::invalid_argument);
    m = triangle();
    m.times = {1, 1};
    m.keys.resize(2);
    EXPECT_THROW(write_glb(path, {&m, 1}), std::invalid_argument);
    m = triangle();
    m.positions[0].x = NAN;
    EXPECT_THROW(write_glb(path, {&m, 1}), std::invalid_argument);
    EXPECT_THROW(write_glb(path, {}), std::invalid_argument);
    EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace sqmap::io
