// Values of a normal map between its samples.
#include "map_sample.h"

#include "model/normal_codes.h"
#include "model/octahedral.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::query {

using model::decode_normal;
using model::k_map_cap;
using model::k_map_largest;
using model::k_map_miss;
using model::VertexCorrection;
using shape::SurfaceAnglesf;

namespace {

constexpr float k_pi = std::numbers::pi_v<float>;

bool is_hit(std::uint16_t code) { return code <= k_map_largest; }

std::size_t node_index(const NormalMapView& map, std::size_t row, std::size_t column) { return row * map.omega_count + column; }

unsigned cut_bits(const NormalMapView& map, std::size_t node) { return (map.cuts[node / 4] >> (2 * (node % 4))) & 3u; }

// Position in a grid of rows by columns: cell and position within it.
struct CellPosition {
    std::size_t row, column, next_column;
    float y, x;
};

CellPosition cell_of(SurfaceAnglesf angles, std::size_t rows, std::size_t columns)
{
    CellPosition c;
    const float y = std::clamp((angles.eta / k_pi + 0.5f), 0.0f, 1.0f) * static_cast<float>(rows - 1);
    const float x = std::clamp(angles.omega / (2 * k_pi) + 0.5f, 0.0f, 1.0f) * static_cast<float>(columns);
    c.row = std::min(static_cast<std::size_t>(y), rows - 2);
    c.column = std::min(static_cast<std::size_t>(x), columns - 1);
    c.next_column = c.column + 1 == columns ? 0 : c.column + 1;
    c.y = y - static_cast<float>(c.row);
    c.x = x - static_cast<float>(c.column);
    return c;
}

float bilinear(const CellPosition& c, float v00, float v01, float v10, float v11)
{
    const float low = v00 + c.x * (v01 - v00), high = v10 + c.x * (v11 - v10);
    return low + c.y * (high - low);
}

float offset_at(const NormalMapView& map, SurfaceAnglesf angles)
{
    if (map.offset.empty()) return 0;
    const std::size_t rows = ((map.eta_count - 1) >> map.subdivisions) + 1, columns = map.omega_count >> map.subdivisions;
    const CellPosition c = cell_of(angles, rows, columns);
    const auto value = [&](std::size_t i, std::size_t j) {
        return map.offset_scale * static_cast<float>(map.offset[i * columns + j]);
    };
    return bilinear(c, value(c.row, c.column), value(c.row, c.next_column), value(c.row + 1, c.column),
                    value(c.row + 1, c.next_column));
}

MapSample value_of_code(const NormalMapView& map, std::uint16_t code, std::uint16_t normal)
{
    if (code == k_map_miss) return {std::numeric_limits<float>::infinity(), {}, k_projection_miss};
    if (code == k_map_cap) return {0, {}, k_projection_cap};
    return {map.distance_scale * static_cast<float>(code), decode_normal(normal), 0};
}

// Layer 2: the sample of the base grid nearest in angle.
MapSample nearest_base_sample(const NormalMapView& map, SurfaceAnglesf angles)
{
    const std::size_t rows = ((map.eta_count - 1) >> map.subdivisions) + 1, columns = map.omega_count >> map.subdivisions;
    const CellPosition c = cell_of(angles, rows, columns);
    const std::size_t row = (c.row + (c.y >= 0.5f ? 1 : 0)) << map.subdivisions;
    const std::size_t column = (c.x >= 0.5f ? c.next_column : c.column) << map.subdivisions;
    const std::size_t node = node_index(map, row, column);
    return value_of_code(map, map.distance[node], map.normal[node]);
}

float correction_at(const NormalMapView& map, const CellPosition& c)
{
    const VertexCorrection* first = map.corrections.data() + map.correction_rows[c.row];
    const VertexCorrection* last = map.corrections.data() + map.correction_rows[c.row + 1];
    first =
        std::lower_bound(first, last, c.column, [](const VertexCorrection& v, std::size_t column) { return v.column < column; });
    float sum = 0;
    for (; first != last && first->column == c.column; ++first) {
        const float y0 = (static_cast<float>(first->eta) + 0.5f) / 256, x0 = (static_cast<float>(first->omega) + 0.5f) / 256;
        const float hat = std::min({c.x / x0, (1 - c.x) / (1 - x0), c.y / y0, (1 - c.y) / (1 - y0)});
        sum += std::max(hat, 0.0f) * static_cast<float>(first->correction);
    }
    return map.distance_scale * sum;
}

// Layer 3: linear interpolation on one sheet of the surface: that of the nearest corner, followed along uncut edges.
MapSample interpolated_sample(const NormalMapView& map, SurfaceAnglesf angles, bool use_corrections)
{
    const CellPosition c = cell_of(angles, map.eta_count, map.omega_count);
    // Corners 0 (row, column), 1 (row, next), 2 (next, column), 3 (next, next).
    const std::size_t node[4] = {node_index(map, c.row, c.column), node_index(map, c.row, c.next_column),
                                 node_index(map, c.row + 1, c.column), node_index(map, c.row + 1, c.next_column)};
    const unsigned b0 = cut_bits(map, node[0]), b1 = cut_bits(map, node[1]), b2 = cut_bits(map, node[2]);
    const bool bottom = (b0 & 2) == 0, top = (b2 & 2) == 0, left = (b0 & 1) == 0, right = (b1 & 1) == 0;  // uncut
    const int nearest = (c.y >= 0.5f ? 2 : 0) + (c.x >= 0.5f ? 1 : 0);
    const std::uint16_t code = map.distance[node[nearest]];
    const bool whole = bottom && top && left && right;
    // Where a surface enters the superquadric inside the cell, which side of it a place lies on is a guess.
    std::uint8_t mixed = whole ? 0 : k_projection_silhouette;
    for (const std::size_t k : node)
        if (!whole && code != k_map_cap && map.distance[k] == k_map_cap) mixed |= k_projection_by_cap;
    if (!is_hit(code)) {
        MapSample sample = value_of_code(map, code, 0);
        sample.flags |= mixed;
        return sample;
    }
    float value[4];
    Vec3f normal[4];
    bool known[4] = {false, false, false, false};
    known[nearest] = true;
    // Edges: 0-1 bottom, 2-3 top, 0-2 left, 1-3 right. Three sweeps reach every corner from any start.
    for (int sweep = 0; sweep < 3; ++sweep) {
        const auto join = [&](bool uncut, int a, int b) {
            if (uncut && known[a] != known[b]) known[a] = known[b] = true;
        };
        join(bottom, 0, 1);
        join(top, 2, 3);
        join(left, 0, 2);
        join(right, 1, 3);
    }
    for (int i = 0; i < 4; ++i)
        if (known[i]) {
            value[i] = map.distance_scale * static_cast<float>(map.distance[node[i]]);
            normal[i] = decode_normal(map.normal[node[i]]);
        }
    const bool all = known[0] && known[1] && known[2] && known[3];
    // Corners on another sheet are continued from this one: in the plane of three corners, level across the missing side
    // of two, constant from one.
    if (!all) {
        const bool had[4] = {known[0], known[1], known[2], known[3]};
        for (int i = 0; i < 4; ++i) {
            if (had[i]) continue;
            const int along = i ^ 1, across = i ^ 2, opposite = i ^ 3;
            const int from = had[along] ? along : (had[across] ? across : opposite);
            value[i] = had[along] && had[across] && had[opposite] ? value[along] + value[across] - value[opposite] : value[from];
            normal[i] = normal[from];
        }
    }
    MapSample sample;
    sample.distance = bilinear(c, value[0], value[1], value[2], value[3]);
    for (int k = 0; k < 3; ++k) sample.normal[k] = bilinear(c, normal[0][k], normal[1][k], normal[2][k], normal[3][k]);
    sample.normal = normalized(sample.normal);
    if (!whole) {
        sample.flags = mixed;
    } else if (use_corrections && !map.corrections.empty()) {
        sample.distance += correction_at(map, c);
    }
    sample.distance = std::max(sample.distance, 0.0f);
    return sample;
}

}  // namespace

