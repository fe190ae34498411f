#include "sqmap/io/read.h"

#include <unistd.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace sqmap::io {
namespace {

using namespace std::string_literals;

ReadResult read(const std::string& bytes, MeshFormat format, const ReadLimits& limits = {})
{
    return read_mesh_bytes(std::as_bytes(std::span(bytes)), format, limits);
}

std::string code(const std::string& bytes, MeshFormat format, const ReadLimits& limits = {})
{
    const ReadResult result = read(bytes, format, limits);
    if (result.error) {
        EXPECT_FALSE(result.error->element.empty());
        EXPECT_FALSE(result.error->message.empty());
        EXPECT_FALSE(result.error->cure.empty());
        EXPECT_TRUE(result.soup.positions.empty());
    }
    return result.error ? result.error->code : "";
}

template <class T>
std::string raw(T value, bool big_endian = false)
{
    std::string bytes(sizeof value, '\0');
    std::memcpy(bytes.data(), &value, sizeof value);
    if (big_endian) std::reverse(bytes.begin(), bytes.end());
    return bytes;
}

// A tetrahedron in every format.
const std::vector<Vec3d> k_points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<std::int64_t> k_corners{0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};

std::string off_text() { return "OFF # a comment\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"; }
std::string obj_text() { return "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"; }

std::string stl_text()
{
    std::string out = "solid tetrahedron\n";
    for (std::size_t f = 0; f < 4; ++f) {
        out += "facet normal 0 0 0\n outer loop\n";
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d p = k_points[static_cast<std::size_t>(k_corners[3 * f + k])];
            out += "  vertex " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z) + "\n";
        }
        out += " endloop\nendfacet\n";
    }
    return out + "endsolid tetrahedron\n";
}

std::string stl_binary(const std::string& start = "made by a test")
{
    std::string out = start;
    out.resize(80, '\0');
    out += raw(std::uint32_t{4});
    for (std::size_t f = 0; f < 4; ++f) {
        out += std::string(12, '\0');
        for (std::size_t k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i)
                out += raw(static_cast<float>(k_points[static_cast<std::size_t>(k_corners[3 * f + k])][i]));
        out += std::string(2, '\0');
    }
    return out;
}

std::string ply_header(const std::string& format, std::uint64_t vertices = 4, std::uint64_t faces = 4)
{
    return "ply\nformat " + format + " 1.0\ncomment made by a test\nelement vertex " + std::to_string(vertices) +
           "\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\nelement face " + std::to_string(faces) +
           "\nproperty list uchar int vertex_indices\nend_header\n";
}
std::string ply_text()
{
    return ply_header("ascii") + "0 0 0 9\n1 0 0 9\n0 1 0 9\n0 0 1 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
}
std::string ply_binary(bool big_endian)
{
    std::string out = ply_header(big_endian ? "binary_big_endian" : "binary_little_endian");
    for (const Vec3d& p : k_points)
        out +=
            raw(static_cast<float>(p.x), big_endian) + raw(static_cast<float>(p.y), big_endian) + raw(p.z, big_endian) + "\x09";
    for (std::size_t f = 0; f < 4; ++f) {
        out += '\x03';
        for (std::size_t k = 0; k < 3; ++k) out += raw(static_cast<std::int32_t>(k_corners[3 * f + k]), big_endian);
    }
    return out;
}

