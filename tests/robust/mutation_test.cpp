// Damaged files, thousands of them, from a fixed seed: whatever the bytes, there is an answer, and a mesh that is let
// through keeps the promises of mesh/mesh.h.
#include "sqmap/io/read.h"
#include "sqmap/mesh/admission.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace sqmap {
namespace {

struct Sample {
    std::string bytes;
    io::MeshFormat format;
};

/// An octahedron and a tetrahedron beside it, in the formats that differ most.
std::vector<Sample> samples()
{
    const std::vector<Vec3f> points{{1, 0, 0},  {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1},
                                    {0, 0, -1}, {4, 0, 0},  {5, 0, 0}, {4, 1, 0},  {4, 0, 1}};
    const std::vector<std::array<int, 3>> faces{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5},
                                                {3, 1, 5}, {0, 3, 5}, {6, 8, 7}, {6, 7, 9}, {7, 8, 9}, {6, 9, 8}};
    const auto raw = [](const auto& value) { return std::string(reinterpret_cast<const char*>(&value), sizeof value); };
    std::string off = "OFF\n10 12 0\n", obj, stl(80, ' '), ply_body, ply_strip, ply_text, stl_text = "solid s\n", gltf_body;
    stl += raw(std::uint32_t{12});
    for (const Vec3f& p : points) {
        const std::string text = std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
        off += text;
        obj += "v " + text;
        ply_body += raw(p);
        ply_text += text;
        gltf_body += raw(p);
    }
    const std::string ply_vertices = ply_body;
    for (const auto& f : faces) {
        ply_strip += raw(f) + raw(-1);
        ply_text += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + " 2 .5 .5 7\n";
        off += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + "\n";
        obj += "f " + std::to_string(f[0] + 1) + " " + std::to_string(f[1] + 1) + "/1 " + std::to_string(f[2] - 10) + "\n";
        ply_body += '\x03' + raw(f);
        stl += raw(Vec3f{});
        stl_text += "facet normal 0 0 0\nouter loop\n";
        for (const int i : f) {
            const Vec3f p = points[static_cast<std::size_t>(i)];
            stl += raw(p);
            stl_text += "vertex " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
            gltf_body += raw(static_cast<std::uint16_t>(i));
        }
        stl += std::string(2, '\0');
        stl_text += "endloop\nendfacet\n";
    }
    const std::string binary = "ply\nformat binary_little_endian 1.0\n", corners = "property list uchar int vertex_indices\n",
                      vertices = "element vertex 10\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string ply = binary + vertices + "element face 12\n" + corners + "end_header\n" + ply_body;
    const std::string strips =
        binary + vertices + "element tristrips 1\n" + corners + "end_header\n" + ply_vertices + '\x30' + ply_strip;
    // As MeshLab writes it: more in a line than the header declares.
    const std::string text = "ply\nformat ascii 1.0\n" + vertices + "element face 12\n" + corners +
                             "property list uchar float texcoord\nend_header\n" + ply_text;
    std::string json =
        R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0,"children":[1]},{"translation":[0,9,0],"mesh":0}],)"
        R"("scenes":[{"nodes":[0]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)"
        R"("buffers":[{"byteLength":192}],"bufferViews":[{"buffer":0,"byteLength":120},{"buffer":0,"byteOffset":120,"byteLength":72}],)"
        R"("accessors":[{"bufferView":0,"componentType":5126,"count":10,"type":"VEC3"},)"
        R"({"bufferView":1,"componentType":5123,"count":36,"type":"SCALAR"}]})";
    if (json.size() % 4 == 0) json += ' ';  // as some write it: without padding
    const std::string glb = "glTF" + raw(std::uint32_t{2}) +
                            raw(static_cast<std::uint32_t>(28 + json.size() + gltf_body.size())) +
                            raw(static_cast<std::uint32_t>(json.size())) + "JSON" + json +
                            raw(static_cast<std::uint32_t>(gltf_body.size())) + std::string("BIN\0", 4) + gltf_body;
    return {{off, io::MeshFormat::Off},
            {obj, io::MeshFormat::Obj},
            {stl, io::MeshFormat::Stl},
            {ply, io::MeshFormat::Ply},
            {strips, io::MeshFormat::Ply},
            {text, io::MeshFormat::Ply},
            {stl_text + "endsolid s\n", io::MeshFormat::Stl},
            {glb, io::MeshFormat::Glb}};
}

