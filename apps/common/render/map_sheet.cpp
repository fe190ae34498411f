// Every part's map unrolled (Fig. 4c). Central: the six faces of its cube as a cross, drawn from what layer 3 answers.
// Normal: the stored grid, longitude omega across, latitude eta up.
#include "common/render/pictures.h"
#include "common/render/unrolled.h"
#include "math/percentile.h"
#include "sqmap/math/assert.h"
#include "sqmap/query/point.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <string>
#include <vector>

namespace sqmap::app {
namespace {

const Rgb k_ink = srgb(0x30343a);

/// The distance that is drawn white: the 99th percentile, so that a few deep rays do not leave the rest black.
float brightest(const std::vector<float>& distance)
{
    std::vector<float> hits;
    std::copy_if(distance.begin(), distance.end(), std::back_inserter(hits), [](float d) { return d >= 0; });
    if (hits.empty()) return 1;
    return std::max(percentile(hits, 99), 1e-9f);
}

Rgb grey(float t)  // even steps to the eye
{
    const float g = std::pow(std::clamp(t, 0.0f, 1.0f), 2.2f);
    return {g, g, g};
}

/// Draws the legend of greys and colours from the line at `top` on, in as many lines as the width needs; entries follow the
/// grey bar. Returns how much lower the last line is than the first.
int draw_legend(Image& image, int top, int dot, const std::vector<Swatch>& entries)
{
    const int left = 6 * dot, bar = 40 * dot;
    int x = left, y = top;
    const auto entry = [&](int mark, const std::string& text) {
        const int width = mark + 4 * dot + text_width(text, dot);
        if (x > left && x + width > image.width) {
            x = left;
            y += 11 * dot;
        }
        draw_text(image, x + mark + 4 * dot, y, dot, text, k_ink);
        const int at = x;
        x += width + 12 * dot;
        return at;
    };
    const int bar_left = entry(bar, "surface below superquadric, % of R_max: black 0, white as given");
    for (int i = 0; i < bar; ++i)
        fill(image, {bar_left + i, y, 1, 7 * dot}, grey(static_cast<float>(i) / static_cast<float>(bar)));
    for (const Swatch& s : entries) {
        const int at = entry(8 * dot, s.text);
        fill(image, {at, y, 8 * dot, 7 * dot}, s.colour);
    }
    return y - top;
}

}  // namespace

Image map_picture(const Subject& subject, int width, int height)
{
    SQMAP_ASSERT(subject.model.has_value());
    const model::ModelView& model = subject.model->view();
    const bool central = !paper::is_paper(model);
    const int count = static_cast<int>(model.parts.size());
    Image image(width, height, srgb(0xffffff));
    const Rgb no_surface = srgb(0x3d5a80), cap = srgb(0xb5652b), line = srgb(0x9aa0a6);
    std::vector<Swatch> entries{{no_surface, "no surface on this ray"}};
    if (!central) entries.push_back({cap, "starts inside the solid"});
    const int dot = std::max(1, text_dot(image) / 2), gap = 6 * dot;
    const int legend = (6 + 11) * dot + draw_legend(image, height, dot, entries);
    // A cross leaves room for words in its corner; a grid has them above.
    const int wide = central ? k_cross_columns : 2, high = central ? k_cross_rows : 1, words_above = central ? 0 : 12 * dot;
    int columns = 1, side = 0;
    for (int c = 1; c <= count; ++c) {  // the arrangement with the largest maps
        const int fits =
            std::min((width / c - gap) / wide, ((height - legend) / ((count + c - 1) / c) - gap - words_above) / high);
        if (fits > side) {
            side = fits;
            columns = c;
        }
    }
    if (side < 4) throw SubjectError("--size is too small for " + std::to_string(count) + " maps");
    const int rows = (count + columns - 1) / columns;

    for (int part = 0; part < count; ++part) {
        const int left = part % columns * width / columns + gap / 2, top = part / columns * (height - legend) / rows + gap / 2;
        const auto index = static_cast<std::uint32_t>(part);
        const Unrolled map = central ? unrolled_central(model, index, side) : unrolled_normal(model, index, 2 * side, side);
        const float max = brightest(map.distance);
        auto value = map.distance.begin();
        for (int y = 0; y < map.height; ++y)
            for (int x = 0; x < map.width; ++x, ++value) {
                if (*value == k_paper) continue;
                const bool edge = central && (x % side == 0 || y % side == 0);  // so that black faces show
                image.at(left + x, top + words_above + y) = edge                 ? line
                                                            : *value == k_no_hit ? no_surface
                                                            : *value == k_cap    ? cap
                                                                                 : grey(*value / max);
            }
        char white[32];
        std::snprintf(white, sizeof white, "white %.2g%%", 100 * static_cast<double>(max) / model.header.r_max);
        const std::string name = "part " + std::to_string(part);
        const int words = central ? std::clamp(2 * side / (14 * 6), 1, 2 * dot) : dot;
        const int words_left = central ? left + 2 * side + 4 * words : left;
        fill(image, {words_left, top, 8 * words, 7 * words}, part_colour(static_cast<std::size_t>(part)));
        draw_text(image, words_left + 11 * words, top, words, central ? name : name + ": " + white, k_ink);
        if (central) draw_text(image, words_left, top + 11 * words, words, white, k_ink);
    }

    draw_legend(image, height - legend + 6 * dot, dot, entries);
    return image;
}

}  // namespace sqmap::app
