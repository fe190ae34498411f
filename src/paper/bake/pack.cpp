// A baked map seen through a view, and packed behind those of other parts.
#include "sqmap/paper/bake.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sqmap::paper {

MapView Map::view() const
{
    MapView v;
    v.superquadric = superquadric;
    v.eta_count = eta_count;
    v.omega_count = omega_count;
    v.subdivisions = subdivisions;
    v.vertex_count = vertex_count;
    v.distance_scale = distance_scale;
    v.offset_scale = offset_scale;
    v.quantization_error = quantization_error;
    v.distance = distance;
    v.normal = normal;
    v.cuts = cuts;
    v.correction_rows = correction_rows;
    v.corrections = corrections;
    v.gap_rows = gap_rows;
    v.gaps = gaps;
    v.offset = offset;
    v.smoothed = smoothed;
    v.seed_count = seed_count;
    v.seeds_mirrored = seeds_mirrored;
    v.seeds = seeds;
    v.surface_seeds = surface_seeds;
    return v;
}

std::size_t Map::stored_bytes() const
{
    return sizeof(superquadric) + 8 * sizeof(std::uint32_t) + 2 * (distance.size() + normal.size()) + cuts.size() +
           offset.size() + 4 * correction_rows.size() + sizeof(VertexCorrection) * corrections.size() + 4 * gap_rows.size() +
           sizeof(MapGap) * gaps.size() + sizeof(SmoothedSample) * smoothed.size() +
           sizeof(FootSeed) * (seeds.size() + surface_seeds.size());
}

namespace {

/// Puts some behind all; returns where they begin.
template <class T>
std::uint32_t append(const std::vector<T>& some, std::vector<T>& all)
{
    const auto first = static_cast<std::uint32_t>(all.size());
    all.insert(all.end(), some.begin(), some.end());
    return first;
}

}  // namespace

void append_map(const Map& m, MapArrays<model::ArrayData>& all)
{
    MapRecord p{};
    p.eta_count = m.eta_count;
    p.omega_count = m.omega_count;
    p.subdivisions = m.subdivisions;
    p.vertex_count = m.vertex_count;
    p.distance_scale = m.distance_scale;
    p.offset_scale = m.offset_scale;
    p.quantization_error = m.quantization_error;
    p.cut_count = static_cast<std::uint32_t>(m.cuts.size());
    p.correction_row_count = static_cast<std::uint32_t>(m.correction_rows.size());
    p.correction_count = static_cast<std::uint32_t>(m.corrections.size());
    p.gap_row_count = static_cast<std::uint32_t>(m.gap_rows.size());
    p.gap_count = static_cast<std::uint32_t>(m.gaps.size());
    p.base_count = static_cast<std::uint32_t>(m.normal.size());
    p.seeds_along = m.seed_count;
    p.seeds_mirrored = m.seeds_mirrored ? 1 : 0;
    p.seed_count = static_cast<std::uint32_t>(m.seeds.size() + m.surface_seeds.size());
    p.first_sample = append(m.distance, all.distance);
    p.first_base = append(m.normal, all.normal);
    p.first_cut = append(m.cuts, all.cuts);
    p.first_correction_row = append(m.correction_rows, all.correction_rows);
    p.first_correction = append(m.corrections, all.corrections);
    p.first_gap_row = append(m.gap_rows, all.gap_rows);
    p.first_gap = append(m.gaps, all.gaps);
    p.first_offset = append(m.offset, all.offset);
    append(m.smoothed, all.smoothed);
    p.first_seed = append(m.seeds, all.seeds);
    append(m.surface_seeds, all.seeds);
    all.records.push_back(p);
}

}  // namespace sqmap::paper
