#include "sqmap/device/path.h"

#include "device/channel.h"
#include "sqmap/device/servo.h"

#include "sqmap/query/point.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include <unistd.h>

namespace sqmap::device {
namespace {

std::string complaint_about(const std::string& text)
{
    const auto path = std::filesystem::temp_directory_path() / ("sqmap-path-" + std::to_string(::getpid()) + ".csv");
    std::ofstream(path) << text;
    std::string what;
    try {
        (void)read_path(path);
    } catch (const DeviceError& e) {
        what = e.what();
        what = what.substr(path.string().size());
    }
    std::filesystem::remove(path);
    return what;
}

TEST(PathDevice, PlaysEveryPoseOnceAndIsThenGone)
{
    std::vector<Pose> poses(6);
    for (std::size_t i = 0; i < 6; ++i) poses[i].translation.x = static_cast<double>(i);
    PathDevice path("p", poses, 500, 2);
    EXPECT_TRUE(path.capabilities().simulated);
    EXPECT_EQ(path.ticks(), 3u);
    Sample sample;
    const Wrench none[2];
    for (std::size_t tick = 0; tick < 3; ++tick) {
        EXPECT_TRUE(path.write(none));
        ASSERT_TRUE(path.read(sample));
        EXPECT_EQ(sample.sequence, tick + 1);
        const double time = now();
        EXPECT_LE(sample.time, time) << "the servo's clock";
        EXPECT_GT(sample.time, time - 60);
        EXPECT_EQ(sample.poses[0].translation.x, 2.0 * static_cast<double>(tick));
        EXPECT_EQ(sample.poses[1].translation.x, 2.0 * static_cast<double>(tick) + 1);
    }
    const Sample last = sample;
    EXPECT_FALSE(path.read(sample));
    EXPECT_EQ(sample.sequence, last.sequence) << "a failed read leaves the sample";
    EXPECT_FALSE(path.write(none));
}

std::uint32_t push_up(void*, const TickInput&, std::span<Wrench> wrenches) noexcept
{
    wrenches[0].force.z = 0.15;  // so little that the filter engages at any time
    return 0;
}

TEST(PathDevice, IsNoStaleDeviceToAServo)
{
    PathDevice path("p", std::vector<Pose>(20000), 1000);
    Servo servo(path, {}, push_up, nullptr);
    ServoTick tick;
    const double end = now() + 30;
    bool pushed = false;
    while (!pushed && now() < end)
        while (servo.next(tick)) pushed |= norm(tick.sent[0].force) > 0;
    EXPECT_TRUE(pushed) << "samples dated from zero would be thousands of seconds old";
}

TEST(PathDevice, RefusesWhatIsNoPath)
{
    EXPECT_THROW(PathDevice("p", {}, 1000), DeviceError);
    EXPECT_THROW(PathDevice("p", std::vector<Pose>(3), 1000, 2), DeviceError);
    EXPECT_THROW(PathDevice("p", std::vector<Pose>(3), 1000, 0), DeviceError);
    EXPECT_THROW(PathDevice("p", std::vector<Pose>(34), 1000, 17), DeviceError);
    EXPECT_THROW(PathDevice("p", std::vector<Pose>(3), 0), DeviceError);
    EXPECT_THROW(PathDevice("p", std::vector<Pose>(3), std::nan("")), DeviceError);
}

TEST(ReadPath, ReadsPosesAndNamesTheLineOfAnError)
{
    const std::string header = "r00,r01,r02,r10,r11,r12,r20,r21,r22,tx,ty,tz\n", row = "0,-1,0,1,0,0,0,0,1,0.5,-2,3e-3\n";
    EXPECT_EQ(complaint_about(header + row + row), "");
    EXPECT_TRUE(complaint_about("x,y,z\n").starts_with(":1: the header must be r00"));
    EXPECT_EQ(complaint_about(header), ": no pose after the header");
    EXPECT_EQ(complaint_about("\xef\xbb\xbf" + header + row + "\r\n \n\n"), "") << "as spreadsheets write it";
    EXPECT_EQ(complaint_about(header + row + "\n" + row), ":3: expected 12 numbers, one pose, found an empty line");
    EXPECT_EQ(complaint_about(header + row + "1,2,3\n"), ":3: expected 12 numbers, one pose");
    EXPECT_EQ(complaint_about(header + "0,-1,0,1,0,0,0,0,1,0.5,-2,nan\n"), ":2: column 12 is no finite number: 'nan'");
    EXPECT_EQ(complaint_about(header + "0,1,0,1,0,0,0,0,1,0,0,0\n"),
              ":2: the first nine columns are no rotation (rows must be orthonormal and right-handed)");
    for (const char* none : {"0,0,0,0,0,0,0,0,0", "-1,0,0,0,1,0,0,0,1", "2,0,0,0,2,0,0,0,2"})
        EXPECT_EQ(complaint_about(header + none + ",0,0,0\n"),
                  ":2: the first nine columns are no rotation (rows must be orthonormal and right-handed)");
    EXPECT_THROW((void)read_path("/no/such/file"), DeviceError);
}

/// A ball of radius 1 as model: what a tool feels is known in closed form.
class Scripted : public ::testing::Test {
protected:
    static void SetUpTestSuite() { ball_ = new test::Parsed(mesh::sphere(1, 4)); }
    static void TearDownTestSuite()
    {
        delete ball_;
        ball_ = nullptr;
    }
    static const model::ModelView& model() { return ball_->view(); }
    /// How deep a point tool is at each pose, by the distance from the centre; negative outside.
    static std::vector<double> depths(Script script, const ScriptOptions& options)
    {
        const query::Probe tool(std::vector<Vec3d>{{}});
        std::vector<double> out;
        for (const Pose& pose : scripted_path(model(), tool, script, options)) out.push_back(1 - norm(pose.translation));
        return out;
    }
    static test::Parsed* ball_;
};

test::Parsed* Scripted::ball_ = nullptr;

constexpr double k_map_error = 3e-3;  // of the ball's mesh and map from the sphere

TEST_F(Scripted, ThePathIsTheSameAtAnyRate)
{
    const query::Probe tool(std::vector<Vec3d>{{}});
    for (const Script script : {Script::Press, Script::Tap, Script::Slide, Script::Circle}) {
        ScriptOptions o{.seconds = 1, .wait = 0.1, .depth = 0.02, .gap = 0.02};
        const std::vector<Pose> fine = scripted_path(model(), tool, script, o);
        o.rate = 100;
        const std::vector<Pose> coarse = scripted_path(model(), tool, script, o);
        ASSERT_EQ(coarse.size(), 100u);
        for (std::size_t k = 0; k < coarse.size(); ++k)
            EXPECT_EQ(coarse[k].translation, fine[10 * k].translation) << int(script) << ' ' << k;
    }
}

TEST_F(Scripted, PressGoesFromTheGapToTheDepthAndBack)
{
    const ScriptOptions o{.seconds = 4, .speed = 0.5, .depth = 0.1, .gap = 0.2, .direction = {0, 3, 4}};
    const std::vector<double> depth = depths(Script::Press, o);
    ASSERT_EQ(depth.size(), 4000u);
    EXPECT_NEAR(depth.front(), -0.2, k_map_error);
    EXPECT_NEAR(depth[2000], 0.1, k_map_error);
    EXPECT_NEAR(depth.back(), -0.2, k_map_error);
    for (std::size_t i = 1; i < depth.size(); ++i)
        EXPECT_LE(std::abs(depth[i] - depth[i - 1]), 0.5 / 1000 + 1e-9) << "faster than asked";
}

TEST_F(Scripted, TapIsASineOfTheSpeedChosen)
{
    const ScriptOptions o{.seconds = 4, .speed = 0.3, .depth = 0.1, .gap = 0.1};
    const std::vector<double> depth = depths(Script::Tap, o);
    const auto [least, largest] = std::minmax_element(depth.begin(), depth.end());
    EXPECT_NEAR(*least, -0.1, k_map_error);
    EXPECT_NEAR(*largest, 0.1, k_map_error);
    double fastest = 0;
    for (std::size_t i = 1; i < depth.size(); ++i) fastest = std::max(fastest, 1000 * std::abs(depth[i] - depth[i - 1]));
    EXPECT_NEAR(fastest, 0.3, 1e-3);
}

TEST_F(Scripted, SlideKeepsDepthAndSpeedRoundTheBall)
{
    const ScriptOptions o{.seconds = 10, .speed = 1, .depth = 0.05, .gap = 0.05, .direction = {1, 0, 0}, .travel = {0, 1, 0}};
    const query::Probe tool(std::vector<Vec3d>{{}});
    const std::vector<Pose> poses = scripted_path(model(), tool, Script::Slide, o);
    ASSERT_EQ(poses.size(), 10000u);
    double farthest_back = 1;
    for (std::size_t i = 500; i < poses.size(); ++i) {
        EXPECT_NEAR(1 - norm(poses[i].translation), 0.05, 0.01);
        EXPECT_LT(norm(poses[i].translation - poses[i - 1].translation), 1.2e-3) << "never jumps";
        farthest_back = std::min(farthest_back, poses[i].translation.x);
    }
    EXPECT_LT(farthest_back, -0.9) << "ten units of way lead round a ball of circumference 6.3";
}

TEST_F(Scripted, CircleStaysRoundItsCentre)
{
    const ScriptOptions o{.seconds = 5, .speed = 0.5, .depth = 0.02, .gap = 0.02, .radius = 0.3, .direction = {0, 0, 1}};
    const query::Probe tool(std::vector<Vec3d>{{}});
    const std::vector<Pose> poses = scripted_path(model(), tool, Script::Circle, o);
    for (std::size_t i = 500; i < poses.size() - 30; ++i) {
        const Vec3d p = poses[i].translation;
        EXPECT_NEAR(std::hypot(p.x, p.y), 0.3, 0.01);
        // Pressed in by the depth along z, from the sphere.
        EXPECT_NEAR(p.z, std::sqrt(1 - 0.09) - 0.02, 0.01);
    }
}

TEST_F(Scripted, ACircleHoversOverDropsAndNeverJumps)
{
    // About the top of a ring lying flat: over the hole there is nothing, and its flanks are steep.
    const test::Parsed ring(mesh::torus({.minor_radius = 0.3, .minor_segments = 48}));
    const query::Probe tool(std::vector<Vec3d>{{}});
    const ScriptOptions o{.seconds = 8, .speed = 0.6, .depth = 0.02, .gap = 0.02, .radius = 0.45, .direction = {1, 0, 0.25}};
    const std::vector<Pose> poses = scripted_path(ring.view(), tool, Script::Circle, o);
    double pressed = 0;
    for (std::size_t i = 1; i < poses.size(); ++i) {
        EXPECT_LT(norm(poses[i].translation - poses[i - 1].translation), 1.45 * 0.6 / 1000) << i;
        const Vec3d p = poses[i].translation;
        pressed = std::max(pressed, 0.3 - std::hypot(std::hypot(p.x, p.y) - 1, p.z));
    }
    EXPECT_GT(pressed, 0.01) << "it does touch";
    EXPECT_LT(pressed, 0.04) << "and nowhere deeper than asked, but for the smoothing";
}

TEST_F(Scripted, ALargeToolTouchesWithItsOwnSurface)
{
    std::vector<Vec3d> points;
    for (int i = 0; i < 200; ++i) points.push_back({0, 0, -0.4 + 0.002 * i});  // a rod of 0.4 below its origin
    const query::Probe rod(points);
    const std::vector<Pose> poses =
        scripted_path(model(), rod, Script::Press, {.seconds = 2, .speed = 0.5, .depth = 0.1, .gap = 0.1});
    EXPECT_NEAR(poses.front().translation.z, 1 + 0.4 + 0.1, k_map_error);
    EXPECT_NEAR(poses[1000].translation.z, 1 + 0.4 - 0.1, k_map_error);
}

TEST_F(Scripted, RefusesWhatCannotBeAPath)
{
    const query::Probe tool(std::vector<Vec3d>{{}});
    const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
    for (const ScriptOptions& o : std::vector<ScriptOptions>{{.seconds = 0},
                                                             {.seconds = infinity},
                                                             {.rate = -1},
                                                             {.speed = 0},
                                                             {.speed = nan},
                                                             {.depth = nan},
                                                             {.depth = -0.01, .gap = 0.01},
                                                             {.radius = 0},

                                                             {.direction = {nan, 0, 0}},
                                                             {.seconds = 1e9}})
        EXPECT_THROW((void)scripted_path(model(), tool, Script::Press, o), DeviceError);
}

}  // namespace
}  // namespace sqmap::device
