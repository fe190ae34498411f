// Pictures of a subject: what is coloured how.
#include "common/render/pictures.h"

#include "math/percentile.h"
#include "sqmap/math/assert.h"
#include "sqmap/math/half_space.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/point.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
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

/// The layers, with the scale of their colours beside them.
Image with_scale(const std::vector<Layer>& layers, View view, const Scale& scale)
{
    view.shadows = false;
    view.margin = std::min(scale_width(Image(view.width, view.height, {}), scale), view.width / 2);
    Image image = render(layers, view);
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

/// p of eq. 4, with a ball on each salient feature if wanted: a ball shows on the coarsest mesh.
Image protrusion_picture(const Subject& subject, bool with_features, const View& view)
{
    constexpr double k_radius = 0.018;  // of a ball, of R_max
    const decompose::Decomposition& found = subject.section_three->found;
    const auto [low, high] = std::minmax_element(found.protrusion.begin(), found.protrusion.end());
    std::vector<Layer> layers(1, {.mesh = subject.mesh});
    for (const double p : found.protrusion)
        layers[0].colours.push_back(sequential_colour(static_cast<float>((p - *low) / std::max(*high - *low, 1e-300))));
    Scale scale{.title = {"protrusion", "over its mean"}, .colour = sequential_colour, .ticks = round_ticks(*low, *high, 0)};
    if (!with_features) return with_scale(layers, view, scale);
    const Rgb feature = srgb(0xd4145a);
    for (const std::uint32_t v : found.salient_vertices) {
        Layer ball{.mesh = mesh::sphere(k_radius * subject.r_max, 2)};
        for (Vec3d& p : ball.mesh.vertices) p += subject.mesh.vertices[v];
        ball.colours.assign(ball.mesh.triangles.size(), feature);
        layers.push_back(std::move(ball));
    }
    scale.swatches = {{feature, "feature"}};
    return with_scale(layers, view, scale);
}

/// A colour for every cell of the mesh by its locale: colour(feature, locale).
template <class Colour>
Layer locale_layer(const Subject& subject, Colour colour)
{
    constexpr std::size_t k_cells = 100000;  // levels cut triangles: coarse ones need many cells
    const decompose::LocaleBands& bands = subject.section_three->locales;
    Layer layer{.mesh = subject.mesh};
    while (layer.detail < 24 && subject.mesh.triangles.size() * layer.detail * layer.detail < k_cells) ++layer.detail;
    for (std::uint32_t t = 0; t < subject.mesh.triangles.size(); ++t) {
        const std::uint32_t feature = bands.feature[t];
        const mesh::Triangle& c = subject.mesh.triangles[t];
        for (std::uint32_t cell = 0; cell < layer.detail * layer.detail; ++cell) {
            if (feature == decompose::LocaleBands::k_none) {
                layer.colours.push_back(srgb(0xc9b8a0));
                continue;
            }
            const auto weight = cell_centre(layer.detail, cell);
            double distance = 0;
            for (std::size_t i = 0; i < 3; ++i) distance += weight[i] * bands.distance[c[i]];
            const auto last = bands.strength[feature].size() - 1;
            layer.colours.push_back(colour(feature, std::min(static_cast<std::size_t>(distance / bands.width), last)));
        }
    }
    return layer;
}

Image locales_picture(const Subject& subject, const View& view)
{
    return render({locale_layer(subject,
                                [](std::uint32_t feature, std::size_t locale) {
                                    const Rgb colour = part_colour(feature);
                                    return locale % 2 == 0 ? colour : 0.55f * colour + 0.45f * srgb(0xffffff);
                                })},
                  view);
}

Image strength_picture(const Subject& subject, const View& view)
{
    constexpr double k_end = 2;  // a plane has 1
    const std::vector<std::vector<double>>& strength = subject.section_three->locales.strength;
    return with_scale({locale_layer(subject,
                                    [&](std::uint32_t feature, std::size_t locale) {
                                        const double s = strength[feature][locale] / k_end;
                                        return diverging_colour(static_cast<float>(std::clamp(s, -1., 1.)));
                                    })},
                      view,
                      {.title = {"boundary", "strength", "(plane: 1)"},
                       .colour = diverging_colour,
                       .low = -1,
                       .ticks = {{-1, "< -2"}, {-0.5f, "-1"}, {0, "0"}, {0.5f, "1"}, {1, "> 2"}}});
}

Image hyperbolic_picture(const Subject& subject, const View& view)
{
    const Rgb hyperbolic = srgb(0x2456d6), other = srgb(0xe8e4dc);
    Layer layer{.mesh = subject.mesh};
    for (const double k : subject.section_three->found.curvature) layer.colours.push_back(k < 0 ? hyperbolic : other);
    return with_scale({std::move(layer)}, view,
                      {.title = {"curvature", "(eq. 6)"},
                       .colour = nullptr,
                       .ticks = {},
                       .swatches = {{hyperbolic, "negative"}, {other, "not"}}});
}

Image curvature_picture(const Subject& subject, const View& view)
{
    const std::vector<double>& k = subject.section_three->found.curvature;
    std::vector<double> size;
    for (const double v : k) size.push_back(std::abs(v) * subject.r_max * subject.r_max);
    const double end = round_step(std::max(percentile(size, 95), 1e-12));
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
    return with_scale({std::move(layer)}, view, scale);
}

/// The parts, paler, under a translucent surface of each.
Image under(const Subject& subject, std::vector<mesh::Mesh> surfaces, const View& view)
{
    std::vector<Layer> layers{part_layer(subject)};
    for (Rgb& colour : layers[0].colours) colour = 0.5f * colour + 0.5f * srgb(0xe8e4dc);
    for (std::size_t p = 0; p < surfaces.size(); ++p) {
        Layer layer{.mesh = std::move(surfaces[p]), .translucent = true};
        layer.colours.assign(layer.mesh.triangles.size(), part_colour(p));
        layers.push_back(std::move(layer));
    }
    return render(layers, view);
}

Vec3d middle_of_part(const Subject& subject, std::size_t part)
{
    Vec3d sum;
    double area = 0;
    for (std::uint32_t t = 0; t < subject.mesh.triangles.size(); ++t) {
        if (subject.part_of_triangle[t] != part) continue;
        sum += mesh::triangle_area(subject.mesh, t) * mesh::triangle_centroid(subject.mesh, t);
        area += mesh::triangle_area(subject.mesh, t);
    }
    return area > 0 ? sum / area : sum;
}

/// Draws a surface toward a point within all sides, as far as they ask.
void cut(mesh::Mesh& surface, std::span<const HalfSpacef> sides, Vec3d within)
{
    for (Vec3d& p : surface.vertices) {
        double share = 1;
        for (const HalfSpacef& side : sides) {
            const Vec3d n = cast<double>(side.normal);
            const double along = dot(n, p - within), until = side.offset - dot(n, within);
            if (until > 0 && along * share > until) share = until / along;
        }
        p = within + share * (p - within);
    }
}

}  // namespace

