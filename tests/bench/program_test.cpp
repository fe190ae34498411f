// The program as a user meets it.
#include "path.h"
#include "settings.h"

#include <sys/wait.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace sqmap::bench {
namespace {

class BenchProgram : public testing::Test {
protected:
    void SetUp() override
    {
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
        const auto setting = test::egg_on_ring();
        write("ring.obj", setting->object);
        write("egg.obj", setting->probe);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    void write(const std::string& name, const mesh::Mesh& mesh) const
    {
        std::ofstream out(folder_ / name);
        for (const Vec3d& v : mesh.vertices) out << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
        for (const mesh::Triangle& t : mesh.triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    }
    int run(const std::string& arguments) const
    {
        const std::string command =
            "cd '" + folder_.string() + "' && '" SQMAP_BENCH_PROGRAM "' " + arguments + " > out.txt 2> err.txt";
        const int status = std::system(command.c_str());
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }
    [[nodiscard]] std::string text(const std::string& name) const
    {
        std::ostringstream out;
        out << std::ifstream(folder_ / name).rdbuf();
        return out.str();
    }

    std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) /
                                    (std::string("sqmap-bench-") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(BenchProgram, MakesAPathRacesOnItAndTabulates)
{
    ASSERT_EQ(run("path --object ring.obj --probe egg.obj --kind deep --frames 20 -o ring.egg.deep.csv --cache cache"), 0)
        << text("err.txt");
    EXPECT_EQ(read_path(folder_ / "ring.egg.deep.csv").size(), 20u);
    ASSERT_EQ(
        run("frames --object ring.obj --probe egg.obj --path ring.egg.deep.csv --methods dense64_simd,dense64 --cache cache "
            "--json out.json"),
        0)
        << text("err.txt");
    const auto json = nlohmann::json::parse(text("out.json"));
    ASSERT_EQ(json.size(), 2u);
    EXPECT_EQ(json[0]["method"], "dense64_simd");
    EXPECT_EQ(json[1]["method"], "dense64");
    EXPECT_EQ(json[0]["frames"], 20);
    EXPECT_GT(json[0]["contacts"], 0);
    ASSERT_EQ(run("table out.json"), 0);
    EXPECT_NE(text("out.txt").find("| dense64_simd |"), std::string::npos) << text("out.txt");
    EXPECT_NE(text("out.txt").find("### deep: medians over 1 path"), std::string::npos) << text("out.txt");
}

TEST_F(BenchProgram, WritesASeriesWithARowAFrame)
{
    std::ofstream(folder_ / "path.csv") << path_text(std::vector<Pose>(3));
    ASSERT_EQ(
        run("frames --object ring.obj --probe egg.obj --path path.csv --methods dense64 --cache cache --json out.json --series "
            "out.csv"),
        0)
        << text("err.txt");
    const std::string series = text("out.csv");
    EXPECT_EQ(series.substr(0, series.find('\n')), "frame,dense64_us,dense64_contacts");
    EXPECT_EQ(std::count(series.begin(), series.end(), '\n'), 4);
}

TEST_F(BenchProgram, MakesTheNumbersOfTheReproduction)
{
    ASSERT_EQ(run("memory --object ring.obj --cells 32,64 --levels 3,4 --json memory.json"), 0) << text("err.txt");
    const auto memory = nlohmann::json::parse(text("memory.json"));
    ASSERT_EQ(memory["fields"].size(), 2u);
    ASSERT_EQ(memory["maps"].size(), 2u);
    EXPECT_GT(memory["fields"][1]["dense_bytes"], memory["fields"][0]["dense_bytes"]);
    EXPECT_GT(memory["maps"][1]["bytes"], memory["maps"][0]["bytes"]);
    EXPECT_GT(memory["maps"][1]["cells"], memory["maps"][0]["cells"]);

    ASSERT_EQ(run("path --object ring.obj --probe egg.obj --kind deep --frames 4 -o deep.csv --cache cache"), 0)
        << text("err.txt");
    ASSERT_EQ(run("density --object ring.obj --probe egg.obj --path deep.csv --levels 3 --subdivisions 2 --json density.json"), 0)
        << text("err.txt");
    const auto density = nlohmann::json::parse(text("density.json"));
    ASSERT_EQ(density.size(), 3u);
    EXPECT_EQ(density[0]["layer"], 2);
    EXPECT_EQ(density[2]["subdivisions"], 2);
    EXPECT_LT(density[2]["eq35_mean_pct"], density[0]["eq35_mean_pct"]);

    ASSERT_EQ(run("sampling --rows 3 --columns 4 -o sampling.csv"), 0) << text("err.txt");
    const std::string points = text("sampling.csv");
    EXPECT_EQ(std::count(points.begin(), points.end(), '\n'), 1 + 3 * 4);
}

TEST_F(BenchProgram, SaysWhatIsWrongAndLeavesNoFileBehind)
{
    std::ofstream(folder_ / "good.csv") << path_text(std::vector<Pose>(20));
    std::ofstream(folder_ / "bad.csv") << path_text(std::vector<Pose>(2)) << "1,2,3\n";
    std::ofstream(folder_ / "open.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
    const struct {
        std::string arguments, element;
        int code;
    } cases[] = {
        {"--object ring.obj --probe egg.obj --path bad.csv --json out.json", "bad.csv:4:", 2},
        {"--object ring.obj --probe egg.obj --path absent.csv --json out.json", "absent.csv", 2},
        {"--object absent.obj --probe egg.obj --path good.csv --json out.json", "absent.obj", 2},
        {"--object open.obj --probe egg.obj --path good.csv --json out.json", "open.obj: E_OPEN", 2},
        {"--object ring.obj --probe good.csv --path good.csv --json out.json", "good.csv: E_FORMAT", 2},
        {"--object ring.obj --probe egg.obj --path good.csv --methods dense65 --json out.json", "dense65", 2},
        {"--object ring.obj --probe egg.obj --path good.csv --methods dense64 --cache cache --json absent/out.json", "absent", 2},
        {"--object ring.obj --probe egg.obj --path good.csv --passes 19 --json out.json", "--passes", 64},
        {"--object ring.obj --probe egg.obj --path good.csv", "--json", 64},
    };
    for (const auto& c : cases) {
        EXPECT_EQ(run("frames " + c.arguments), c.code) << c.arguments << '\n' << text("err.txt");
        EXPECT_NE(text("err.txt").find(c.element), std::string::npos) << c.arguments << '\n' << text("err.txt");
        if (c.code == 2 && c.element != "absent") {
            EXPECT_NE(text("err.txt").find("cure:"), std::string::npos) << text("err.txt");
        }
        EXPECT_FALSE(std::filesystem::exists(folder_ / "out.json")) << c.arguments;
        EXPECT_FALSE(std::filesystem::exists(folder_ / "absent")) << c.arguments;
    }
}

}  // namespace
}  // namespace sqmap::bench
