// Formats that are read through the program assimp. Scripts in its place do what it may do at worst; the real one is tested
// where it is installed.
#include "sqmap/io/read.h"

#include <signal.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace sqmap::io {
namespace {

namespace fs = std::filesystem;

constexpr const char* k_dae = "<?xml version=\"1.0\"?>\n<COLLADA version=\"1.4.1\"></COLLADA>\n";

/// A triangle in one file.
std::string gltf()
{
    return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
           R"("buffers":[{"byteLength":36,"uri":"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],)"
           R"("bufferViews":[{"buffer":0,"byteLength":36}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]})";
}

/// A folder with a program named assimp in front of the others, and one for temporary files that must be empty at the end.
class ReadThroughAssimp : public ::testing::Test {
protected:
    void SetUp() override
    {
        folder_ = fs::temp_directory_path() / ("sqmap_assimp_test_" + std::to_string(::getpid()));
        fs::create_directories(folder_ / "tmp");
        path_ = std::getenv("PATH");
        ::setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
        std::ofstream(folder_ / "triangle.gltf") << gltf();
    }
    void TearDown() override
    {
        EXPECT_TRUE(fs::is_empty(folder_ / "tmp")) << "a temporary folder was left";
        ::unsetenv("TMPDIR");
        ::setenv("PATH", path_.c_str(), 1);
        fs::remove_all(folder_);
    }

    void install(const std::string& script)
    {
        std::ofstream(folder_ / "assimp") << "#!/bin/sh\n" << script << "\n";
        fs::permissions(folder_ / "assimp", fs::perms::owner_all);
        ::setenv("PATH", (folder_.string() + ":" + path_).c_str(), 1);
    }

    [[nodiscard]] static ReadResult read(const std::string& text, const ReadLimits& limits = {},
                                         MeshFormat format = MeshFormat::Dae)
    {
        return read_mesh_bytes(std::as_bytes(std::span(text)), format, limits);
    }

    /// The error of a file that the script was given.
    ReadError error(const std::string& script, const ReadLimits& limits = {})
    {
        install(script);
        const ReadResult result = read(k_dae, limits);
        EXPECT_TRUE(result.soup.positions.empty());
        const ReadError out = result.error.value_or(ReadError{});
        EXPECT_FALSE(out.element.empty() || out.message.empty() || out.cure.empty());
        return out;
    }

    fs::path folder_;
    std::string path_;
};