std::string gltf_buffer()
{
    std::string out;
    for (const Vec3d& p : k_points)
        for (int i = 0; i < 3; ++i) out += raw(static_cast<float>(p[i]));
    for (const std::int64_t i : k_corners) out += raw(static_cast<std::uint16_t>(i));
    return out;  // 48 + 24 bytes
}
/// buffer: the inside of the buffer's object; node: extra members of the node.
std::string gltf_json(const std::string& buffer, const std::string& node = "")
{
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0)" + node +
           R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{)" + buffer +
           R"(}],"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":24}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
           R"({"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}]})";
}
std::string base64(const std::string& bytes)
{
    const char* alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {  // 72 bytes: no padding
        const unsigned v = (static_cast<unsigned char>(bytes[i]) << 16) | (static_cast<unsigned char>(bytes[i + 1]) << 8) |
                           static_cast<unsigned char>(bytes[i + 2]);
        for (int shift = 18; shift >= 0; shift -= 6) out += alphabet[(v >> shift) & 63];
    }
    return out;
}
std::string gltf_text(const std::string& node = "")
{
    return gltf_json(R"("byteLength":72,"uri":"data:application/octet-stream;base64,)" + base64(gltf_buffer()) + "\"", node);
}
std::string glb(std::string json, const std::string& buffer)
{
    while (json.size() % 4 != 0) json += ' ';
    std::string out = "glTF" + raw(std::uint32_t{2}) + raw(static_cast<std::uint32_t>(28 + json.size() + buffer.size()));
    out += raw(static_cast<std::uint32_t>(json.size())) + "JSON" + json;
    return out + raw(static_cast<std::uint32_t>(buffer.size())) + "BIN\0"s + buffer;
}
std::string glb() { return glb(gltf_json(R"("byteLength":72)"), gltf_buffer()); }

struct Sample {
    std::string bytes;
    MeshFormat format;
};
std::vector<Sample> samples()
{
    return {{off_text(), MeshFormat::Off},       {obj_text(), MeshFormat::Obj},   {stl_text(), MeshFormat::Stl},
            {stl_binary(), MeshFormat::Stl},     {ply_text(), MeshFormat::Ply},   {ply_binary(false), MeshFormat::Ply},
            {ply_binary(true), MeshFormat::Ply}, {gltf_text(), MeshFormat::Gltf}, {glb(), MeshFormat::Glb}};
}

TEST(Read, EveryFormatGivesTheSameTetrahedron)
{
    for (const Sample& s : samples()) {
        const ReadResult result = read(s.bytes, s.format);
        ASSERT_FALSE(result.error) << format_name(s.format) << ": " << result.error->message;
        ASSERT_EQ(result.soup.polygon_offsets, (std::vector<std::uint32_t>{0, 3, 6, 9, 12})) << format_name(s.format);
        for (std::size_t i = 0; i < k_corners.size(); ++i)
            EXPECT_EQ(result.soup.positions[static_cast<std::size_t>(result.soup.indices[i])],
                      k_points[static_cast<std::size_t>(k_corners[i])])
                << format_name(s.format) << " corner " << i;
    }
}

TEST(Read, BinaryFilesCutAnywhereAreTruncated)
{
    for (const Sample& s : {Sample{ply_binary(false), MeshFormat::Ply}, Sample{ply_binary(true), MeshFormat::Ply},
                            Sample{stl_binary(), MeshFormat::Stl}, Sample{glb(), MeshFormat::Glb}})
        for (std::size_t size = s.format == MeshFormat::Stl ? 15 : 4; size < s.bytes.size(); ++size)
            EXPECT_EQ(code(s.bytes.substr(0, size), s.format), "E_TRUNCATED") << format_name(s.format) << " cut at " << size;
}

TEST(Read, TextFilesThatDeclareTheirSizeAreTruncatedAtEveryCutButTheLastToken)
{
    // A cut within the last number, or of the last line end, leaves a file that is complete as far as anyone can tell.
    for (const Sample& s : {Sample{off_text(), MeshFormat::Off}, Sample{ply_text(), MeshFormat::Ply}})
        for (std::size_t size = 4; size + 2 < s.bytes.size(); ++size)
            EXPECT_EQ(code(s.bytes.substr(0, size), s.format), "E_TRUNCATED") << format_name(s.format) << " cut at " << size;
}

TEST(Read, ObjCutWithinALineIsTruncated)
{
    EXPECT_EQ(code("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2", MeshFormat::Obj), "E_TRUNCATED");
    EXPECT_EQ(code("v 0 0 0\nv 1 0 0\nv 0 1", MeshFormat::Obj), "E_TRUNCATED");
    EXPECT_EQ(code("v 0 0 0\nv 1 0 0\nv 0 1 1e", MeshFormat::Obj), "E_TRUNCATED");
    EXPECT_EQ(code("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", MeshFormat::Obj), "E_FORMAT");
}

