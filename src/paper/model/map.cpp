// A part's map in the arrays of its model, and what it promises to the queries that read it.
#include "sqmap/paper/model.h"

#include "paper/model/codes.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <bit>
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

/// Ranks that the distances give, and entries for as many hits.
bool has_ranked_hits(const MapView& map)
{
    if (map.hits.size() != rank_count(base_rows(map) * base_columns(map))) return false;
    std::uint32_t before = 0;
    for (std::size_t k = 0; k < map.hits.size(); ++k) {
        const HitRank rank = hits_in(map, k, before);
        if (map.hits[k] != rank) return false;
        before += static_cast<std::uint32_t>(std::popcount(rank.bits));
    }
    const std::size_t entries = before + k_hit_padding;
    return map.normal.size() == entries && (map.smoothed.empty() || map.smoothed.size() == smoothed_bytes(before));
}

/// None, or samples that there are, rising, and the words that end them.
bool has_rising_offsets(std::span<const std::uint32_t> offsets, std::size_t samples)
{
    if (offsets.empty()) return true;
    if (offsets.size() < k_hit_padding) return false;
    const std::size_t count = offsets.size() - k_hit_padding;
    for (std::size_t k = 0; k < count; ++k) {
        const bool rises = k == 0 || offsets[k] >> k_offset_bits > offsets[k - 1] >> k_offset_bits;
        if (!rises || offsets[k] >> k_offset_bits >= samples) return false;
    }
    return std::all_of(offsets.begin() + static_cast<std::ptrdiff_t>(count), offsets.end(),
                       [](std::uint32_t word) { return word == k_no_offset; });
}

}  // namespace

HitRank hits_in(const MapView& map, std::size_t rank, std::uint32_t before) noexcept
{
    const std::size_t columns = base_columns(map), count = base_rows(map) * columns, first = rank * k_rank_samples;
    HitRank out{0, before};
    for (std::size_t k = first; k < std::min(count, first + k_rank_samples); ++k) {
        const std::size_t row = k / columns << map.subdivisions, column = k % columns << map.subdivisions;
        if (ray_of(map.distance[row * map.omega_count + column]) == MapRay::Surface) out.bits |= 1u << (k - first);
    }
    return out;
}

std::size_t hit_index(const MapView& map, std::size_t sample) noexcept
{
    SQMAP_ASSERT(sample / k_rank_samples < map.hits.size());
    const HitRank& rank = map.hits[sample / k_rank_samples];
    return rank.before + static_cast<std::size_t>(std::popcount(rank.bits & ((1u << sample % k_rank_samples) - 1u)));
}

SmoothedSample smoothed_at(const MapView& map, std::size_t entry) noexcept
{
    const std::size_t first = entry * k_smoothed_bits / 8;
    SQMAP_ASSERT(first + 3 <= map.smoothed.size());
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word |= std::uint32_t{map.smoothed[first + k]} << 8 * k;
    word >>= entry * k_smoothed_bits % 8;
    const auto change = static_cast<std::int32_t>(word << (32 - k_change_bits)) >> (32 - k_change_bits);
    return {change, word >> k_change_bits & ((1u << 2 * k_smoothed_normal_bits) - 1u)};
}

std::uint32_t offset_steps(const MapView& map, std::size_t sample) noexcept
{
    const auto word = std::lower_bound(map.offset.begin(), map.offset.end(), static_cast<std::uint32_t>(sample << k_offset_bits));
    if (word == map.offset.end() || *word >> k_offset_bits != sample) return 0;
    const std::uint32_t code = *word & ((1u << k_offset_bits) - 1u);
    return code * code;
}

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
    const std::size_t samples = base_rows(map) * base_columns(map);
    if (base_rows(map) < 3 || base_columns(map) < 4) return false;
    const auto length = [](float v) { return v > 0 && std::isfinite(v); };
    const std::size_t n = map.seed_count;
    return is_shape(map.superquadric) && length(map.distance_scale) && length(map.offset_scale) && length(map.change_scale) &&
           map.distance.size() == count && has_ranked_hits(map) && map.occluded_vertices <= map.vertex_count &&
           map.q2_share >= 0 && map.q2_share <= 1 && map.cuts.size() == (count + 3) / 4 &&
           has_rising_offsets(map.offset, samples) && n >= 1 && n <= 64 && map.seeds.size() == n * n * n &&
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
