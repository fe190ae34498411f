#include "touch/surface_texture.h"

#include "touch/setup.h"

#include <png.h>

#include <bit>
#include <cmath>
#include <map>

namespace sqmap::app {
namespace {

constexpr double k_two_pi = 6.283185307179586;
constexpr std::uint32_t k_procedure_values = 32, k_max_side = 4096;

// Heights over a period, 0 at the highest, -1 at the deepest.
double ridges(double x, double, double) { return 0.5 * (std::cos(k_two_pi * x) - 1); }
double weave(double x, double y, double z)
{
    return 0.5 * (std::cos(k_two_pi * x) * std::cos(k_two_pi * y) * std::cos(k_two_pi * z) - 1);
}
double bumps(double x, double y, double z)
{
    return (std::cos(k_two_pi * x) + std::cos(k_two_pi * y) + std::cos(k_two_pi * z) - 3) / 6;
}
const std::map<std::string, double (*)(double, double, double)> k_procedures{
    {"ridges", ridges}, {"weave", weave}, {"bumps", bumps}};

/// Grey values of a square PNG, row by row.
std::vector<std::uint8_t> read_grey(const std::string& option, const std::filesystem::path& path, std::uint32_t& side)
{
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    if (png_image_begin_read_from_file(&image, path.c_str()) == 0)
        throw BadTouch(option + ": cannot be read as PNG: " + image.message + "\n  cure: save the image as a PNG");
    image.format = PNG_FORMAT_GRAY;
    if (image.width != image.height || image.width < 2 || image.width > k_max_side) {
        const std::string size = std::to_string(image.width) + " by " + std::to_string(image.height);
        png_image_free(&image);
        throw BadTouch(option + ": the image is " + size + " pixels, it must be square, 2 to " + std::to_string(k_max_side) +
                       " a side\n  cure: crop it");
    }
    side = image.width;
    std::vector<std::uint8_t> grey(PNG_IMAGE_SIZE(image));
    const png_color black{};
    if (png_image_finish_read(&image, &black, grey.data(), 0, nullptr) == 0)
        throw BadTouch(option + ": cannot be read as PNG: " + image.message + "\n  cure: save the image as a PNG");
    return grey;
}

}  // namespace

SurfaceTexture make_texture(const TextureOptions& o, const std::filesystem::path& beside)
{
    SurfaceTexture t;
    if (o.kind == "none" || o.kind.empty()) return t;
    const std::string option = "--texture " + o.kind;
    if (o.kind == "gaussian") {
        t.texture = haptic::gaussian_texture({.seed = o.seed, .amplitude = 0.5 * o.depth, .wavelength = o.wavelength}, t.values);
    } else if (o.kind.starts_with("image:")) {
        std::uint32_t side = 0;
        const std::vector<std::uint8_t> grey = read_grey(option, found(o.kind.substr(6), beside), side);
        t.texture = haptic::image_texture(grey, {.depth = o.depth, .step = o.wavelength}, t.values);
    } else if (const auto at = k_procedures.find(o.kind); at != k_procedures.end()) {
        t.texture = haptic::procedural_texture(at->second, k_procedure_values, o.wavelength / k_procedure_values, t.values);
        for (float& v : t.values) v = static_cast<float>(o.depth * static_cast<double>(v));
        t.texture.values = t.values;
    } else {
        throw BadTouch(option + ": there is no such texture\n  cure: none, gaussian, image:FILE.png, ridges, weave or bumps");
    }
    t.hash = 0xcbf29ce484222325u;
    for (const float v : t.values) t.hash = (t.hash ^ std::bit_cast<std::uint32_t>(v)) * 0x100000001b3u;
    t.hash |= 1u;
    return t;
}

}  // namespace sqmap::app
