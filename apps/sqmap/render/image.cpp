#include "image.h"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

namespace sqmap::app {
namespace {

float to_linear(float s) { return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f); }

std::uint8_t to_srgb_byte(float l)
{
    l = std::clamp(l, 0.0f, 1.0f);
    const float s = l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1 / 2.4f) - 0.055f;
    return static_cast<std::uint8_t>(std::lround(255 * s));
}

template <std::size_t N>
Rgb ramp(const std::array<unsigned, N>& stops, float value)
{
    const float x = std::clamp(value, 0.0f, 1.0f) * static_cast<float>(N - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(x), N - 2);
    const float t = x - static_cast<float>(i);
    return (1 - t) * srgb(stops[i]) + t * srgb(stops[i + 1]);
}

struct Glyph {
    char letter;
    std::array<std::uint8_t, 7> rows;  // five bits each, most significant on the left
};

constexpr Glyph k_font[] = {
    {'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},  {'2', {14, 17, 1, 2, 4, 8, 31}},
    {'3', {31, 2, 4, 2, 1, 17, 14}},     {'4', {2, 6, 10, 18, 31, 2, 2}}, {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},   {'8', {14, 17, 17, 14, 17, 17, 14}},
    {'9', {14, 17, 17, 15, 1, 2, 12}},   {'.', {0, 0, 0, 0, 0, 12, 12}},  {'-', {0, 0, 0, 31, 0, 0, 0}},
    {'+', {0, 4, 4, 31, 4, 4, 0}},       {'%', {24, 25, 2, 4, 8, 19, 3}}, {'e', {0, 0, 14, 17, 31, 16, 14}},
};

}  // namespace

Rgb srgb(unsigned hex)
{
    const auto channel = [&](unsigned shift) { return to_linear(static_cast<float>(hex >> shift & 0xff) / 255); };
    return {channel(16), channel(8), channel(0)};
}

Image shrunk(const Image& image, int factor)
{
    Image out(image.width / factor, image.height / factor, {});
    const float weight = 1.0f / static_cast<float>(factor * factor);
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            Rgb sum;
            for (int j = 0; j < factor; ++j)
                for (int i = 0; i < factor; ++i) sum = sum + image.at(x * factor + i, y * factor + j);
            out.at(x, y) = weight * sum;
        }
    return out;
}

Rgb sequential_colour(float value)
{
    static constexpr std::array<unsigned, 9> k_stops{0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c,
                                                     0x28ae80, 0x5ec962, 0xaddc30, 0xfde725};
    return ramp(k_stops, value);
}

Rgb diverging_colour(float value)
{
    static constexpr std::array<unsigned, 9> k_stops{0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7,
                                                     0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b};
    return ramp(k_stops, (value + 1) / 2);
}

Rgb part_colour(std::size_t part)
{
    // Twelve hues of like lightness, then the same again lighter and darker.
    static constexpr std::array<unsigned, 12> k_hues{0x4e79a7, 0xf28e2b, 0x59a14f, 0xe15759, 0x76b7b2, 0xb07aa1,
                                                     0xedc948, 0x9c755f, 0xff9da7, 0x86bcb6, 0xd37295, 0x8cd17d};
    const Rgb base = srgb(k_hues[part % k_hues.size()]);
    switch (part / k_hues.size() % 3) {
        case 1:
            return 0.5f * base + 0.5f * srgb(0xffffff);
        case 2:
            return 0.5f * base;
        default:
            return base;
    }
}

void draw_text(Image& image, int x, int y, int dot, const char* text, Rgb colour)
{
    for (; *text != '\0'; ++text, x += 6 * dot)
        for (const Glyph& glyph : k_font) {
            if (glyph.letter != *text) continue;
            for (int row = 0; row < 7 * dot; ++row)
                for (int column = 0; column < 5 * dot; ++column) {
                    const bool set = glyph.rows[static_cast<std::size_t>(row / dot)] >> (4 - column / dot) & 1;
                    if (set && x + column >= 0 && x + column < image.width && y + row >= 0 && y + row < image.height)
                        image.at(x + column, y + row) = colour;
                }
        }
}

void draw_scale(Image& image, Rgb (*colour)(float), float colour_low, float colour_high, const char* low, const char* high)
{
    const int dot = std::max(1, image.height / 360), margin = 12 * dot, bar_width = 10 * dot;
    const int text_width = 6 * dot * static_cast<int>(std::max(std::strlen(low), std::strlen(high)));
    const int right = image.width - margin, left = right - bar_width;
    const int top = image.height / 4, bottom = image.height - image.height / 4;
    for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x) {
            if (x < 0) continue;
            const float t = static_cast<float>(bottom - 1 - y) / static_cast<float>(bottom - top - 1);
            image.at(x, y) = colour(colour_low + t * (colour_high - colour_low));
        }
    const Rgb ink = srgb(0x333333);
    draw_text(image, std::max(0, right - text_width), top - 12 * dot, dot, high, ink);
    draw_text(image, std::max(0, right - text_width), bottom + 5 * dot, dot, low, ink);
}

void write_png(const std::filesystem::path& path, const Image& image)
{
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * image.pixels.size());
    for (const Rgb& p : image.pixels) bytes.insert(bytes.end(), {to_srgb_byte(p.r), to_srgb_byte(p.g), to_srgb_byte(p.b)});
    png_image header{};
    header.version = PNG_IMAGE_VERSION;
    header.width = static_cast<png_uint_32>(image.width);
    header.height = static_cast<png_uint_32>(image.height);
    header.format = PNG_FORMAT_RGB;
    if (png_image_write_to_file(&header, path.c_str(), 0, bytes.data(), 0, nullptr) == 0)
        throw std::runtime_error(path.string() + ": cannot be written");
}

}  // namespace sqmap::app
