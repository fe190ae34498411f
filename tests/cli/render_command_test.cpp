// Pictures by `sqmap render`: their size, what they show, and what is refused.
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

namespace {

namespace fs = std::filesystem;

struct Pixel {
    int r = 0, g = 0, b = 0;
    auto operator<=>(const Pixel&) const = default;
};

struct Picture {
    int width = 0, height = 0;
    std::vector<Pixel> pixels;
    [[nodiscard]] Pixel at(int x, int y) const { return pixels[static_cast<std::size_t>(y * width + x)]; }
    template <class Wanted>
    [[nodiscard]] double share(Wanted wanted) const
    {
        return static_cast<double>(std::count_if(pixels.begin(), pixels.end(), wanted)) / static_cast<double>(pixels.size());
    }
};

/// A picture's ground is near white; shaded subjects are darker or coloured.
bool is_ground(Pixel p) { return std::min({p.r, p.g, p.b}) >= 240; }
bool is_blank_line(const Picture& picture, int column)
{
    for (int y = 0; y < picture.height; ++y)
        if (!is_ground(picture.at(column, y))) return false;
    return true;
}

int run(const std::string& arguments)
{
    const int status = std::system((std::string(SQMAP_PROGRAM) + " " + arguments + " >/dev/null 2>&1").c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string bytes_of(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

class RenderCommand : public testing::Test {
protected:
    void SetUp() override
    {
        // One folder for each test of each run: several may be under way on one machine.
        folder_ = fs::temp_directory_path() / (std::string("sqmap_render_") + std::to_string(::getpid()) + "_" +
                                               testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }

    std::string shape(const std::string& name) const
    {
        EXPECT_EQ(run("shapes " + name + " -o " + path(name + ".obj")), 0);
        return path(name + ".obj");
    }
    /// Coarse, where the options do not say otherwise: most pictures show the same.
    std::string model(const std::string& name, const std::string& options = " --target-error 5") const
    {
        EXPECT_EQ(run("bake " + shape(name) + " -o " + path(name + ".sqmap") + options), 0);
        return path(name + ".sqmap");
    }
    Picture picture(const std::string& arguments) const
    {
        Picture out;
        EXPECT_EQ(run("render " + arguments + " -o " + path("out.png")), 0) << arguments;
        png_image header{};
        header.version = PNG_IMAGE_VERSION;
        EXPECT_NE(png_image_begin_read_from_file(&header, path("out.png").c_str()), 0) << header.message;
        header.format = PNG_FORMAT_RGB;
        std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(header));
        EXPECT_NE(png_image_finish_read(&header, nullptr, bytes.data(), 0, nullptr), 0) << header.message;
        out.width = static_cast<int>(header.width);
        out.height = static_cast<int>(header.height);
        for (std::size_t i = 0; i + 2 < bytes.size(); i += 3) out.pixels.push_back({bytes[i], bytes[i + 1], bytes[i + 2]});
        return out;
    }

    fs::path folder_;
};

TEST_F(RenderCommand, DrawsEveryKindOfAModel)
{
    const std::string dumbbell = model("dumbbell");
    for (const std::string what : {"mesh", "parts", "superquadrics", "bounds", "protrusion", "curvature", "map", "error"}) {
        const Picture p = picture(dumbbell + " --what " + what + " --size 240x160");
        EXPECT_EQ(p.width, 240) << what;
        EXPECT_EQ(p.height, 160) << what;
        const double ground = p.share(is_ground);
        EXPECT_GT(ground, 0.1) << what;
        EXPECT_LT(ground, 0.9) << what;
        EXPECT_GT(std::set<Pixel>(p.pixels.begin(), p.pixels.end()).size(), 50u) << what;
    }
}

TEST_F(RenderCommand, UnrollsNormalMapsToo)
{
    const std::string bent = model("bent", " --projection normal --exact --grid 17x32");
    const Picture p = picture(bent + " --what map,error,regions --size 240x160");
    EXPECT_EQ(p.width, 720);
    EXPECT_EQ(p.height, 160);
    EXPECT_GT(std::set<Pixel>(p.pixels.begin(), p.pixels.end()).size(), 50u);
}

TEST_F(RenderCommand, DrawsEveryKindOfAMesh)
{
    const std::string torus = shape("torus");
    for (const std::string what :
         {"mesh", "parts", "superquadrics", "protrusion", "features", "locales", "strength", "curvature", "hyperbolic"}) {
        const Picture p = picture(torus + " --up z --what " + what + " --size 200x150");
        const double ground = p.share(is_ground);
        EXPECT_GT(ground, 0.1) << what;
        EXPECT_LT(ground, 0.9) << what;
    }
}

TEST_F(RenderCommand, FramesASphereWithItsMargin)
{
    // The sphere's silhouette fills 0.94 of the shorter side, centred.
    const Picture p = picture(shape("sphere") + " --size 300x200");
    int left = 0, right = p.width - 1;
    while (left < p.width && is_blank_line(p, left)) ++left;
    while (right > left && is_blank_line(p, right)) --right;
    EXPECT_NEAR(right + 1 - left, 0.94 * 200, 3);
    EXPECT_NEAR(0.5 * (left + right + 1), 150, 2);
}

TEST_F(RenderCommand, TurnsTheMeshUpright)
{
    // The dumb-bell's axis is z: seen from the side it is taller than wide only if z is up.
    const auto extent = [](const Picture& p) {
        int columns = 0;
        for (int x = 0; x < p.width; ++x) columns += is_blank_line(p, x) ? 0 : 1;
        return columns;
    };
    const std::string dumbbell = shape("dumbbell");
    const int upright = extent(picture(dumbbell + " --up z --azimuth 0 --elevation 0 --size 200x200"));
    const int lying = extent(picture(dumbbell + " --up y --azimuth 90 --elevation 0 --size 200x200"));
    EXPECT_LT(upright, 100);
    EXPECT_GT(lying, 180);
}

TEST_F(RenderCommand, ColoursPartsApart)
{
    // One part leaves one hue; a torus is cut in several.
    const auto hues = [](const Picture& p) {
        std::set<int> out;
        for (const Pixel& q : p.pixels) {
            const int largest = std::max({q.r, q.g, q.b}), least = std::min({q.r, q.g, q.b});
            if (largest < 100 || largest - least < 60) continue;
            const double h = std::atan2(std::sqrt(3.0) * (q.g - q.b), 2.0 * q.r - q.g - q.b);
            out.insert(static_cast<int>(std::lround(h * 6 / 3.14159265)));
        }
        return out.size();
    };
    EXPECT_LE(hues(picture(model("sphere") + " --size 120x120")), 2u);
    EXPECT_GE(hues(picture(model("torus") + " --up z --elevation 60 --size 120x120")), 3u);
}

TEST_F(RenderCommand, ReddensWhereTheMapIsWrong)
{
    const auto is_red = [](Pixel p) { return p.r - p.g > 60 && p.r - p.b > 60; };
    const std::string ball = model("sphere", "");
    const std::string view = " --what error --size 200x200";
    EXPECT_LT(picture(ball + " " + path("sphere.obj") + view).share(is_red), 0.1);
    // The same ball, four thousandths larger: every depth is off by 0.2 % of R_max.
    std::ifstream in(path("sphere.obj"));
    std::ofstream out(path("larger.obj"));
    for (std::string word; in >> word;) {
        if (word == "v") {
            double x = 0, y = 0, z = 0;
            in >> x >> y >> z;
            out << "v " << 1.004 * x << ' ' << 1.004 * y << ' ' << 1.004 * z << '\n';
        } else if (word == "f") {
            std::string a, b, c;
            in >> a >> b >> c;
            out << "f " << a << ' ' << b << ' ' << c << '\n';
        }
    }
    out.close();
    EXPECT_GT(picture(ball + " " + path("larger.obj") + view).share(is_red), 0.25);
}

TEST_F(RenderCommand, TakesAMeshForAModelWithoutExactLayer)
{
    const std::string bare = model("dumbbell", " --no-exact");
    EXPECT_EQ(run("render " + bare + " --what parts -o " + path("out.png")), 64);
    EXPECT_FALSE(fs::exists(path("out.png")));
    const Picture p = picture(bare + " " + path("dumbbell.obj") + " --what parts,error --size 150x100");
    EXPECT_EQ(p.width, 300);
    EXPECT_EQ(p.height, 100);
}

TEST_F(RenderCommand, DrawsTheSameBytesTwice)
{
    const std::string torus = model("torus");
    ASSERT_EQ(run("render " + torus + " --what superquadrics,error --size 120x100 -o " + path("a.png")), 0);
    ASSERT_EQ(run("render " + torus + " --what superquadrics,error --size 120x100 -o " + path("b.png")), 0);
    EXPECT_EQ(bytes_of(path("a.png")), bytes_of(path("b.png")));
}

TEST_F(RenderCommand, RefusesBadInputWith2AndLeavesThePictureAlone)
{
    std::ofstream(path("out.png")) << "kept";
    std::ofstream(path("bad.sqmap")) << "no model";
    std::ofstream(path("flat.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n";
    EXPECT_EQ(run("render " + path("bad.sqmap") + " -o " + path("out.png")), 2);
    EXPECT_EQ(run("render " + path("flat.obj") + " -o " + path("out.png")), 2);
    EXPECT_EQ(bytes_of(path("out.png")), "kept");
    EXPECT_EQ(run("render " + shape("sphere") + " --size 64x64 -o " + path("absent/out.png")), 2);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}), 4);  // no temporary file stays
}

TEST_F(RenderCommand, WrongUsageIs64)
{
    const std::string ball = shape("sphere");
    const std::string out = " -o " + path("out.png");
    EXPECT_EQ(run("render " + ball), 64);
    EXPECT_EQ(run("render " + path("absent.obj") + out), 64);
    EXPECT_EQ(run("render " + ball + " --what beauty" + out), 64);
    EXPECT_EQ(run("render " + ball + " --what error" + out), 64);
    EXPECT_EQ(run("render " + ball + " --what map" + out), 64);
    EXPECT_EQ(run("render " + ball + " --up w" + out), 64);
    EXPECT_EQ(run("render " + ball + " --size 10" + out), 64);
    EXPECT_EQ(run("render " + ball + " --size 0x100000" + out), 64);
}

}  // namespace
