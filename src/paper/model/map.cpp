// A part's map in the arrays of its model, and what it promises to the queries that read it.
#include "sqmap/paper/model.h"

#include "paper/model/codes.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::paper {

using shape::Arc;
using shape::Superquadricf;

namespace {

constexpr double k_pi = std::numbers::pi;

bool is_shape(const Superquadricf& sq)
{
    const auto exponent = [](float e) { return e >= 0.05f && e <= 2.0f; };
    const auto taper = [](float k) { return std::abs(k) < 1.0f; };
    bool turned = true;
    for (const Vec3f& row : sq.rotation.row) turned = turned && std::abs(norm_sq(row) - 1) < 1e-3f;
    return is_finite(sq.a) && sq.a.x > 0 && sq.a.y > 0 && sq.a.z > 0 && exponent(sq.eps1) && exponent(sq.eps2) && turned &&
           is_finite(sq.translation) && taper(sq.taper_x) && taper(sq.taper_y) && sq.bend >= 0 &&
           sq.bend * sq.a.z < static_cast<float>(k_pi) && std::isfinite(sq.bend_angle);
}

// Rows of a sparse table: rising from 0 to the number of entries, columns in range and sorted within a row.
template <class Entry>
bool is_sparse_table(std::span<const std::uint32_t> rows, std::span<const Entry> entries, std::size_t row_count,
                     std::uint32_t columns)
{
    if (entries.empty()) return rows.empty() || rows.size() == row_count;
    if (rows.size() != row_count || rows.front() != 0 || rows.back() != entries.size()) return false;
    for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
        if (rows[i] > rows[i + 1] || rows[i + 1] > entries.size()) return false;
        for (std::uint32_t k = rows[i]; k < rows[i + 1]; ++k)
            if (entries[k].column >= columns || (k > rows[i] && entries[k].column < entries[k - 1].column)) return false;
    }
    return true;
}

}  // namespace

MapRay ray_of(std::uint16_t stored) noexcept
{
    return stored == k_map_miss ? MapRay::Miss : stored == k_map_cap ? MapRay::Cap : MapRay::Surface;
}

MapCounts counts_of(const MapView& map) noexcept
{
    MapCounts counts;
    for (const std::uint16_t stored : map.distance) {
        const MapRay ray = ray_of(stored);
        ++(ray == MapRay::Surface ? counts.hits : ray == MapRay::Cap ? counts.caps : counts.misses);
    }
    return counts;
}

bool is_smoothed(const SmoothedSample& sample) noexcept { return sample.change != k_not_smoothed; }

bool is_consistent(const MapView& map) noexcept
{
    const std::size_t count = std::size_t{map.eta_count} * map.omega_count;
    if (map.eta_count < 3 || map.eta_count > k_max_map_rows || map.omega_count < 4 || map.omega_count > k_max_map_columns ||
        map.subdivisions > 8)
        return false;
    const std::uint32_t stride = std::uint32_t{1} << map.subdivisions;
    if ((map.eta_count - 1) % stride != 0 || map.omega_count % stride != 0) return false;
    const std::size_t base_rows = (map.eta_count - 1) / stride + 1, base_columns = map.omega_count / stride;
    if (base_rows < 3 || base_columns < 4) return false;
    const auto length = [](float v) { return v > 0 && std::isfinite(v); };
    const std::size_t n = map.seed_count;
    return is_shape(map.superquadric) && length(map.distance_scale) && length(map.offset_scale) && map.distance.size() == count &&
           map.occluded_vertices <= map.vertex_count && map.q2_share >= 0 && map.q2_share <= 1 &&
           map.normal.size() == base_rows * base_columns && map.cuts.size() == (count + 3) / 4 &&
           (map.offset.empty() || map.offset.size() == offset_bytes(base_rows * base_columns)) &&
           (map.smoothed.empty() || map.smoothed.size() == base_rows * base_columns) && n >= 1 && n <= 64 &&
           map.seeds.size() == n * n * n &&
           (map.surface_seeds.empty() ||
            map.surface_seeds.size() == std::size_t{k_surface_seeds} * k_surface_seeds * k_surface_seeds) &&
           is_sparse_table(map.correction_rows, map.corrections, map.eta_count, map.omega_count) &&
           is_sparse_table(map.gap_rows, map.gaps, std::size_t{map.eta_count} + 1, map.omega_count);
}

MapView map_of(const ModelView& view, std::size_t part) noexcept
{
    SQMAP_ASSERT(part < view.maps.records.size());
    const MapRecord& record = view.maps.records[part];
    MapView map;
    static_cast<MapGrid&>(map) = record.grid;
    map.superquadric = model::superquadric_of(view.common.parts[part]);
    const auto cut = [](const char*, const model::Slice& slice, auto& span, const auto& array) {
        span = array.subspan(slice.first, slice.count);
    };
    MapArrays<model::ArrayView>::each(cut, record.slices, map, view.maps);
    return map;
}

}  // namespace sqmap::paper
