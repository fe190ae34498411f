#include "common/render/image.h"

#include "io/replace_file.h"
#include "sqmap/io/model_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
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
    {'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},      {'2', {14, 17, 1, 2, 4, 8, 31}},
    {'3', {31, 2, 4, 2, 1, 17, 14}},     {'4', {2, 6, 10, 18, 31, 2, 2}},     {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},       {'8', {14, 17, 17, 14, 17, 17, 14}},
    {'9', {14, 17, 17, 15, 1, 2, 12}},   {'.', {0, 0, 0, 0, 0, 12, 12}},      {',', {0, 0, 0, 0, 12, 4, 8}},
    {':', {0, 12, 12, 0, 12, 12, 0}},    {'-', {0, 0, 0, 31, 0, 0, 0}},       {'+', {0, 4, 4, 31, 4, 4, 0}},
    {'%', {24, 25, 2, 4, 8, 19, 3}},     {'/', {0, 1, 2, 4, 8, 16, 0}},       {'_', {0, 0, 0, 0, 0, 0, 31}},
    {'<', {2, 4, 8, 16, 8, 4, 2}},       {'>', {8, 4, 2, 1, 2, 4, 8}},        {'^', {4, 10, 17, 0, 0, 0, 0}},
    {'(', {2, 4, 8, 8, 8, 4, 2}},        {')', {8, 4, 2, 2, 2, 4, 8}},        {'a', {0, 0, 14, 1, 15, 17, 15}},
    {'b', {16, 16, 22, 25, 17, 17, 30}}, {'c', {0, 0, 14, 16, 16, 17, 14}},   {'d', {1, 1, 13, 19, 17, 17, 15}},
    {'e', {0, 0, 14, 17, 31, 16, 14}},   {'f', {6, 9, 8, 28, 8, 8, 8}},       {'g', {15, 17, 17, 17, 15, 1, 14}},
    {'h', {16, 16, 22, 25, 17, 17, 17}}, {'i', {4, 0, 12, 4, 4, 4, 14}},      {'j', {2, 0, 6, 2, 2, 18, 12}},
    {'k', {16, 16, 18, 20, 24, 20, 18}}, {'l', {12, 4, 4, 4, 4, 4, 14}},      {'m', {0, 0, 26, 21, 21, 17, 17}},
    {'n', {0, 0, 22, 25, 17, 17, 17}},   {'o', {0, 0, 14, 17, 17, 17, 14}},   {'p', {30, 17, 17, 17, 30, 16, 16}},
    {'q', {15, 17, 17, 17, 15, 1, 1}},   {'r', {0, 0, 22, 25, 16, 16, 16}},   {'s', {0, 0, 14, 16, 14, 1, 30}},
    {'t', {8, 8, 28, 8, 8, 9, 6}},       {'u', {0, 0, 17, 17, 17, 19, 13}},   {'v', {0, 0, 17, 17, 17, 10, 4}},
    {'w', {0, 0, 17, 17, 21, 21, 10}},   {'x', {0, 0, 17, 10, 4, 10, 17}},    {'y', {17, 17, 17, 17, 15, 1, 14}},
    {'z', {0, 0, 31, 2, 4, 8, 31}},      {'G', {14, 17, 16, 23, 17, 17, 15}}, {'R', {30, 17, 17, 30, 20, 18, 17}},
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

Image beside(const Image& left, const Image& right)
{
    Image out(left.width + right.width, std::max(left.height, right.height), srgb(0xffffff));
    const auto paste = [&](const Image& image, int at) {
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x) out.at(at + x, y) = image.at(x, y);
    };
    paste(left, 0);
    paste(right, left.width);
    return out;
}

Rgb sequential_colour(float value)
{
    static constexpr std::array<unsigned, 9> k_stops{0x440154, 0x472d7b, 0x3b528b, 0x2c728e, 0x21918c,
                                                     0x28ae80, 0x5ec962, 0xaddc30, 0xfde725};
    return ramp(k_stops, value);
}

Rgb error_colour(float value)
{
    static constexpr std::array<unsigned, 7> k_stops{0xf4f1ea, 0xfdeab8, 0xfdcc7a, 0xfc9a4b, 0xef5a3a, 0xc21e2c, 0x6d0a1c};
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
                                                     0xedc948, 0x9c755f, 0xff9da7, 0x8fc7ea, 0xa8a83c, 0xc9b2e0};
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

