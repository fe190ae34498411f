#include "sqmap/model/model.h"
#include "sqmap/model/made_up.h"

#include "model/central_cells.h"
#include "model/flags.h"
#include "model/normal_codes.h"
#include "sqmap/math/assert.h"

#include <algorithm>

namespace sqmap::model {

shape::Superquadricf superquadric_of(const Part& part) noexcept
{
    shape::Superquadricf sq;
    sq.a = vec3(part.a);
    sq.eps1 = part.eps[0];
    sq.eps2 = part.eps[1];
    for (int i = 0; i < 3; ++i) sq.rotation.row[i] = vec3(part.rotation + 3 * i);
    sq.translation = vec3(part.translation);
    sq.taper_x = part.taper[0];
    sq.taper_y = part.taper[1];
    sq.bend = part.bend;
    sq.bend_angle = part.bend_angle;
    return sq;
}

ModelView normalized(const ModelView& view) noexcept
{
    ModelView out = view;
    for (double& coordinate : out.header.origin) coordinate = 0;
    out.header.unit = 1;
    return out;
}

NormalMapView normal_map_of(const ModelView& view, std::size_t part) noexcept
{
    SQMAP_ASSERT(part < view.normal.parts.size());
    const NormalPart& p = view.normal.parts[part];
    const NormalArrays<ArrayView>& a = view.normal;
    const std::size_t samples = static_cast<std::size_t>(p.eta_count) * p.omega_count;
    NormalMapView map;
    map.superquadric = superquadric_of(view.parts[part]);
    map.eta_count = p.eta_count;
    map.omega_count = p.omega_count;
    map.subdivisions = p.subdivisions;
    map.vertex_count = p.vertex_count;
    map.distance_scale = p.distance_scale;
    map.offset_scale = p.offset_scale;
    map.quantization_error = p.quantization_error;
    map.distance = a.distance.subspan(p.first_sample, samples);
    map.normal = a.normal.subspan(p.first_base, p.base_count);
    map.cuts = a.cuts.subspan(p.first_cut, p.cut_count);
    map.correction_rows = a.correction_rows.subspan(p.first_correction_row, p.correction_row_count);
    map.corrections = a.corrections.subspan(p.first_correction, p.correction_count);
    map.gap_rows = a.gap_rows.subspan(p.first_gap_row, p.gap_row_count);
    map.gaps = a.gaps.subspan(p.first_gap, p.gap_count);
    map.offset = a.offset.subspan(p.first_offset, offset_bytes(p.base_count));
    if (!a.smoothed.empty()) map.smoothed = a.smoothed.subspan(p.first_base, p.base_count);
    map.seed_count = p.seeds_along;
    map.seeds_mirrored = p.seeds_mirrored != 0;
    const std::size_t along = std::min<std::uint32_t>(p.seeds_along, 256), starts = along * along * along;
    const std::span<const FootSeed> seeds = a.seeds.subspan(p.first_seed, p.seed_count);
    map.seeds = seeds.first(std::min(starts, seeds.size()));
    map.surface_seeds = seeds.subspan(map.seeds.size());
    return map;
}

bool centre_inside(const Part& part) noexcept { return (part.flags & k_centre_inside) != 0; }

bool is_fallback(const Part& part) noexcept { return (part.flags & k_fit_fallback) != 0; }

std::uint32_t part_of_triangle(const ModelView& view, std::size_t triangle) noexcept
{
    SQMAP_ASSERT(triangle < view.triangle_part.size());
    return part_of(view.triangle_part[triangle]);
}

bool is_made_up(const ModelView& view, std::size_t triangle) noexcept
{
    SQMAP_ASSERT(triangle < view.triangle_part.size());
    return is_made_up(view.triangle_part[triangle]);
}

std::optional<Vec3f> sample_point(const ModelView& view, const Part& part, std::uint32_t i) noexcept
{
    SQMAP_ASSERT(i < part.sample_count);
    const std::uint16_t stored = view.samples[part.first_sample + i];
    const float w = SampleRange{part.w_min, part.w_step}.decode(stored);
    if (stored == k_no_surface || !(w > 0)) return std::nullopt;
    const std::uint32_t side = part.base + 1, face = i / (side * side), row = i / side % side, column = i % side;
    const auto along = [&](std::uint32_t k) { return -1 + 2 * static_cast<float>(k) / static_cast<float>(part.base); };
    const Vec3f q = face_direction(static_cast<int>(face), along(column), along(row));
    const Vec3f direction = part.a[0] * q.x * vec3(part.rotation) + part.a[1] * q.y * vec3(part.rotation + 3) +
                            part.a[2] * q.z * vec3(part.rotation + 6);
    return vec3(part.chart_centre) + 1 / w * direction;
}

}  // namespace sqmap::model
