#include "sqmap/haptic/texture.h"
#include "sqmap/math/random.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::haptic {

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

}  // namespace sqmap::haptic
