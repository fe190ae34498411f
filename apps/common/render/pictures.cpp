// Pictures of a subject: what is coloured how.
#include "common/render/pictures.h"

#include "sqmap/decompose/decompose.h"
#include "sqmap/math/assert.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/point.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace sqmap::app {
namespace {

std::string shortened(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

Layer part_layer(const Subject& subject)
{
    Layer layer{.mesh = subject.mesh, .groups = subject.part_of_triangle};
    for (const std::uint32_t part : subject.part_of_triangle) layer.colours.push_back(part_colour(part));
    return layer;
}

/// The layer, with the scale of its colours beside it.
Image with_scale(Layer layer, View view, const Scale& scale)
{
    view.shadows = false;
    view.margin = std::min(scale_width(Image(view.width, view.height, {}), scale), view.width / 2);
    Image image = render({std::move(layer)}, view);
    draw_scale(image, scale);
    return image;
}

/// x rounded to 1, 2 or 5 times a power of ten.
double round_step(double x)
{
    const double power = std::pow(10.0, std::floor(std::log10(x)));
    return (x < 1.5 * power ? 1 : x < 3.5 * power ? 2 : x < 7.5 * power ? 5 : 10) * power;
}

std::vector<Tick> round_ticks(double low, double high, double colour_low)
{
    std::vector<Tick> ticks;
    if (!(high > low)) return {{static_cast<float>(colour_low), shortened(low)}};
    const double step = round_step((high - low) / 5);
    for (double i = std::ceil(low / step); i * step <= high; ++i)
        ticks.push_back(
            {static_cast<float>(colour_low + (1 - colour_low) * (i * step - low) / (high - low)), shortened(i * step)});
    return ticks;
}

struct ErrorSample {
    enum class Kind : std::uint8_t { Known, Missed, Unknown } kind = Kind::Unknown;
    double percent = 0;  ///< of R_max
};

constexpr double k_below = 0.01;  ///< of R_max: how far below the surface errors are taken

/// |depth by layer 3 - exact depth| at a point k_below under the surface, or nearer to it where the solid is thinner.
ErrorSample depth_error(const Subject& subject, const mesh::Solid& solid, Vec3d on_surface, Vec3d normal)
{
    for (double below = k_below; below > 0.1 * k_below; below /= 2) {
        const Vec3d p = on_surface - below * subject.r_max * normal;
        if (!solid.inside(p)) continue;
        const query::PointResult contact = query::query_point(model::normalized(subject.model->view()), p);
        if (!contact.contact) return {ErrorSample::Kind::Missed, 0};
        return {ErrorSample::Kind::Known, 100 * std::abs(contact.depth - solid.closest_boundary(p).distance) / subject.r_max};
    }
    return {};
}

ErrorSample projection_error(const Subject& subject, std::uint32_t part, Vec3d on_surface)
{
    const std::optional<double> distance =
        query::distance_along_projection(model::normalized(subject.model->view()), part, on_surface, query::Layer::Three);
    if (!distance) return {};
    return {ErrorSample::Kind::Known, 100 * std::abs(*distance) / subject.r_max};
}

}  // namespace

Image plain_picture(const Subject& subject, const View& view)
{
    return render({{.mesh = subject.mesh, .colours = std::vector<Rgb>(subject.mesh.triangles.size(), srgb(0xc9b8a0))}}, view);
}

Image parts_picture(const Subject& subject, const View& view) { return render({part_layer(subject)}, view); }

Image superquadrics_picture(const Subject& subject, const View& view)
{
    std::vector<Layer> layers{part_layer(subject)};
    for (Rgb& colour : layers[0].colours) colour = 0.5f * colour + 0.5f * srgb(0xe8e4dc);
    for (std::size_t p = 0; p < subject.superquadrics.size(); ++p) {
        Layer layer{.mesh = mesh::superquadric_surface(subject.superquadrics[p], 24), .translucent = true};
        layer.colours.assign(layer.mesh.triangles.size(), part_colour(p));
        layers.push_back(std::move(layer));
    }
    return render(layers, view);
}

Image protrusion_picture(const Subject& subject, const View& view)
{
    const std::vector<double> p = decompose::decompose_with_diagnostics(subject.mesh).protrusion;
    const auto [low, high] = std::minmax_element(p.begin(), p.end());
    Layer layer{.mesh = subject.mesh};
    for (const double v : p)
        layer.colours.push_back(sequential_colour(static_cast<float>((v - *low) / std::max(*high - *low, 1e-300))));
    return with_scale(
        std::move(layer), view,
        {.title = {"protrusion", "over its mean"}, .colour = sequential_colour, .ticks = round_ticks(*low, *high, 0)});
}

Image curvature_picture(const Subject& subject, const View& view)
{
    const std::vector<double> k = decompose::decompose_with_diagnostics(subject.mesh).curvature;
    std::vector<double> size;
    for (const double v : k) size.push_back(std::abs(v) * subject.r_max * subject.r_max);
    const auto cut = size.begin() + static_cast<std::ptrdiff_t>((size.size() - 1) * 95 / 100);
    std::nth_element(size.begin(), cut, size.end());
    const double end = round_step(std::max(*cut, 1e-12));
    // Square roots spread the small values, among which are the saddles that cuts follow.
    const auto spread = [&](double v) {
        return static_cast<float>(std::copysign(std::sqrt(std::min(std::abs(v) / end, 1.0)), v));
    };
    Layer layer{.mesh = subject.mesh};
    for (const double v : k) layer.colours.push_back(diverging_colour(spread(v * subject.r_max * subject.r_max)));
    Scale scale{.title = {"Gaussian", "curvature", "x R_max^2"}, .colour = diverging_colour, .low = -1, .ticks = {}};
    for (const double t : {-0.2, 0.0, 0.2}) scale.ticks.push_back({spread(t * end), shortened(t * end)});
    scale.ticks.push_back({-1, "< " + shortened(-end)});
    scale.ticks.push_back({1, "> " + shortened(end)});
    return with_scale(std::move(layer), view, scale);
}

Image error_picture(const Subject& subject, const View& view)
{
    SQMAP_ASSERT(subject.model.has_value());
    // As many cells as give each a few pixels; their errors span decades, hence the logarithm.
    constexpr std::size_t k_cells = 100000;
    constexpr double k_low = 0.01, k_high = 1;
    const bool is_solid = subject.model->view().header.solid != 0;
    const mesh::Solid solid(subject.mesh, mesh::find_self_intersections(subject.mesh).crossed);
    Layer layer{.mesh = subject.mesh};
    while (layer.detail < 8 && subject.mesh.triangles.size() * layer.detail * layer.detail < k_cells) ++layer.detail;
    const Rgb missed = srgb(0x2456d6), unknown = srgb(0x8a9099);
    for (std::uint32_t t = 0; t < subject.mesh.triangles.size(); ++t) {
        const auto& [i, j, k] = subject.mesh.triangles[t];
        const Vec3d a = subject.mesh.vertices[i], b = subject.mesh.vertices[j], c = subject.mesh.vertices[k];
        const Vec3d normal = normalized(cross(b - a, c - a));
        for (std::uint32_t cell = 0; cell < layer.detail * layer.detail; ++cell) {
            const auto weight = cell_centre(layer.detail, cell);
            const Vec3d p = weight[0] * a + weight[1] * b + weight[2] * c;
            const ErrorSample e =
                is_solid ? depth_error(subject, solid, p, normal) : projection_error(subject, subject.part_of_triangle[t], p);
            if (e.kind == ErrorSample::Kind::Known)
                layer.colours.push_back(
                    error_colour(static_cast<float>(std::log(std::max(e.percent, k_low) / k_low) / std::log(k_high / k_low))));
            else
                layer.colours.push_back(e.kind == ErrorSample::Kind::Missed ? missed : unknown);
        }
    }
    Scale scale{.title = {is_solid ? "depth error" : "error (eq. 35)", "of layer 3,", "% of R_max"},
                .colour = error_colour,
                .ticks = {{0, "< 0.01"}, {0.25f, "0.03"}, {0.5f, "0.1"}, {0.75f, "0.3"}, {1, "> 1"}}};
    if (is_solid) scale.swatches.push_back({missed, "missed"});
    scale.swatches.push_back({unknown, is_solid ? "too thin" : "no surface"});
    return with_scale(std::move(layer), view, scale);
}

}  // namespace sqmap::app
