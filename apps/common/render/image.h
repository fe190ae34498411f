// A picture in linear light and its PNG file.
#pragma once

#include "common/render/png.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sqmap::app {

struct Rgb {
    float r = 0, g = 0, b = 0;

    friend constexpr Rgb operator*(float s, Rgb c) { return {s * c.r, s * c.g, s * c.b}; }
    friend constexpr Rgb operator+(Rgb c, Rgb d) { return {c.r + d.r, c.g + d.g, c.b + d.b}; }
    friend constexpr Rgb operator*(Rgb c, Rgb d) { return {c.r * d.r, c.g * d.g, c.b * d.b}; }
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
/// Cream over orange to dark red for a value in [0, 1]: where nothing is wrong the surface stays plain.
[[nodiscard]] Rgb error_colour(float value);
/// Blue through white to red for a value in [-1, 1].
[[nodiscard]] Rgb diverging_colour(float value);
/// A colour for a part: neighbours in number are far apart in hue.
[[nodiscard]] Rgb part_colour(std::size_t part);

/// right beside left, tops level.
[[nodiscard]] Image beside(const Image& left, const Image& right);

struct Box {
    int left = 0, top = 0, width = 0, height = 0;  ///< pixels
};
void fill(Image& image, Box box, Rgb colour);

/// Text of lower-case letters, digits, signs and a few capitals in a 5 by 7 dot font, top left at (x, y); each dot is
/// `dot` pixels wide. A letter that the font lacks leaves a gap.
void draw_text(Image& image, int x, int y, int dot, std::string_view text, Rgb colour);
[[nodiscard]] int text_width(std::string_view text, int dot);
/// A dot that suits the picture's size.
[[nodiscard]] int text_dot(const Image& image);

struct Tick {
    float at;
    std::string text;
};
struct Swatch {
    Rgb colour;
    std::string text;
};

/// The legend of a picture's colours.
struct Scale {
    std::vector<std::string> title;  ///< lines above the bar
    Rgb (*colour)(float) = nullptr;  ///< null: no bar
    float low = 0, high = 1;         ///< the colour function's argument at the bar's ends
    std::vector<Tick> ticks;
    std::vector<Swatch> swatches{};  ///< colours outside the bar, listed below it
};

/// A vertical colour bar with its title, ticks and swatches, along the right edge.
void draw_scale(Image& image, const Scale& scale);
/// Pixels along the right edge that it needs.
[[nodiscard]] int scale_width(const Image& image, const Scale& scale);

/// A PNG file. @throw ImageError for a picture without pixels
[[nodiscard]] std::string png_bytes(const Image& image);

/// Writes through a temporary file beside path and a rename: path is never partly written.
/// @throw ImageError when the file cannot be written
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace sqmap::app