TEST(Read, SizesAreCheckedBeforeAllocating)
{
    EXPECT_EQ(code("OFF\n3 100000000 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", MeshFormat::Off), "E_TRUNCATED");
    EXPECT_EQ(code("OFF\n350000000000 1 0\n0 0 0\n", MeshFormat::Off), "E_TRUNCATED");
    EXPECT_EQ(code("OFF\n99999999999999999999 18446744073709551615 0\n0 0 0\n", MeshFormat::Off), "E_TRUNCATED");
    EXPECT_EQ(code("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2000000000 0 1 2\n", MeshFormat::Off), "E_TRUNCATED");
    EXPECT_EQ(code(ply_header("ascii", 4, 4000000000u) + "0 0 0 9\n", MeshFormat::Ply), "E_TRUNCATED");
    EXPECT_EQ(code(ply_header("binary_little_endian", std::uint64_t{1} << 60, 1) + "0000", MeshFormat::Ply), "E_TRUNCATED");
    EXPECT_EQ(code("ply\nformat ascii 1.0\nelement vertex 9000000000000000000\nend_header\n", MeshFormat::Ply), "E_FORMAT");
    std::string stl = stl_binary();
    stl.replace(80, 4, raw(std::uint32_t{0xFFFFFFFF}));
    EXPECT_EQ(code(stl, MeshFormat::Stl), "E_TRUNCATED");
    std::string list = ply_header("binary_little_endian");
    list.replace(list.find("list uchar"), 10, "list uint");
    list += std::string(4 * 17, '\0') + raw(std::uint32_t{0xFFFFFFFF}) + std::string(100, '\0');
    EXPECT_EQ(code(list, MeshFormat::Ply), "E_TRUNCATED");
    EXPECT_EQ(code(glb(gltf_json(R"("byteLength":72000000000)"), gltf_buffer()), MeshFormat::Glb), "E_TRUNCATED");
}

TEST(Read, LimitsAreKept)
{
    EXPECT_EQ(code(obj_text(), MeshFormat::Obj, {.max_bytes = 20}), "E_LIMIT");
    for (const Sample& s : samples()) {
        EXPECT_EQ(code(s.bytes, s.format, {.max_faces = 3}), "E_LIMIT") << format_name(s.format);
        EXPECT_EQ(code(s.bytes, s.format, {.max_faces = 4}), "") << format_name(s.format);
    }
}

TEST(Read, ByteOrderMarksAndBlankLinesAtTheStartArePassedOver)
{
    for (const Sample& s : samples()) {
        const bool is_binary = s.bytes.find('\0') != std::string::npos && s.bytes.rfind("ply", 0) != 0;
        if (is_binary) continue;
        for (const std::string start : {"\xEF\xBB\xBF", "\n \r\n\n", "\xEF\xBB\xBF\n"}) {
            const ReadResult result = read(start + s.bytes, s.format);
            ASSERT_FALSE(result.error) << format_name(s.format) << ": " << result.error->message;
            EXPECT_EQ(result.soup.positions.size(), read(s.bytes, s.format).soup.positions.size());
            EXPECT_EQ(result.soup.indices.size(), 12u);
        }
    }
    // The 80 bytes of a binary STL file's header are anybody's.
    std::string stl = stl_binary();
    stl.replace(0, 3, "\xEF\xBB\xBF");
    EXPECT_EQ(read(stl, MeshFormat::Stl).soup.indices.size(), 12u);
}

TEST(Read, NotAMeshIsAFormatError)
{
    for (const MeshFormat format :
         {MeshFormat::Off, MeshFormat::Obj, MeshFormat::Stl, MeshFormat::Ply, MeshFormat::Gltf, MeshFormat::Glb}) {
        EXPECT_EQ(code("", format), "E_FORMAT") << format_name(format);
        EXPECT_EQ(code("<html>not a mesh</html>\n", format), "E_FORMAT") << format_name(format);
    }
    EXPECT_EQ(code(ply_text(), MeshFormat::Obj), "E_FORMAT") << "the content says PLY";
    EXPECT_EQ(code("4OFF\n1 0 0\n0 0 0 0\n", MeshFormat::Off), "E_FORMAT");
    EXPECT_EQ(code("OFF\n-4 4 0\n0 0 0\n", MeshFormat::Off), "E_FORMAT");
    EXPECT_EQ(code("OFF\n1 0 0\nzero 0 0\n", MeshFormat::Off), "E_FORMAT");
    EXPECT_EQ(code("just words\nin lines\n", MeshFormat::Obj), "E_FORMAT");
}

