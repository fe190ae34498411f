#include "common/render/unrolled.h"

#include "sqmap/math/assert.h"
#include "sqmap/paper/model.h"
#include "sqmap/query/point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::app {
namespace {

/// A face of the cube as the cross shows it, seen from outside: direction = out + u right + v up, u and v in [-1, 1].
struct Face {
    Vec3f out, right, up;
    int column, row;  // position in the cross
};

// Four faces around z, and the two that z leaves through above and below the second.
constexpr std::array<Face, 6> k_cross{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 0, 1},
                                       {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, 1, 1},
                                       {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, 2, 1},
                                       {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}, 3, 1},
                                       {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, 1, 0},
                                       {{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}, 1, 2}}};
constexpr int k_columns = k_cross_columns, k_rows = k_cross_rows;
constexpr float k_pi = std::numbers::pi_v<float>;

/// How far along q (largest coordinate 1) the part's chart answers: where its convex domain ends.
float domain_end(const model::Part& part, Vec3f q)
{
    const float v[9] = {q.x, q.y, q.z, q.x + q.y, q.x - q.y, q.x + q.z, q.x - q.z, q.y + q.z, q.y - q.z};
    float end = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 9; ++i)
        if (v[i] != 0) end = std::min(end, (v[i] > 0 ? part.chart_hi[i] : part.chart_lo[i]) / v[i]);
    return end;
}

/// Distance from the superquadric down to the outermost surface on the ray from the chart's centre, model units, and that
/// surface.
struct Below {
    float distance = k_no_hit;
    Vec3f surface{};
};
Below distance_below(const model::ModelView& model, std::uint32_t index, Vec3f q)
{
    const model::Part& part = model.parts[index];
    const shape::Superquadricf sq = model::superquadric_of(part);
    const Vec3f centre = model::vec3(part.chart_centre);
    const Vec3f step = part.a[0] * q.x * model::vec3(part.rotation) + part.a[1] * q.y * model::vec3(part.rotation + 3) +
                       part.a[2] * q.z * model::vec3(part.rotation + 6);
    const float end = domain_end(part, q);
    if (!(end > 0) || !std::isfinite(end)) return {};
    // The crossing nearest to the domain's end is the outermost one; a little less, for rounding.
    const float from = 0.9999f * end;
    const std::optional<double> to_surface = query::distance_along_projection(
        model::normalized(model), index, cast<double>(centre + from * step), query::Layer::Three);
    if (!to_surface) return {};
    // The superquadric ends at the ray's last exit: a ray may leave a bent one and meet it again.
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
    const float length = norm(step), along = static_cast<float>(*to_surface);
    return {std::max(0.0f, (inside - from) * length - along), centre + (from + along / length) * step};
}

}  // namespace

Unrolled unrolled_central(const model::ModelView& model, std::uint32_t part, int side)
{
    Unrolled out{.width = k_columns * side, .height = k_rows * side, .distance = {}};
    const auto pixels = static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height);
    out.distance.assign(pixels, k_paper);
    out.surface.resize(pixels);
    for (const Face& face : k_cross)
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const float u = (2 * static_cast<float>(x) + 1) / static_cast<float>(side) - 1;
                const float v = 1 - (2 * static_cast<float>(y) + 1) / static_cast<float>(side);
                const Below below = distance_below(model, part, face.out + u * face.right + v * face.up);
                const auto at = static_cast<std::size_t>((face.row * side + y) * out.width + face.column * side + x);
                out.distance[at] = below.distance;
                out.surface[at] = below.surface;
            }
    return out;
}

std::optional<MapPosition> position_on_cross(const model::Part& part, Vec3f point)
{
    const Vec3f d = point - model::vec3(part.chart_centre);
    const Vec3f q{dot(model::vec3(part.rotation), d) / part.a[0], dot(model::vec3(part.rotation + 3), d) / part.a[1],
                  dot(model::vec3(part.rotation + 6), d) / part.a[2]};
    const Face* face = nullptr;
    float max = 0;
    for (const Face& f : k_cross)
        if (const float along = dot(f.out, q); along > max) face = &f, max = along;
    if (face == nullptr) return std::nullopt;
    return MapPosition{(static_cast<float>(face->column) + 0.5f + 0.5f * dot(face->right, q) / max) / k_columns,
                       (static_cast<float>(face->row) + 0.5f - 0.5f * dot(face->up, q) / max) / k_rows};
}

Unrolled unrolled_normal(const model::ModelView& model, std::uint32_t part, int width, int height)
{
    SQMAP_ASSERT(paper::is_paper(model) && width > 0 && height > 0);
    const paper::MapView map = paper::map_of(model, part);
    Unrolled out{.width = width, .height = height, .distance = {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::uint32_t row =
                static_cast<std::uint32_t>(height - 1 - y) * map.eta_count / static_cast<std::uint32_t>(height);
            const std::uint32_t column = static_cast<std::uint32_t>(x) * map.omega_count / static_cast<std::uint32_t>(width);
            const std::uint16_t stored = map.distance[std::size_t{row} * map.omega_count + column];
            const paper::MapRay ray = paper::ray_of(stored);
            out.distance.push_back(ray == paper::MapRay::Miss  ? k_no_hit
                                   : ray == paper::MapRay::Cap ? k_cap
                                                               : map.distance_scale * static_cast<float>(stored));
            out.surface.push_back(mapped_sample(map, row, column).value_or(Vec3f{}));
        }
    return out;
}

MapPosition position_on_grid(const paper::MapView& map, shape::SurfaceAnglesf angles)
{
    const auto rows = static_cast<float>(map.eta_count), columns = static_cast<float>(map.omega_count);
    // Sample (row, column) is the middle of its cell of the picture.
    const float row = (angles.eta / k_pi + 0.5f) * (rows - 1), column = (angles.omega + k_pi) / (2 * k_pi) * columns;
    const float x = (column + 0.5f) / columns;
    return {x - std::floor(x), 1 - (row + 0.5f) / rows};
}

std::optional<Vec3f> mapped_sample(const paper::MapView& map, std::uint32_t row, std::uint32_t column)
{
    const std::uint16_t stored = map.distance[std::size_t{row} * map.omega_count + column];
    if (paper::ray_of(stored) != paper::MapRay::Surface) return std::nullopt;
    const shape::SurfaceAnglesf angles{k_pi * (static_cast<float>(row) / static_cast<float>(map.eta_count - 1) - 0.5f),
                                       2 * k_pi * static_cast<float>(column) / static_cast<float>(map.omega_count) - k_pi};
    const shape::SurfacePoint<float> s = shape::surface_point(map.superquadric, angles);
    return s.point - map.distance_scale * static_cast<float>(stored) * s.normal;
}

}  // namespace sqmap::app