bool reads_base_grid(const NormalMapView& map, const ProjectionOptions& options)
{
    if (options.layer != Layer::Gate) return options.layer == Layer::Two;
    const std::uint64_t base =
        std::uint64_t{((map.eta_count - 1) >> map.subdivisions) + 1} * (map.omega_count >> map.subdivisions);
    return base >= std::uint64_t{options.layer3_gate} * map.vertex_count;
}

bool behind_first_surface(const NormalMapView& map, SurfaceAnglesf angles, float s, float& distance)
{
    if (map.gaps.empty()) return false;
    const CellPosition c = cell_of(angles, map.eta_count, map.omega_count);
    const std::size_t row = c.row + (c.y >= 0.5f ? 1 : 0), column = c.x >= 0.5f ? c.next_column : c.column;
    const model::MapGap* first = map.gaps.data() + map.gap_rows[row];
    const model::MapGap* last = map.gaps.data() + map.gap_rows[row + 1];
    first = std::lower_bound(first, last, column, [](const model::MapGap& g, std::size_t k) { return g.column < k; });
    bool found = false;
    for (; first != last && first->column == column; ++first) {
        if (s <= map.distance_scale * static_cast<float>(first->leave)) break;
        found = true;
        distance = first->enter == k_map_miss ? std::numeric_limits<float>::infinity()
                                              : map.distance_scale * static_cast<float>(first->enter);
    }
    return found;
}

MapSample sample_map(const NormalMapView& map, SurfaceAnglesf angles, const ProjectionOptions& options) noexcept
{
    MapSample sample = reads_base_grid(map, options) ? nearest_base_sample(map, angles)
                                                     : interpolated_sample(map, angles, options.use_corrections);
    if (options.use_offset && (sample.flags & (k_projection_miss | k_projection_cap)) == 0)
        sample.distance = std::max(sample.distance - offset_at(map, angles), 0.0f);
    return sample;
}

MapSample sample_smoothed(const NormalMapView& map, SurfaceAnglesf angles) noexcept
{
    MapSample sample = sample_map(map, angles, {});
    if (map.smoothed.empty() || (sample.flags & (k_projection_miss | k_projection_cap | k_projection_silhouette)) != 0)
        return sample;
    const std::size_t rows = ((map.eta_count - 1) >> map.subdivisions) + 1, columns = map.omega_count >> map.subdivisions;
    const CellPosition c = cell_of(angles, rows, columns);
    const model::SmoothedSample corner[4] = {
        map.smoothed[c.row * columns + c.column], map.smoothed[c.row * columns + c.next_column],
        map.smoothed[(c.row + 1) * columns + c.column], map.smoothed[(c.row + 1) * columns + c.next_column]};
    Vec3f normal[4];
    float change[4];
    for (int i = 0; i < 4; ++i) {
        if (corner[i].change == model::k_not_smoothed) return sample;
        change[i] = map.distance_scale * static_cast<float>(corner[i].change);
        normal[i] = decode_normal(corner[i].normal);
    }
    sample.distance = std::max(sample.distance + bilinear(c, change[0], change[1], change[2], change[3]), 0.0f);
    for (int k = 0; k < 3; ++k) sample.normal[k] = bilinear(c, normal[0][k], normal[1][k], normal[2][k], normal[3][k]);
    sample.normal = normalized(sample.normal);
    return sample;
}

}  // namespace sqmap::query