TEST(Read, NumbersOutOfRangeReachTheGateAsTheyAre)
{
    const ReadResult result =
        read("v nan -inf 1e400\nv 1e300 1e-400 +1.5\nv 1.#QNAN 0 0\nf 1 2 99999999999999999999\n", MeshFormat::Obj);
    ASSERT_FALSE(result.error) << result.error->message;
    EXPECT_TRUE(std::isnan(result.soup.positions[0].x));
    EXPECT_EQ(result.soup.positions[0].y, -std::numeric_limits<double>::infinity());
    EXPECT_EQ(result.soup.positions[0].z, std::numeric_limits<double>::infinity());
    EXPECT_EQ(result.soup.positions[1], (Vec3d{1e300, 0, 1.5}));
    EXPECT_TRUE(std::isnan(result.soup.positions[2].x));
    EXPECT_GT(result.soup.indices[2], 1'000'000'000'000);
}

TEST(ReadObj, CornersMayCountBackCarrySlashesAndEndInCrLf)
{
    const ReadResult result = read(
        "# c\r\nmtllib none.mtl\r\no a\r\nv 0 0 0\r\nv 1 0 0 0.5\r\nvt 0 0\r\nv 0 1 0\r\nvn 0 0 1\r\nusemtl x\r\ns off\r\n"
        "f 1/1 2/1 3/1\r\nf -3//-1 -2//1 -1//1\r\nf 1/1/1 \\\r\n 2/1/1 3/1/1\r\nf -4 0 1\r\n",
        MeshFormat::Obj);
    ASSERT_FALSE(result.error) << result.error->message;
    EXPECT_EQ(result.soup.positions.size(), 3u);
    EXPECT_EQ(result.soup.indices, (std::vector<std::int64_t>{0, 1, 2, 0, 1, 2, 0, 1, 2, -1, -1, 0}));
    EXPECT_EQ(code("v 0 0 0\nf 1 1.5 1\n", MeshFormat::Obj), "E_FORMAT");
}

