// Quadratic B-splines: Unser, "Splines: a perfect fit for signal and image processing", IEEE Signal Processing Magazine 1999.
#include "sqmap/haptic/texture.h"

#include <algorithm>
#include <cmath>

namespace sqmap::haptic {

namespace {

/// The three values about a coordinate, with their weights and the weights' slopes.
struct Taps {
    std::uint32_t index[3];
    double weight[3], slope[3];
};

Taps taps_at(double x, double step, std::uint32_t n)
{
    const double s = x / step, nearest = std::floor(s + 0.5), f = s - nearest;
    const double last = static_cast<double>(n);
    double wrapped = std::fmod(nearest, last);
    if (wrapped < 0) wrapped += last;
    const std::uint32_t i = std::min(static_cast<std::uint32_t>(wrapped), n - 1);
    return {{(i + n - 1) % n, i, (i + 1) % n},
            {0.5 * (0.5 - f) * (0.5 - f), 0.75 - f * f, 0.5 * (0.5 + f) * (0.5 + f)},
            {-(0.5 - f) / step, -2 * f / step, (0.5 + f) / step}};
}

Relief solid_relief(const Texture& texture, Vec3d p)
{
    const std::size_t n = texture.n;
    const Taps x = taps_at(p.x, texture.step, texture.n), y = taps_at(p.y, texture.step, texture.n),
               z = taps_at(p.z, texture.step, texture.n);
    Relief r;
    for (int k = 0; k < 3; ++k)
        for (int j = 0; j < 3; ++j) {
            const float* row = texture.values.data() + (z.index[k] * n + y.index[j]) * n;
            double value = 0, slope = 0;
            for (int i = 0; i < 3; ++i) {
                value += x.weight[i] * static_cast<double>(row[x.index[i]]);
                slope += x.slope[i] * static_cast<double>(row[x.index[i]]);
            }
            r.height += z.weight[k] * y.weight[j] * value;
            r.gradient +=
                Vec3d{z.weight[k] * y.weight[j] * slope, z.weight[k] * y.slope[j] * value, z.slope[k] * y.weight[j] * value};
        }
    return r;
}

/// Three projections, each by the square of the normal's component along it. The gradient leaves out that these weights change
/// along a curved surface.
Relief planar_relief(const Texture& texture, Vec3d p, Vec3d normal)
{
    Relief r;
    for (int axis = 0; axis < 3; ++axis) {
        const double share = normal[axis] * normal[axis];
        if (share < 1e-6) continue;
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        const Taps a = taps_at(p[u], texture.step, texture.n), b = taps_at(p[v], texture.step, texture.n);
        for (int j = 0; j < 3; ++j) {
            const float* row = texture.values.data() + static_cast<std::size_t>(b.index[j]) * texture.n;
            for (int i = 0; i < 3; ++i) {
                const double value = share * static_cast<double>(row[a.index[i]]);
                r.height += a.weight[i] * b.weight[j] * value;
                r.gradient[u] += a.slope[i] * b.weight[j] * value;
                r.gradient[v] += a.weight[i] * b.slope[j] * value;
            }
        }
    }
    return r;
}

}  // namespace

Relief relief_at(const Texture& texture, Vec3d p, Vec3d normal) noexcept
{
    const std::size_t n = texture.n, needed = n * n * (texture.map == TextureMap::Solid ? n : 1);
    if (n == 0 || texture.values.size() < needed || !(texture.step > 0) || !std::isfinite(p.x + p.y + p.z)) return {};
    Relief r = texture.map == TextureMap::Solid ? solid_relief(texture, p) : planar_relief(texture, p, normal);
    if (r.height > 0) r = {};  // the table breaks its promise of heights <= 0
    return r;
}

Carved carved(const Relief& relief, double depth, Vec3d normal) noexcept
{
    const Vec3d along = relief.gradient - dot(relief.gradient, normal) * normal;
    return {std::max(depth + relief.height, 0.), normalized(normal - along)};
}

}  // namespace sqmap::haptic
