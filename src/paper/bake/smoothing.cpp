#include "paper/bake/grid.h"

#include "model/octahedral.h"
#include "paper/model/codes.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace sqmap::paper {

namespace {

// Weights at 0 to radius samples from the middle.
std::vector<double> kernel_of(SmoothingKernel kernel, int radius)
{
    std::vector<double> weights(static_cast<std::size_t>(radius) + 1, 1.0);
    for (int d = 1; d <= radius; ++d) {
        double& weight = weights[static_cast<std::size_t>(d)];
        if (kernel == SmoothingKernel::Binomial)  // C(2 r, r + d) over C(2 r, r)
            weight = weights[static_cast<std::size_t>(d) - 1] * (radius - d + 1) / (radius + d);
        if (kernel == SmoothingKernel::Gaussian) weight = std::exp(-2.0 * d * d / (radius * radius));
    }
    return weights;
}

}  // namespace

void add_smoothing(const Caster& caster, const Grid& finest, const MapOptions& options, Map& map)
{
    if (options.smoothing_radius == 0) return;
    const std::vector<double> kernel = kernel_of(options.smoothing_kernel, options.smoothing_radius);
    const int radius = static_cast<int>(kernel.size()) - 1;
    const int stride = 1 << map.subdivisions;
    const int rows = (finest.rows - 1) / stride + 1, columns = finest.columns / stride;
    const auto at = [&](int i, int j) -> const Surface& { return finest.at(i * stride, (j + columns) % columns * stride); };
    const auto index = [&](int i, int j) { return static_cast<std::size_t>(i) * columns + (j + columns) % columns; };
    std::vector<Vec3d> points(static_cast<std::size_t>(rows) * columns);
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) points[index(i, j)] = caster.at(finest.angles(i * stride, j * stride)).point;
    std::vector<double> smooth(points.size(), -1.0);
    for (int i = radius; i + radius < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const Surface& here = at(i, j);
            bool whole = here.kind == Kind::Hit;
            double sum = 0, weights = 0;
            for (int di = -radius; di <= radius && whole; ++di)
                for (int dj = -radius; dj <= radius && whole; ++dj) {
                    const Surface& there = at(i + di, j + dj);
                    const double weight =
                        kernel[static_cast<std::size_t>(std::abs(di))] * kernel[static_cast<std::size_t>(std::abs(dj))];
                    whole = there.kind == Kind::Hit &&
                            std::abs(there.distance - here.distance) <=
                                options.jump_slope * norm(points[index(i, j)] - points[index(i + di, j + dj)]);
                    sum += weight * there.distance;
                    weights += weight;
                }
            if (whole) smooth[index(i, j)] = sum / weights;
        }
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            SmoothedSample& out = map.smoothed.emplace_back(SmoothedSample{k_not_smoothed, 0});
            const double d = smooth[index(i, j)];
            if (d < 0 || i == 0 || i == rows - 1) continue;
            const double up = smooth[index(i + 1, j)], down = smooth[index(i - 1, j)], next = smooth[index(i, j + 1)],
                         last = smooth[index(i, j - 1)];
            if (std::min({up, down, next, last}) < 0) continue;
            const auto jet = shape::surface_jet(caster.sq, shape::position_at(caster.sq, finest.angles(i * stride, j * stride)));
            const Vec3d n = normalized(
                shape::mapped_normal(jet, d, (up - down) * (rows - 1) / (2 * k_pi), (next - last) * columns / (4 * k_pi)));
            if (!(dot(n, face_normal(caster.rays.mesh(), at(i, j).triangle)) > 0)) continue;
            const double steps = (d - at(i, j).distance) / static_cast<double>(map.distance_scale);
            out.change = static_cast<std::int16_t>(std::lround(std::clamp(steps, -32767.0, 32767.0)));
            out.normal = model::encode_normal(sqmap::cast<float>(n));
        }
}

}  // namespace sqmap::paper