Image plain_picture(const Subject& subject, const View& view)
{
    return render({{.mesh = subject.mesh, .colours = std::vector<Rgb>(subject.mesh.triangles.size(), srgb(0xc9b8a0))}}, view);
}

Image parts_picture(const Subject& subject, const View& view) { return render({part_layer(subject)}, view); }

Image superquadrics_picture(const Subject& subject, const View& view)
{
    std::vector<mesh::Mesh> surfaces;
    for (const shape::Superquadricd& of : subject.superquadrics) surfaces.push_back(mesh::superquadric_surface(of, 24));
    return under(subject, std::move(surfaces), view);
}

Image bounds_picture(const Subject& subject, const View& view)
{
    std::vector<mesh::Mesh> surfaces;
    for (std::size_t p = 0; p < subject.superquadrics.size(); ++p) {
        surfaces.push_back(mesh::superquadric_surface(subject.superquadrics[p], 96));
        if (subject.model) cut(surfaces.back(), model::polytope_of(subject.model->view(), p), middle_of_part(subject, p));
    }
    return under(subject, std::move(surfaces), view);
}

Image section_three_picture(const Subject& subject, const std::string& kind, const View& view)
{
    SQMAP_ASSERT(subject.section_three.has_value());
    if (kind == "locales") return locales_picture(subject, view);
    if (kind == "strength") return strength_picture(subject, view);
    if (kind == "curvature") return curvature_picture(subject, view);
    if (kind == "hyperbolic") return hyperbolic_picture(subject, view);
    return protrusion_picture(subject, kind == "features", view);
}

Image regions_picture(const Subject& subject, const View& view)
{
    SQMAP_ASSERT(subject.regions.size() == subject.mesh.triangles.size());
    const Rgb of[] = {srgb(0xe8e4dc), srgb(0x2a9d8f), srgb(0xd4145a)};
    double area[3] = {}, total = 0;
    Layer layer{.mesh = subject.mesh, .groups = subject.part_of_triangle};
    for (std::uint32_t t = 0; t < subject.mesh.triangles.size(); ++t) {
        const auto region = static_cast<std::size_t>(subject.regions[t]);
        layer.colours.push_back(of[region]);
        area[region] += mesh::triangle_area(subject.mesh, t);
        total += mesh::triangle_area(subject.mesh, t);
    }
    const auto words = [&](const char* name, int region) {
        char text[40];
        std::snprintf(text, sizeof text, "%s %.3g %%", name, 100 * area[region] / total);
        return std::string(text);
    };
    return with_scale({std::move(layer)}, view,
                      {.title = {"regions", "(section 5)"},
                       .colour = nullptr,
                       .ticks = {},
                       .swatches = {{of[0], words("convex", 0)}, {of[1], words("q1", 1)}, {of[2], words("q2", 2)}}});
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
    return with_scale({std::move(layer)}, view, scale);
}

}  // namespace sqmap::app