void draw_text(Image& image, int x, int y, int dot, std::string_view text, Rgb colour)
{
    for (const char letter : text) {
        const int drop = std::string_view("gpqy").find(letter) != std::string_view::npos ? 2 : (letter == ',' ? 1 : 0);
        for (const Glyph& glyph : k_font)
            for (int row = 0; glyph.letter == letter && row < 7; ++row)
                for (int column = 0; column < 5; ++column)
                    if ((glyph.rows[static_cast<std::size_t>(row)] >> (4 - column) & 1) != 0)
                        fill(image, {x + column * dot, y + (row + drop) * dot, dot, dot}, colour);
        x += 6 * dot;
    }
}

int text_width(std::string_view text, int dot) { return text.empty() ? 0 : (6 * static_cast<int>(text.size()) - 1) * dot; }

int text_dot(const Image& image) { return std::max(1, std::min(image.width, image.height) / 350); }

void fill(Image& image, Box box, Rgb colour)
{
    for (int y = std::max(box.top, 0); y < std::min(box.top + box.height, image.height); ++y)
        for (int x = std::max(box.left, 0); x < std::min(box.left + box.width, image.width); ++x) image.at(x, y) = colour;
}

int scale_width(const Image& image, const Scale& scale)
{
    const int dot = text_dot(image);
    int widest = 0;
    for (const Tick& tick : scale.ticks) widest = std::max(widest, text_width(tick.text, dot));
    widest += 18 * dot;
    for (const std::string& line : scale.title) widest = std::max(widest, text_width(line, dot));
    for (const Swatch& s : scale.swatches) widest = std::max(widest, 11 * dot + text_width(s.text, dot));
    return widest + 12 * dot;
}

void draw_scale(Image& image, const Scale& scale)
{
    const int dot = text_dot(image), line_height = 11 * dot, bar_width = 10 * dot;
    const int left = image.width - scale_width(image, scale) + 4 * dot;
    const int lines = static_cast<int>(scale.title.size()), swatches = static_cast<int>(scale.swatches.size());
    const int top = image.height / 5 + lines * line_height, bottom = image.height - image.height / 5 - swatches * line_height;
    const Rgb ink = srgb(0x30343a);
    for (int i = 0; i < lines; ++i)
        draw_text(image, left, top - (lines - i) * line_height - 5 * dot, dot, scale.title[static_cast<std::size_t>(i)], ink);
    for (int y = top; scale.colour != nullptr && y < bottom; ++y) {
        const float t = static_cast<float>(bottom - 1 - y) / static_cast<float>(std::max(bottom - top - 1, 1));
        fill(image, {left, y, bar_width, 1}, scale.colour(scale.low + t * (scale.high - scale.low)));
    }
    for (const Tick& tick : scale.ticks) {
        const float t = (tick.at - scale.low) / (scale.high - scale.low);
        const int y = bottom - 1 - static_cast<int>(std::lround(t * static_cast<float>(bottom - top - 1)));
        fill(image, {left + bar_width, y, 3 * dot, dot}, ink);
        draw_text(image, left + bar_width + 7 * dot, y - 3 * dot, dot, tick.text, ink);
    }
    for (int i = 0; i < swatches; ++i) {
        const Swatch& s = scale.swatches[static_cast<std::size_t>(i)];
        const int y = bottom + (i + 1) * line_height;
        fill(image, {left, y, 8 * dot, 7 * dot}, s.colour);
        draw_text(image, left + 11 * dot, y, dot, s.text, ink);
    }
}

std::string png_bytes(const Image& image)
{
    std::vector<std::uint8_t> pixels;
    pixels.reserve(3 * image.pixels.size());
    for (const Rgb& p : image.pixels) pixels.insert(pixels.end(), {to_srgb_byte(p.r), to_srgb_byte(p.g), to_srgb_byte(p.b)});
    return png_bytes(
        {static_cast<std::uint32_t>(image.width), static_cast<std::uint32_t>(image.height), PngFormat::Rgb8, pixels});
}

void write_png(const std::filesystem::path& path, const Image& image)
{
    const std::string png = png_bytes(image);
    try {
        io::replace_file(path, std::as_bytes(std::span(png)));
    } catch (const io::ModelFileError& e) {
        throw ImageError(e.what());
    }
}

}  // namespace sqmap::app
