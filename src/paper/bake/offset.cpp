#include "paper/bake/grid.h"

#include <cmath>
#include <utility>

namespace sqmap::paper {

std::vector<double> offsets(const Caster& caster, const Grid& finest, int stride, const MapOptions& options)
{
    const int rows = (finest.rows - 1) / stride + 1, columns = finest.columns / stride;
    const auto at = [&](int i, int j) -> const Surface& { return finest.at(i * stride, (j + columns) % columns * stride); };
    std::vector<Vec3d> points(static_cast<std::size_t>(rows) * columns);
    const auto index = [&](int i, int j) { return static_cast<std::size_t>(i) * columns + (j + columns) % columns; };
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) points[index(i, j)] = caster.at(finest.angles(i * stride, j * stride)).point;
    double spacing = 0;
    for (int i = 1; i + 1 < rows; ++i)
        for (int j = 0; j < columns; ++j)
            spacing +=
                0.5 * (norm(points[index(i, j)] - points[index(i, j + 1)]) + norm(points[index(i, j)] - points[index(i + 1, j)]));
    spacing /= static_cast<double>((rows - 2) * columns);
    const auto gradient = [&](int i, int j) {
        double sum = 0;
        for (const auto& [di, dj] : {std::pair{1, 0}, std::pair{0, 1}}) {
            const int i0 = std::max(i - di, 0), i1 = std::min(i + di, rows - 1);
            const Surface &a = at(i0, j - dj), &b = at(i1, j + dj);
            const double length = norm(points[index(i0, j - dj)] - points[index(i1, j + dj)]);
            if (a.kind != Kind::Hit || b.kind != Kind::Hit || !(length > 0)) continue;
            const double slope = (b.distance - a.distance) / length;
            sum += slope * slope;
        }
        return std::sqrt(sum);
    };
    std::vector<double> out(points.size(), 0.0);
    for (int i = 1; i + 1 < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const Surface& here = at(i, j);
            if (here.kind != Kind::Hit) continue;
            bool minimum = true;
            for (int di = -1; di <= 1 && minimum; ++di)
                for (int dj = -1; dj <= 1; ++dj) {
                    const Surface& s = at(i + di, j + dj);
                    if (s.kind == Kind::Cap || (s.kind == Kind::Hit && s.distance < here.distance)) minimum = false;
                }
            if (!minimum) continue;
            double steepest = 0;
            const int radius = options.offset_radius;
            for (int k = std::max(i - radius, 0); k <= std::min(i + radius, rows - 1); ++k)
                for (int dj = -radius; dj <= radius; ++dj)
                    if (at(k, j + dj).kind == Kind::Hit) steepest = std::max(steepest, gradient(k, j + dj));
            out[index(i, j)] = options.offset_constant * spacing * steepest;
        }
    return out;
}

}  // namespace sqmap::paper
