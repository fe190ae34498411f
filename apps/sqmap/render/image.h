// A picture in linear light and its PNG file.
#pragma once

#include <filesystem>
#include <vector>

namespace sqmap::app {

struct Rgb {
    float r = 0, g = 0, b = 0;

    friend constexpr Rgb operator*(float s, Rgb c) { return {s * c.r, s * c.g, s * c.b}; }
    friend constexpr Rgb operator+(Rgb a, Rgb b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
    friend constexpr Rgb operator*(Rgb a, Rgb b) { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
};

/// Linear-light colour of an sRGB one given as 0xRRGGBB.
[[nodiscard]] Rgb srgb(unsigned hex);

struct Image {
    int width = 0, height = 0;
    std::vector<Rgb> pixels;  ///< height by width, row-major from the top left, linear light

    Image() = default;
    Image(int w, int h, Rgb fill) : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill)
    {
    }
    Rgb& at(int x, int y)
    {
        return pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    }
    [[nodiscard]] Rgb at(int x, int y) const { return const_cast<Image*>(this)->at(x, y); }
};

/// Mean of each factor by factor block.
[[nodiscard]] Image shrunk(const Image& image, int factor);

/// Dark blue over green to yellow, even in lightness, for a value in [0, 1] (after matplotlib's viridis).
[[nodiscard]] Rgb sequential_colour(float value);
/// Blue through white to red for a value in [-1, 1].
[[nodiscard]] Rgb diverging_colour(float value);
/// A colour for a part: neighbours in number are far apart in hue.
[[nodiscard]] Rgb part_colour(std::size_t part);

/// A vertical colour bar with its ends written beside it, along the right edge.
void draw_scale(Image& image, Rgb (*colour)(float), float colour_low, float colour_high, const char* low, const char* high);

/// Text of digits, signs and a few letters in a 5 by 7 dot font, top left at (x, y); each dot is `dot` pixels wide.
void draw_text(Image& image, int x, int y, int dot, const char* text, Rgb colour);

/// @throw std::runtime_error when the file cannot be written
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace sqmap::app