TEST(ReadObj, NamesAndCommentsMayLookLikeFaces)
{
    const ReadResult result = read(
        "o v 9 9 9\ng f 1 2 3\n# f 1 2 3 \\\nv 0 0 0\nv 1 0 0 # v 8 8 8 \\\nv 0 1 0\nusemtl f 3 2 1\n"
        "mtllib f 1 2 3.mtl\n  f 1 2 3 # f 2 3 1\ng f\ns f 3 2 1\n",
        MeshFormat::Obj);
    ASSERT_FALSE(result.error) << result.error->message;
    EXPECT_EQ(result.soup.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(result.soup.indices, (std::vector<std::int64_t>{0, 1, 2}));
}

TEST(ReadOff, ColoursNormalsAndPolygonsAreTakenAsTheyCome)
{
    const ReadResult result =
        read("COFF\n\n# counts\n4 1 0\n0 0 0 255 0 0 255\n1 0 0 1 1 1 1\n1 1 0\n0 1 0\n4 0 1 2 3 0.5 0.5 0.5\n", MeshFormat::Off);
    ASSERT_FALSE(result.error) << result.error->message;
    EXPECT_EQ(result.soup.positions[1], (Vec3d{1, 0, 0}));
    EXPECT_EQ(result.soup.indices, (std::vector<std::int64_t>{0, 1, 2, 3}));
}

TEST(ReadOff, BlanksCommentsAndCountsMayStandOnTheFirstLine)
{
    const std::string body = off_text().substr(off_text().find("0 0 0"));
    for (const std::string start : {"\t   OFF4 4 6 # counts\n", "# cube.off\n#\nOFF 4 4 6\n",
                                    "OFF # kind\n# empty\n\n 4 4 6 # counts\n", "COFF4 4\n", "OFF 4 4\r\n"}) {
        const ReadResult result = read(start + body, MeshFormat::Off);
        ASSERT_FALSE(result.error) << start << result.error->message;
        EXPECT_EQ(result.soup.indices, k_corners) << start;
    }
    EXPECT_EQ(code("OFF4.5 4 6\n" + body, MeshFormat::Off), "E_FORMAT");
    EXPECT_EQ(code("OFF4", MeshFormat::Off), "E_TRUNCATED");
}

TEST(ReadStl, ABinaryFileMayStartWithSolid)
{
    const ReadResult result = read(stl_binary("solid but binary"), MeshFormat::Stl);
    ASSERT_FALSE(result.error) << result.error->message;
    EXPECT_EQ(result.soup.positions.size(), 12u);
    const std::string cut = stl_binary("solid but binary").substr(0, 200);
    EXPECT_EQ(code(cut, MeshFormat::Stl), "E_TRUNCATED");
    const std::string text = stl_text();
    EXPECT_EQ(code(text.substr(0, text.find("endsolid")), MeshFormat::Stl), "E_TRUNCATED");
}

TEST(ReadPly, IndicesOutOfRangeReachTheGate)
{
    std::string bytes = ply_binary(false);
    bytes.replace(bytes.size() - 4, 4, raw(std::int32_t{-7}));
    const ReadResult result = read(bytes, MeshFormat::Ply);
    ASSERT_FALSE(result.error);
    EXPECT_EQ(result.soup.indices.back(), -7);
}

TEST(ReadPly, ATextLineMayHoldMoreThanItsHeaderDeclares)
{
    // MeshLab declares a colour of four bytes for corners and writes a list of nine reals.
    const std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\n"
        "property uchar red\nend_header\n";
    const std::string vertices = "0 0 0 7 7\n1 0 0\n\n0 1 0 \n";
    for (const std::string faces :
         {"3 0 1 2 6 .5 .5 0 .25 1 1 9 1 1 1\n3 2 1 0 0 9\n", "3 0 1 2\n2 1 1 0\n3 2 1 0 1 0.5 8 extra"}) {
        const ReadResult result = read(header + vertices + faces, MeshFormat::Ply);
        ASSERT_FALSE(result.error) << result.error->message;
        EXPECT_EQ(result.soup.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
        EXPECT_EQ(result.soup.indices, (std::vector<std::int64_t>{0, 1, 2, 2, 1, 0}));
    }
    // Without a line for each element the values alone count.
    EXPECT_EQ(read(header + "0 0 0 1 0 0 0 1 0\n3 0 1 2 0 9 3 2 1 0 0 9", MeshFormat::Ply).soup.indices.size(), 6u);
    const ReadResult wrong = read(header + vertices + "3 0 one 2 0 9\n3 2 1 0 0 9\n", MeshFormat::Ply);
    ASSERT_TRUE(wrong.error);
    EXPECT_EQ(wrong.error->element, "line 16") << "counted from the start of the file";
}

TEST(ReadPly, StripsUnfoldWithTheirTrianglesFacingOneWay)
{
    const std::vector<std::int64_t> first{0, 1, 2, 3, 4, -1, 4, 3, 2, 2, 1}, second{5, 4, 3};
    for (const bool big_endian : {false, true}) {
        std::string bytes = std::string("ply\nformat ") + (big_endian ? "binary_big_endian" : "binary_little_endian") +
                            " 1.0\nelement tristrips 2\nproperty list int int vertex_indices\nelement vertex 6\n"
                            "property float x\nproperty float y\nproperty float z\nend_header\n";
        for (const auto& strip : {first, second}) {
            bytes += raw(static_cast<std::int32_t>(strip.size()), big_endian);
            for (const std::int64_t i : strip) bytes += raw(static_cast<std::int32_t>(i), big_endian);
        }
        for (int v = 0; v < 6; ++v)
            for (const int k : {v / 2, v % 2, 0}) bytes += raw(static_cast<float>(k), big_endian);
        const ReadResult result = read(bytes, MeshFormat::Ply);
        ASSERT_FALSE(result.error) << result.error->message;
        // By hand: 012, 132 turned, 234; 432; 3 2 2 and 2 2 1 are none; 543.
        EXPECT_EQ(result.soup.indices, (std::vector<std::int64_t>{0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 2, 5, 4, 3}));
        EXPECT_EQ(result.soup.polygon_offsets, (std::vector<std::uint32_t>{0, 3, 6, 9, 12, 15}));
        EXPECT_EQ(code(bytes, MeshFormat::Ply, {.max_faces = 4}), "E_LIMIT");
        EXPECT_EQ(code(bytes.substr(0, bytes.size() - 1), MeshFormat::Ply), "E_TRUNCATED");
    }
}

TEST(ReadGltf, NodesMoveTheirMeshes)
{
    // Scaled by 2, turned a quarter about z (x to y), then moved.
    const double h = std::sqrt(0.5);
    const ReadResult result = read(gltf_text(R"(,"translation":[10,0,0],"rotation":[0,0,)" + std::to_string(h) + "," +
                                             std::to_string(h) + R"(],"scale":[2,2,2])"),
                                   MeshFormat::Gltf);
    ASSERT_FALSE(result.error) << result.error->message;
    EXPECT_NEAR(result.soup.positions[1].x, 10, 1e-5);
    EXPECT_NEAR(result.soup.positions[1].y, 2, 1e-5);
    EXPECT_NEAR(result.soup.positions[2].x, 8, 1e-5);
    const ReadResult matrix = read(gltf_text(R"(,"matrix":[0,2,0,0,-2,0,0,0,0,0,2,0,10,0,0,1])"), MeshFormat::Gltf);
    EXPECT_EQ(matrix.soup.positions[1], (Vec3d{10, 2, 0}));
}

TEST(ReadGltf, ChunksNeedNoPadding)
{
    std::string json = gltf_json(R"("byteLength":72)");
    while (json.size() % 4 != 1) json += ' ';
    std::string bytes = "glTF" + raw(std::uint32_t{2}) + raw(static_cast<std::uint32_t>(28 + json.size() + 72)) +
                        raw(static_cast<std::uint32_t>(json.size())) + "JSON" + json + raw(std::uint32_t{72}) + "BIN\0"s +
                        gltf_buffer();
    EXPECT_EQ(read(bytes, MeshFormat::Glb).soup.indices, k_corners);
    // Padded, with the length before it.
    bytes.insert(20 + json.size(), 3, ' ');
    bytes.replace(8, 4, raw(static_cast<std::uint32_t>(bytes.size())));
    EXPECT_EQ(read(bytes, MeshFormat::Glb).soup.indices, k_corners);
}

TEST(ReadGltf, AMirroringNodeKeepsFacesOutward)
{
    const ReadResult result = read(gltf_text(R"(,"scale":[-1,1,1])"), MeshFormat::Gltf);
    ASSERT_FALSE(result.error);
    double six_volumes = 0;
    const auto& p = result.soup.positions;
    for (std::size_t f = 0; f < 4; ++f) {
        const auto corner = [&](std::size_t k) { return p[static_cast<std::size_t>(result.soup.indices[3 * f + k])]; };
        six_volumes += dot(corner(0), cross(corner(1), corner(2)));
    }
    EXPECT_DOUBLE_EQ(six_volumes, 1);
}

TEST(ReadGltf, DefectsAreNamed)
{
    EXPECT_EQ(code(gltf_json(R"("byteLength":72,"uri":"missing.bin")"), MeshFormat::Gltf), "E_TRUNCATED");
    EXPECT_EQ(code(gltf_json(R"("byteLength":72)"), MeshFormat::Gltf), "E_TRUNCATED");
    EXPECT_EQ(code(gltf_json(R"("byteLength":72,"uri":"../../etc/passwd")"), MeshFormat::Gltf), "E_FORMAT");
    EXPECT_EQ(code(gltf_json(R"("byteLength":72,"uri":"/etc/passwd")"), MeshFormat::Gltf), "E_FORMAT");
    EXPECT_EQ(code(gltf_json(R"("byteLength":"72")"), MeshFormat::Gltf), "E_FORMAT");
    EXPECT_EQ(code(gltf_text(R"(,"children":[0])"), MeshFormat::Gltf), "E_FORMAT") << "a node that is its own child";
    EXPECT_EQ(code(R"({"asset":{"version":"1.0"}})", MeshFormat::Gltf), "E_FORMAT");
    std::string wrong = gltf_text();
    wrong.replace(wrong.find("\"POSITION\":0"), 12, "\"POSITION\":7");
    EXPECT_EQ(code(wrong, MeshFormat::Gltf), "E_FORMAT");
    std::string longer = gltf_text();
    longer.replace(longer.find("\"count\":12"), 10, "\"count\":15");
    EXPECT_EQ(code(longer, MeshFormat::Gltf), "E_TRUNCATED");
    const std::string text = gltf_text();
    EXPECT_EQ(code(text.substr(0, text.size() - 1), MeshFormat::Gltf), "E_TRUNCATED");
}

TEST(ReadGltf, AnIndexBeyondItsOwnPrimitiveIsOutOfRangeEvenIfOthersFollow)
{
    std::string json = gltf_json(R"("byteLength":72)");
    const std::string primitive = R"({"attributes":{"POSITION":0},"indices":1})";
    json.replace(json.find(primitive), primitive.size(), primitive + "," + primitive);
    std::string buffer = gltf_buffer();
    buffer.replace(48, 2, raw(std::uint16_t{5}));
    const ReadResult result = read(glb(json, buffer), MeshFormat::Glb);
    ASSERT_FALSE(result.error) << result.error->message;
    EXPECT_EQ(result.soup.positions.size(), 8u);
    EXPECT_EQ(result.soup.indices[0], -1);
}

TEST(ReadGltf, RepeatedInstancesAreHeldToTheFilesSize)
{
    // 100 vertices a mesh, each primitive shows it again: 12 bytes of text for 2,400 bytes of mesh.
    std::string primitives, primitive = R"({"attributes":{"POSITION":0}})";
    const std::size_t repeats = 30000;
    for (std::size_t i = 0; i < repeats; ++i) primitives += (i > 0 ? "," : "") + primitive;
    const std::string json = R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[)" + primitives +
                             R"(]}],"buffers":[{"byteLength":3600}],"bufferViews":[{"buffer":0,"byteLength":3600}],)"
                             R"("accessors":[{"bufferView":0,"componentType":5126,"count":300,"type":"VEC3"}]})";
    EXPECT_EQ(code(glb(json, std::string(3600, '\0')), MeshFormat::Glb), "E_LIMIT");
}

TEST(ReadFile, ContentTellsTheFormatWhereTheNameDoesNot)
{
    const auto folder = std::filesystem::temp_directory_path() / ("sqmap_read_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder);
    for (const Sample& s : samples()) {
        const auto path = folder / "mesh";
        std::ofstream(path, std::ios::binary) << s.bytes;
        const ReadResult result = read_mesh_file(path);
        EXPECT_FALSE(result.error);
        EXPECT_EQ(result.format, s.format);
    }
    std::ofstream(folder / "buffer.bin", std::ios::binary) << gltf_buffer();
    std::ofstream(folder / "mesh.gltf") << gltf_json(R"("byteLength":72,"uri":"buffer.bin")");
    EXPECT_FALSE(read_mesh_file(folder / "mesh.gltf").error);
    std::ofstream(folder / "mesh.PLY") << obj_text();
    EXPECT_EQ(read_mesh_file(folder / "mesh.PLY").error->code, "E_FORMAT");
    EXPECT_EQ(read_mesh_file(folder / "absent.obj").error->code, "E_FILE");
    EXPECT_EQ(read_mesh_file(folder).error->code, "E_FILE");
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace sqmap::io
