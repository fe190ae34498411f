// Everything that is made outside the loop and allocates: points of tools, textures, pads, states.
#include "haptic/stencil.h"
#include "math/random.h"
#include "sqmap/haptic/patch.h"
#include "sqmap/haptic/tactile.h"
#include "sqmap/haptic/texture.h"
#include "sqmap/math/assert.h"
#include "zone_tick.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

namespace sqmap::haptic {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

struct Surface {
    std::span<const Vec3d> vertices;
    std::span<const Triangle> triangles;
};

/// Divides the triangles; nothing if that needs more than max_points.
std::optional<PatchPoints> divide(const Surface& surface, double spacing, std::size_t max_points)
{
    PatchPoints out;
    out.points.assign(surface.vertices.begin(), surface.vertices.end());
    out.weights.assign(surface.vertices.size(), 0.f);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
        const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(out.points.size()));
        if (fresh) {
            out.points.push_back(0.5 * (out.points[a] + out.points[b]));
            out.weights.push_back(0.f);
        }
        return at->second;
    };
    std::vector<Triangle> left;
    for (const Triangle& whole : surface.triangles) {
        SQMAP_ASSERT(std::max({whole[0], whole[1], whole[2]}) < surface.vertices.size());
        left.assign(1, whole);
        while (!left.empty()) {
            const Triangle t = left.back();
            left.pop_back();
            const Vec3d a = out.points[t[0]], b = out.points[t[1]], c = out.points[t[2]];
            const double longest_sq = std::max({norm_sq(b - a), norm_sq(c - b), norm_sq(a - c)});
            if (!(spacing > 0) || !(longest_sq > spacing * spacing)) {
                const auto third = static_cast<float>(norm(cross(b - a, c - a)) / 6);
                for (const std::uint32_t v : t) out.weights[v] += third;
                continue;
            }
            const std::uint32_t ab = middle(t[0], t[1]), bc = middle(t[1], t[2]), ca = middle(t[2], t[0]);
            if (out.points.size() > max_points) return std::nullopt;
            left.insert(left.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
        }
    }
    return out;
}

}  // namespace

PatchPoints patch_points(std::span<const Vec3d> vertices, std::span<const Triangle> triangles, double spacing,
                         std::size_t max_points)
{
    for (;; spacing *= 1.2)
        if (std::optional<PatchPoints> points = divide({vertices, triangles}, spacing, max_points)) return std::move(*points);
}

DenserSets::DenserSets(std::span<const Vec3d> vertices, std::span<const Triangle> triangles, std::size_t max_points)
{
    std::size_t before = vertices.size();
    for (const double spacing : {0.0025, 0.002, 0.0015}) {
        std::optional<PatchPoints> patch = divide({vertices, triangles}, spacing, max_points);
        if (!patch) break;
        if (patch->points.size() == before) continue;
        before = patch->points.size();
        sets_.push_back(std::make_unique<Set>(Set{query::Probe(patch->points), std::move(patch->weights)}));
    }
    for (const auto& set : sets_) points_.push_back({&set->probe, set->weights});
}

std::size_t DenserSets::max_points() const noexcept { return points_.empty() ? 0 : points_.back().probe->size(); }

std::vector<Vec3d> stencil_points(const Smoothing& smoothing)
{
    // Fibonacci lattice: no plane holds many of them.
    constexpr double k_turn = std::numbers::pi * 0.7639320225002103;  // golden angle: pi (3 - sqrt 5)
    const std::uint32_t n = smoothing.points > 8 ? smoothing.points : 8;
    std::vector<Vec3d> points(n);
    Vec3d mean{};
    for (std::uint32_t i = 0; i < n; ++i) {
        const double z = 1 - (2 * i + 1.) / n, rho = std::sqrt(1 - z * z);
        points[i] = {rho * std::cos(k_turn * i), rho * std::sin(k_turn * i), z};
        mean += points[i] / static_cast<double>(n);
    }
    // Moves and stretches the points by a per cent or two until their mean is zero and their second moments are the sphere's:
    // then the force of a plane has the plane's direction at any depth.
    Mat3d second{{{}, {}, {}}};
    for (Vec3d& p : points) {
        p -= mean;
        for (int i = 0; i < 3; ++i) second.row[i] += (3 * p[i] / n) * p;
    }
    Mat3d root{};  // of the inverse, by Newton: x <- x (3 - x^2 second) / 2
    for (int round = 0; round < 20; ++round) {
        Mat3d m = root * root * second;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) m.row[i][j] = ((i == j ? 3 : 0) - m.row[i][j]) / 2;
        root = root * m;
    }
    for (Vec3d& p : points) p = smoothing.radius * (root * p);
    points.push_back({});
    return points;
}

namespace {

/// Two independent standard normal numbers (Box and Muller 1958).
struct Pair {
    double a, b;
};
Pair gaussian(SplitMix64& random)
{
    const double u = 1 - random.uniform(), angle = 2 * std::numbers::pi * random.uniform(), r = std::sqrt(-2 * std::log(u));
    return {r * std::cos(angle), r * std::sin(angle)};
}

}  // namespace

