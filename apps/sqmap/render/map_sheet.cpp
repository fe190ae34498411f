// Every part's central map unrolled (Fig. 4c): the six faces of its cube as a cross, drawn from what layer 3 answers.
#include "pictures.h"
#include "sqmap/query/query.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

namespace sqmap::app {
namespace {

constexpr float k_no_hit = -1;

/// A face of the cube as the cross shows it, seen from outside: direction = out + u right + v up, u and v in [-1, 1].
struct Face {
    Vec3f out, right, up;
    int column, row;  // place in the cross
};

// Four faces around z, and the two that z leaves through above and below the second.
constexpr std::array<Face, 6> k_cross{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 0, 1},
                                       {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, 1, 1},
                                       {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, 2, 1},
                                       {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}, 3, 1},
                                       {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, 1, 0},
                                       {{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}, 1, 2}}};
constexpr int k_columns = 4, k_rows = 3;

/// How far along q (largest coordinate 1) the part's chart answers: where its convex domain ends.
float domain_end(const model::Part& part, Vec3f q)
{
    const float v[9] = {q.x, q.y, q.z, q.x + q.y, q.x - q.y, q.x + q.z, q.x - q.z, q.y + q.z, q.y - q.z};
    float end = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 9; ++i)
        if (v[i] != 0) end = std::min(end, (v[i] > 0 ? part.chart_hi[i] : part.chart_lo[i]) / v[i]);
    return end;
}

/// Distance from the superquadric down to the outermost surface on the ray from the chart's centre, model units.
float distance_below(const model::ModelView& model, std::uint32_t index, Vec3f q)
{
    const model::Part& part = model.parts[index];
    const shape::Superquadricf sq = model::superquadric_of(part);
    const Vec3f centre = model::vec3(part.chart_centre);
    const Vec3f step = part.a[0] * q.x * model::vec3(part.rotation) + part.a[1] * q.y * model::vec3(part.rotation + 3) +
                       part.a[2] * q.z * model::vec3(part.rotation + 6);
    const float end = domain_end(part, q);
    if (!(end > 0) || !std::isfinite(end)) return k_no_hit;
    // The crossing nearest to the domain's end is the outermost one; a little less, for rounding.
    const float from = 0.9999f * end;
    float to_surface = 0;
    if (!query::distance_along_projection(model, index, centre + from * step, query::Layer::Three, to_surface)) return k_no_hit;
    // Where the superquadric ends on the ray: bent ones may be left and met again, the last exit counts.
    float inside = 0, outside = 3;
    for (float r = outside; r > 0; r -= 0.125f)
        if (shape::implicit(sq, centre + r * step) <= 1) {
            inside = r;
            break;
        } else {
            outside = r;
        }
    for (int i = 0; i < 16; ++i) {
        const float middle = 0.5f * (inside + outside);
        (shape::implicit(sq, centre + middle * step) <= 1 ? inside : outside) = middle;
    }
    return std::max(0.0f, (inside - from) * norm(step) - to_surface);
}

/// What is drawn white: the 99th percentile, so that a few deep rays do not leave the rest black.
float brightest(const std::vector<float>& distance)
{
    std::vector<float> hits;
    std::copy_if(distance.begin(), distance.end(), std::back_inserter(hits), [](float d) { return d != k_no_hit; });
    if (hits.empty()) return 1;
    const auto at = hits.begin() + static_cast<std::ptrdiff_t>((hits.size() - 1) * 99 / 100);
    std::nth_element(hits.begin(), at, hits.end());
    return std::max(*at, 1e-9f);
}

}  // namespace

Image map_picture(const Subject& subject, int width, int height)
{
    const model::ModelView& model = subject.model->view();
    if (static_cast<model::Projection>(model.header.projection) != model::Projection::Central)
        throw SubjectError("only central maps can be unrolled");
    const int count = static_cast<int>(model.parts.size());
    Image image(width, height, srgb(0xffffff));
    const int dot = std::max(1, text_dot(image) / 2), legend = 24 * dot, gap = 6 * dot;
    // The arrangement with the largest crosses.
    int columns = 1, side = 0;
    for (int c = 1; c <= count; ++c) {
        const int fits = std::min((width / c - gap) / k_columns, ((height - legend) / ((count + c - 1) / c) - gap) / k_rows);
        if (fits > side) {
            side = fits;
            columns = c;
        }
    }
    if (side < 4) throw SubjectError("--size is too small for " + std::to_string(count) + " maps");
    const int rows = (count + columns - 1) / columns;
    const Rgb no_surface = srgb(0x3d5a80), ink = srgb(0x30343a);
    const auto grey = [](float t) {  // even steps to the eye
        const float g = std::pow(t, 2.2f);
        return Rgb{g, g, g};
    };

    for (int part = 0; part < count; ++part) {
        const int left = part % columns * width / columns + gap / 2, top = part / columns * (height - legend) / rows + gap / 2;
        std::vector<float> distance;
        for (const Face& face : k_cross)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    const float u = (2 * static_cast<float>(x) + 1) / static_cast<float>(side) - 1;
                    const float v = 1 - (2 * static_cast<float>(y) + 1) / static_cast<float>(side);
                    distance.push_back(distance_below(model, static_cast<std::uint32_t>(part), face.out + u * face.right + v * face.up));
                }
        const float most = brightest(distance);
        auto value = distance.begin();
        for (const Face& face : k_cross)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x, ++value)
                    image.at(left + face.column * side + x, top + face.row * side + y) =
                        *value == k_no_hit ? no_surface : grey(std::min(*value / most, 1.0f));
        for (const Face& face : k_cross) {  // outlines, so that black faces show
            const Box box{left + face.column * side, top + face.row * side, side, side};
            fill(image, {box.left, box.top, box.width, 1}, srgb(0x9aa0a6));
            fill(image, {box.left, box.top, 1, box.height}, srgb(0x9aa0a6));
            fill(image, {box.left, box.top + box.height, box.width, 1}, srgb(0x9aa0a6));
            fill(image, {box.left + box.width, box.top, 1, box.height}, srgb(0x9aa0a6));
        }
        const int words = std::clamp(2 * side / (14 * 6), 1, 2 * dot);  // "white 1.2e-05%" must fit beside the cross
        char text[32];
        std::snprintf(text, sizeof text, "white %.2g%%", 100 * static_cast<double>(most) / model.header.r_max);
        const int text_left = left + 2 * side + 4 * words;
        fill(image, {text_left, top, 8 * words, 7 * words}, part_colour(static_cast<std::size_t>(part)));
        draw_text(image, text_left + 11 * words, top, words, "part " + std::to_string(part), ink);
        draw_text(image, text_left, top + 11 * words, words, text, ink);
    }

    const int line = height - legend + 8 * dot;
    int x = gap;
    for (int i = 0; i < 60 * dot; ++i) fill(image, {x + i, line, 1, 7 * dot}, grey(static_cast<float>(i) / static_cast<float>(60 * dot)));
    x += 60 * dot + 4 * dot;
    const std::string meaning = "surface below the superquadric, from none to the white of each part (% of R_max)";
    draw_text(image, x, line, dot, meaning, ink);
    x += text_width(meaning, dot) + 12 * dot;
    fill(image, {x, line, 8 * dot, 7 * dot}, no_surface);
    draw_text(image, x + 11 * dot, line, dot, "no surface on this ray", ink);
    return image;
}

}  // namespace sqmap::app
