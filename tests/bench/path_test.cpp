#include "path.h"

#include "error.h"
#include "make_path.h"
#include "settings.h"
#include "truth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

namespace sqmap::bench {
namespace {

const std::string k_header = "r00,r01,r02,r10,r11,r12,r20,r21,r22,tx,ty,tz\n";

std::filesystem::path file_with(const std::string& text)
{
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "sqmap-bench-path.csv";
    std::ofstream(path) << text;
    return path;
}

TEST(Path, ComesBackAsItWasWritten)
{
    const auto setting = test::egg_on_ring();
    const std::vector<Pose> path = test::short_path(*setting, 0.01);
    const std::vector<Pose> read = read_path(file_with(path_text(path)));
    ASSERT_EQ(read.size(), path.size());
    for (std::size_t f = 0; f < path.size(); ++f) {
        EXPECT_LT(norm(read[f].translation - path[f].translation), 1e-6);
        for (int i = 0; i < 3; ++i) EXPECT_LT(norm(read[f].rotation.row[i] - path[f].rotation.row[i]), 1e-6);
    }
}

TEST(Path, BadRowsAreNamedWithACure)
{
    const std::string good = "1,0,0,0,1,0,0,0,1,0,0,0\n";
    const struct {
        std::string text, element;
    } cases[] = {{"", ":1:"},
                 {"x,y,z\n", ":1:"},
                 {k_header, "no pose"},
                 {k_header + good + "1,0,0,0,1,0,0,0,1,0,0\n", ":3:"},
                 {k_header + good + "1,0,0,0,1,0,0,0,1,0,0,0,0\n" + good, ":3:"},
                 {k_header + "1,0,0,0,1,0,0,0,1,0,nan,0\n", ":2: column 11"},
                 {k_header + "1,0,0,0,1,0,0,0,1,0,0,far\n", ":2: column 12"},
                 {k_header + "1,0,0,0,1,0,0,0,-1,0,0,0\n", ":2: the first nine columns are no rotation"},
                 {k_header + "2,0,0,0,2,0,0,0,2,0,0,0\n", ":2: the first nine columns are no rotation"}};
    for (const auto& c : cases) {
        try {
            (void)read_path(file_with(c.text));
            ADD_FAILURE() << "taken: " << c.text;
        } catch (const BenchError& e) {
            const std::string what = e.what();
            EXPECT_NE(what.find(c.element), std::string::npos) << what;
            EXPECT_NE(what.find("cure:"), std::string::npos) << what;
        }
    }
    EXPECT_THROW((void)read_path("/nowhere/at-all.csv"), BenchError);
}

// The field that leads the probe is off by about a tenth of its cell where the surface bends.
TEST(Path, WhereAHoleIsOnTheWayTheProbeGoesOnToTheFarRim)
{
    // A probe is scaled to 0.4 of the object's diagonal: this one fits through the hole as it turns.
    const bench::Setting ring(mesh::torus({.major_radius = 1, .minor_radius = 0.1, .major_segments = 48, .minor_segments = 16}),
                              mesh::ellipsoid({1, 0.3, 0.3}, 3));
    for (const double depth : {0.01, -0.01})
        for (const Pose& pose : test::short_path(ring, depth, 40)) {
            const std::vector<double> distances = test::signed_distances(ring, pose);
            EXPECT_NEAR(*std::min_element(distances.begin(), distances.end()), -depth, 0.004);
        }
}

TEST(Path, ADepthThatIsNeverReachedIsSaidWithACure)
{
    const bench::Setting thin(mesh::torus({.major_radius = 1, .minor_radius = 0.02, .major_segments = 48, .minor_segments = 16}),
                              mesh::ellipsoid({1, 0.3, 0.3}, 3));
    try {
        (void)test::short_path(thin, 0.03, 40);
        ADD_FAILURE() << "made";
    } catch (const BenchError& e) {
        EXPECT_NE(std::string(e.what()).find("cure:"), std::string::npos) << e.what();
    }
}

TEST(Path, GeneratedPathsAreAsDeepAsAsked)
{
    const auto setting = test::egg_on_ring();
    for (const double depth : {0.01, 0.03, -0.01})
        for (const Pose& pose : test::short_path(*setting, depth)) {
            const std::vector<double> distances = test::signed_distances(*setting, pose);
            EXPECT_NEAR(*std::min_element(distances.begin(), distances.end()), -depth, 0.003);
        }
}

TEST(Truth, IsWhatBruteForceFindsInEveryFrame)
{
    const auto setting = test::egg_on_ring();
    const std::vector<Pose> path = test::short_path(*setting, 0.03);
    const auto truth = true_contacts(*setting, path);
    ASSERT_EQ(truth.size(), path.size());
    for (std::size_t f = 0; f < path.size(); ++f) {
        const std::vector<double> distances = test::signed_distances(*setting, path[f]);
        auto next = truth[f].begin();
        for (std::uint32_t v = 0; v < distances.size(); ++v) {
            if (distances[v] >= 0) continue;
            ASSERT_NE(next, truth[f].end()) << "frame " << f;
            EXPECT_EQ(next->vertex, v);
            EXPECT_EQ(next->depth, -distances[v]);
            ++next;
        }
        EXPECT_EQ(next, truth[f].end()) << "frame " << f;
    }
}

}  // namespace
}  // namespace sqmap::bench