Texture gaussian_texture(const NoiseOptions& options, std::vector<float>& values)
{
    const std::uint32_t n = std::max(options.n, 4u);
    const std::size_t count = static_cast<std::size_t>(n) * n * n;
    std::vector<double> white(count);
    SplitMix64 random(options.seed);
    for (std::size_t i = 0; i < count; i += 2) {
        const Pair p = gaussian(random);
        white[i] = p.a;
        if (i + 1 < count) white[i + 1] = p.b;
    }
    // (1 2 1) / 4 along each axis leaves nothing at the lattice's own limit, and little that the splines would wear down.
    const std::size_t strides[] = {1, n, static_cast<std::size_t>(n) * n};
    std::vector<double> smooth(count);
    for (const std::size_t stride : strides) {
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t along = i / stride % n, line = i - along * stride;
            smooth[i] =
                0.5 * white[i] + 0.25 * (white[line + (along + 1) % n * stride] + white[line + (along + n - 1) % n * stride]);
        }
        std::swap(white, smooth);
    }
    // Variance of the relief, per axis: autocovariance (6, 4, 1) / 16 of that kernel times the splines' products, on average
    // over a cell 11/20, 13/30 and 1/60.
    constexpr double k_variance = 11. / 20 * 6 / 16 + 13. / 30 * 4 / 16 + 1. / 60 / 16;
    // Cut at three standard deviations: carving from the highest point must not sink the whole surface for one rare value.
    const double scale = options.amplitude / std::pow(k_variance, 1.5), top = 3 * options.amplitude;
    values.resize(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(std::clamp(scale * white[i], -2 * top, top) - top);
    return {TextureMap::Solid, n, options.wavelength / 2, values};
}

Texture image_texture(std::span<const std::uint8_t> grey, const ImageOptions& options, std::vector<float>& values)
{
    const auto n = static_cast<std::uint32_t>(std::sqrt(static_cast<double>(grey.size())) + 0.5);
    if (n == 0 || static_cast<std::size_t>(n) * n != grey.size()) return {};
    values.resize(grey.size());
    for (std::size_t i = 0; i < grey.size(); ++i) values[i] = static_cast<float>(-options.depth * (255 - grey[i]) / 255.);
    return {TextureMap::Planar, n, options.step, values};
}

Texture procedural_texture(double (*height)(double, double, double), std::uint32_t n, double step, std::vector<float>& values)
{
    values.resize(static_cast<std::size_t>(n) * n * n);
    std::size_t i = 0;
    for (std::uint32_t z = 0; z < n; ++z)
        for (std::uint32_t y = 0; y < n; ++y)
            for (std::uint32_t x = 0; x < n; ++x, ++i) {
                const double h = height(static_cast<double>(x) / n, static_cast<double>(y) / n, static_cast<double>(z) / n);
                values[i] = static_cast<float>(std::isfinite(h) ? std::min(h, 0.) : 0.);
            }
    return {TextureMap::Solid, n, step, values};
}

TactilePad::TactilePad(std::span<const Vec3d> points, std::span<const Vec3d> normals)
    : probe_(points), points_(points.begin(), points.end()), contacts_(points.size())
{
    SQMAP_ASSERT(points.size() == normals.size());
    normals_.reserve(normals.size());
    for (const Vec3d& n : normals) {
        const double length = norm(n);
        normals_.push_back(length > 0 ? (1 / length) * n : Vec3d{});
    }
}

namespace {

/// Area of one point in the mean; 1 where all are alike.
double mean_weight_of(std::span<const float> weights)
{
    double sum = 0;
    for (const float w : weights) sum += static_cast<double>(w);
    return weights.empty() ? 1 : sum / static_cast<double>(weights.size());
}

}  // namespace

State::State(std::span<const Zone> zones, const StateOptions& options) : data_(std::make_unique<Data>())
{
    Data& d = *data_;
    d.zones.assign(zones.begin(), zones.end());
    d.reports.resize(zones.size());
    d.memory.resize(zones.size());
    d.touches.resize(zones.size() * options.max_touched);
    d.max_touched = options.max_touched;
    d.found.resize(options.max_contacts * options.max_touched);
    d.queries.resize(options.max_touched);
    std::size_t samples = 0;
    for (const Zone& zone : d.zones)
        if (zone.probe != nullptr && zone.options.averaging != Averaging::Patch) samples = std::max(samples, zone.probe->size());
    for (const Zone& zone : d.zones) {
        std::vector<double>& means = d.mean_weight.emplace_back(1, mean_weight_of(zone.weights));
        for (const DenserPoints& set : zone.denser) means.push_back(mean_weight_of(set.weights));
        if (zone.surface != nullptr && !d.surfaces) d.surfaces.emplace(k_surface_contacts);
    }
    d.samples.resize(samples);
    d.trails.resize(d.touches.size() * samples);
}

State::State(State&&) noexcept = default;
State& State::operator=(State&&) noexcept = default;
State::~State() = default;

}  // namespace sqmap::haptic