std::string damaged(std::string bytes, std::mt19937& random)
{
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    for (std::size_t n = 1 + below(4); n-- > 0 && !bytes.empty();) {
        const std::size_t at = below(bytes.size()), length = 1 + below(std::min<std::size_t>(16, bytes.size() - at));
        switch (below(7)) {
            case 0:
                bytes[at] = static_cast<char>(random());
                break;
            case 1:
                bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
                break;
            case 2:
                bytes.erase(at, length);
                break;
            case 3:
                bytes.insert(at, bytes.substr(below(bytes.size()), length));
                break;
            case 4:
                bytes.resize(at);
                break;
            case 5:
                bytes[at] = static_cast<char>('0' + below(10));
                break;
            default:
                std::memset(bytes.data() + at, below(2) == 0 ? 0xFF : 0, length);
        }
    }
    return bytes;
}

void expect_promises(const mesh::AdmitResult& result)
{
    const mesh::Mesh& m = result.mesh;
    std::vector<bool> used(m.vertices.size(), false);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance, faces;
    for (const mesh::Triangle& t : m.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            ASSERT_LT(t[k], m.vertices.size());
            ASSERT_NE(t[k], t[(k + 1) % 3]);
            used[t[k]] = true;
            const auto edge = std::minmax(t[k], t[(k + 1) % 3]);
            balance[edge] += t[k] < t[(k + 1) % 3] ? 1 : -1;
            ++faces[edge];
        }
    EXPECT_TRUE(std::all_of(used.begin(), used.end(), [](bool u) { return u; }));
    for (const Vec3d& p : m.vertices) EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    for (const auto& [edge, count] : faces) EXPECT_TRUE(count == 2 || (count == 1 && !result.solid));
    if (!result.solid) return;
    for (const auto& [edge, sum] : balance) EXPECT_EQ(sum, 0) << "neighbours disagree";
    EXPECT_GT(result.facts.volume, 0);
}

/// So many damaged files of each format.
void expect_answers(int files)
{
    std::mt19937 random(20230917);
    std::map<std::string, int> answers;
    for (const Sample& sample : samples())
        for (int i = 0; i < files; ++i) {
            const std::string bytes = i == 0 ? sample.bytes : damaged(sample.bytes, random);
            const io::ReadResult read = io::read_mesh_bytes(std::as_bytes(std::span(bytes)), sample.format);
            if (read.error) {
                EXPECT_NE(i, 0) << io::format_name(sample.format) << ": " << read.error->message;
                EXPECT_TRUE(read.error->code == "E_FORMAT" || read.error->code == "E_TRUNCATED" || read.error->code == "E_LIMIT");
                ++answers[read.error->code];
                continue;
            }
            const mesh::PolygonView polygons{read.soup.positions, read.soup.polygon_offsets, read.soup.indices};
            const mesh::AdmitOptions options{.repair = i % 2 == 0 ? mesh::Repair::Safe : mesh::Repair::Wrap,
                                             .accept_surface = i % 3 == 0,
                                             .thickness = i % 5 == 0 ? 0.1 : 0.0};
            const mesh::AdmitResult result = mesh::admit(polygons, options);
            if (result.admission == mesh::Admission::Refused) {
                EXPECT_NE(i, 0) << io::format_name(sample.format) << ": " << result.diagnosis.message;
                ++answers[mesh::name_of(result.diagnosis.code)];
                continue;
            }
            ++answers["taken"];
            expect_promises(result);
            if (testing::Test::HasFailure()) FAIL() << io::format_name(sample.format) << ", mutation " << i;
        }
    // The damage reaches every stage, or this test would say little.
    for (const char* code : {"E_FORMAT", "E_TRUNCATED", "E_INDEX", "E_NONFINITE", "E_RANGE", "E_OPEN", "E_NONMANIFOLD", "taken"})
        EXPECT_GT(answers[code], 0) << code;
}

TEST(Mutation, EveryDamagedFileGetsAnAnswer) { expect_answers(200); }

TEST(ManyMutations, GetAnAnswerEach) { expect_answers(10000); }

}  // namespace
}  // namespace sqmap