TEST_F(ReadThroughAssimp, WhatItWritesIsRead)
{
    install("[ \"$*\" = 'export mesh.dae mesh.glb -fglb2 -ptv' ] && grep -q COLLADA mesh.dae && exec cp " +
            (folder_ / "triangle.gltf").string() + " mesh.glb");
    std::ofstream(folder_ / "mesh.DAE") << k_dae;
    const ReadResult result = read_mesh_file(folder_ / "mesh.DAE");
    ASSERT_FALSE(result.error) << result.error->message;
    EXPECT_EQ(result.format, MeshFormat::Dae);
    EXPECT_EQ(result.soup.positions, (std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(result.soup.indices, (std::vector<std::int64_t>{0, 1, 2}));
}

TEST_F(ReadThroughAssimp, WithoutItTheErrorNamesThePackage)
{
    ::setenv("PATH", (folder_ / "tmp").c_str(), 1);
    const ReadResult result = read(k_dae);
    ASSERT_TRUE(result.error);
    EXPECT_EQ(result.error->code, "E_FORMAT");
    EXPECT_NE(result.error->cure.find("assimp-utils"), std::string::npos) << result.error->cure;
}

TEST_F(ReadThroughAssimp, AFileOfAnotherKindIsRefusedBeforeItStarts)
{
    install("touch " + (folder_ / "started").string());
    for (const MeshFormat format : {MeshFormat::Dae, MeshFormat::ThreeMf, MeshFormat::Fbx})
        EXPECT_EQ(read("<html>not a mesh</html>\n", {}, format).error->code, "E_FORMAT");
    EXPECT_EQ(read(k_dae, {.max_bytes = 20}).error->code, "E_LIMIT");
    EXPECT_FALSE(fs::exists(folder_ / "started"));
}

TEST_F(ReadThroughAssimp, ItsOwnWordsSayWhyAFileIsNotRead)
{
    const ReadError refused =
        error("echo 'Launching asset import ...  OK'; echo 'ERROR: Failed to load file: no mesh'; exit 217");
    EXPECT_EQ(refused.code, "E_FORMAT");
    EXPECT_NE(refused.message.find("ERROR: Failed to load file: no mesh"), std::string::npos) << refused.message;
    EXPECT_EQ(error("exit 0").code, "E_FORMAT") << "it wrote nothing";
    EXPECT_EQ(error("printf 'a\\001\\n'; exit 1").message.find('\001'), std::string::npos);
    const ReadError junk = error("echo junk > mesh.glb");
    EXPECT_EQ(junk.code, "E_FORMAT");
    EXPECT_NE(junk.element.find("assimp"), std::string::npos);
}

TEST_F(ReadThroughAssimp, CrashesAndHangsEndWithIt)
{
    EXPECT_EQ(error("kill -SEGV $$").code, "E_FORMAT");
    EXPECT_EQ(error("while :; do :; done", {.max_seconds = 1}).code, "E_LIMIT") << "CPU time";
    EXPECT_EQ(error("exec sleep 1000", {.max_seconds = 1}).code, "E_LIMIT") << "time by the clock";
}

TEST_F(ReadThroughAssimp, FloodsAreCut)
{
    const ReadLimits small{.max_bytes = 1 << 20};
    EXPECT_EQ(error("exec yes > mesh.glb", small).code, "E_LIMIT") << "of its output";
    EXPECT_EQ(error("exec yes", small).code, "E_LIMIT") << "of its messages";
    EXPECT_NE(error("exec dd if=/dev/zero of=/dev/null bs=3000M count=1").code, "") << "of memory";
}

TEST_F(ReadThroughAssimp, WhatItStartedEndsWithIt)
{
    const fs::path file = folder_ / "pid";
    error("sleep 1000 & echo $! > " + file.string() + "; exit 1");
    pid_t pid = 0;
    std::ifstream(file) >> pid;
    ASSERT_GT(pid, 0);
    const auto state = [&] {  // of /proc/PID/stat: the letter after the name; none where the process is gone
        std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
        std::string word;
        stat >> word >> word >> word;
        return word;
    };
    while (state() != "" && state() != "Z" && state() != "X") ::usleep(1000);
}

TEST_F(ReadThroughAssimp, ColladaComesOutInMetresWithYUp)
{
    if (std::system("command -v assimp > /dev/null") != 0) GTEST_SKIP() << "assimp is not installed (Debian: assimp-utils)";
    // A tetrahedron of 100 x 200 x 300 cm, z up.
    const std::string dae =
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
        "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">\n"
        "<asset><unit name=\"centimeter\" meter=\"0.01\"/><up_axis>Z_UP</up_axis></asset>\n"
        "<library_geometries><geometry id=\"g\" name=\"g\"><mesh>\n"
        "<source id=\"p\"><float_array id=\"a\" count=\"12\">0 0 0 100 0 0 0 200 0 0 0 300</float_array><technique_common>"
        "<accessor source=\"#a\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>"
        "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>\n"
        "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices>\n"
        "<triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 2 1 0 1 3 1 2 3 0 3 "
        "2</p></triangles>\n"
        "</mesh></geometry></library_geometries>\n"
        "<library_visual_scenes><visual_scene id=\"s\" name=\"s\"><node id=\"n\" name=\"n\" type=\"NODE\">"
        "<instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>\n"
        "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>\n";
    const ReadResult result = read(dae);
    ASSERT_FALSE(result.error) << result.error->message;
    EXPECT_EQ(result.soup.indices.size(), 12u);
    Vec3d low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
    for (const Vec3d& p : result.soup.positions)
        for (int i = 0; i < 3; ++i) {
            low[i] = std::min(low[i], p[i]);
            high[i] = std::max(high[i], p[i]);
        }
    EXPECT_NEAR(norm(low - Vec3d{0, 0, -2}), 0, 1e-6);
    EXPECT_NEAR(norm(high - Vec3d{1, 3, 0}), 0, 1e-6);
}

}  // namespace
}  // namespace sqmap::io
