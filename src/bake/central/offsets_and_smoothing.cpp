#include "offsets_and_smoothing.h"

#include "model/central_cells.h"
#include "model/chart.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::bake {

namespace {

/// A base sample.
struct SampleIndex {
    int face, row, column;
};

/// w of a base sample, or 0 where its ray meets no surface or there is no such sample.
double base_w(const CentralMapData& map, SampleIndex i)
{
    const auto n = static_cast<int>(map.base);
    if (i.row < 0 || i.column < 0 || i.row > n || i.column > n) return 0;
    const std::uint16_t v = map.samples[static_cast<std::size_t>((i.face * (n + 1) + i.row) * (n + 1) + i.column)];
    return v == model::k_no_surface ? 0 : static_cast<double>(map.range.decode(v));
}

/// Distance of the surface at w below the superquadric along a ray through q (Fig. 4c), model units.
double distance_below(const Projection& projection, Vec3d q, double w)
{
    const shape::Superquadricd& sq = projection.chart().superquadric;
    const Vec3d direction = transpose_mul(sq.rotation, Vec3d{sq.a.x * q.x, sq.a.y * q.y, sq.a.z * q.z});
    // Its root grows with the distance from the centre, nearly straight: Illinois' rule (Dowell and Jarratt 1971).
    const auto excess = [&](double t) { return std::sqrt(shape::implicit(sq, projection.centre() + t * direction)) - 1; };
    double lo = 1 / w, hi = lo, at_lo = excess(lo), at_hi = at_lo;
    for (int i = 0; i < 40 && at_hi <= 0; ++i) at_hi = excess(hi *= 1.25);
    int last = 0;
    for (int i = 0; i < 24 && at_lo <= 0 && hi - lo > 1e-8 * hi; ++i) {
        const double middle = (lo * at_hi - hi * at_lo) / (at_hi - at_lo), at = excess(middle);
        if (at <= 0) {
            if (last < 0) at_hi *= 0.5;
            lo = middle;
            at_lo = at;
            last = -1;
        } else {
            if (last > 0) at_lo *= 0.5;
            hi = middle;
            at_hi = at;
            last = 1;
        }
        if (std::abs(at) < 1e-9) break;
    }
    return (lo - 1 / w) * norm(direction);
}

/// Distances below the superquadric at a face's samples, row by row; -1 where there is no surface.
std::vector<double> distances_of(const Projection& projection, const CentralMapData& map, int face)
{
    const auto n = static_cast<int>(map.base);
    const double size = 2.0 / map.base;
    std::vector<double> d;
    for (int row = 0; row <= n; ++row)
        for (int column = 0; column <= n; ++column) {
            const double w = base_w(map, {face, row, column});
            const Vec3d q = model::face_direction(face, -1 + size * column, -1 + size * row);
            d.push_back(w > 0 ? distance_below(projection, q, w) : -1);
        }
    return d;
}

/// By how much a local minimum's highest neighbour is above it; 0 elsewhere. n: cells along a side.
double rise_about(const std::vector<double>& distances, int n, int row, int column)
{
    const double here = distances[static_cast<std::size_t>(row * (n + 1) + column)];
    double rise = 0;
    for (int r = std::max(row - 1, 0); r <= std::min(row + 1, n); ++r)
        for (int c = std::max(column - 1, 0); c <= std::min(column + 1, n); ++c) {
            const double there = distances[static_cast<std::size_t>(r * (n + 1) + c)];
            if ((r == row && c == column) || there < 0) continue;
            if (!(there >= here)) return 0;
            rise = std::max(rise, there - here);
        }
    return rise;
}

/// The mean of a sample's neighbourhood under the kernel, less the sample.
double smoothed(const CentralMapData& map, SampleIndex i, int radius)
{
    const double here = base_w(map, i);
    double sum = 0, weight = 0;
    for (int dr = -radius; dr <= radius; ++dr)
        for (int dc = -radius; dc <= radius; ++dc) {
            const double there = base_w(map, {i.face, i.row + dr, i.column + dc});
            if (!(there > 0) || !(here > 0) || std::abs(there - here) > 0.25 * here) continue;
            const double k = std::ldexp(1.0, -std::abs(dr) - std::abs(dc));
            sum += k * there;
            weight += k;
        }
    return weight > 0 ? sum / weight - here : 0;
}

}  // namespace

void add_offsets(const Projection& projection, const CentralOptions& options, CentralMapData& map)
{
    SQMAP_ASSERT(!map.samples.empty());
    const auto n = static_cast<int>(map.base);
    std::vector<double> delta;
    double largest = 0;
    for (int face = 0; face < model::k_faces; ++face) {
        const std::vector<double> d = distances_of(projection, map, face);
        for (int row = 0; row <= n; ++row)
            for (int column = 0; column <= n; ++column) {
                const bool surface = d[static_cast<std::size_t>(row * (n + 1) + column)] >= 0;
                const double rise = surface ? rise_about(d, n, row, column) : 0;
                delta.push_back(std::min(options.offset_constant * rise, 0.02 * options.r_max));
                largest = std::max(largest, delta.back());
            }
    }
    map.offset_step = model::offset_step(largest);
    for (const double v : delta) map.offsets.push_back(model::encode_offset(v, map.offset_step));
}

void add_smoothing(int radius, CentralMapData& map)
{
    SQMAP_ASSERT(!map.samples.empty());
    const auto n = static_cast<int>(map.base);
    std::vector<double> change;
    double largest = 0;
    for (int face = 0; face < model::k_faces; ++face)
        for (int row = 0; row <= n; ++row)
            for (int column = 0; column <= n; ++column) {
                change.push_back(smoothed(map, {face, row, column}, radius));
                largest = std::max(largest, std::abs(change.back()));
            }
    map.smoothing_step = model::smoothing_step(largest);
    for (const double v : change) map.smoothing.push_back(model::encode_smoothing(v, map.smoothing_step));
}

}  // namespace sqmap::bake
