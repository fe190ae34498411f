#include "sqmap/model/model.h"

#include "model/central_cells.h"
#include "model/flags.h"
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

void forget_coordinates(ModelView& view) noexcept
{
    view.input.coordinates32 = {};
    view.input.coordinates64 = {};
}

ModelView normalized(const ModelView& view) noexcept
{
    ModelView out = view;
    for (double& coordinate : out.header.origin) coordinate = 0;
    out.header.unit = 1;
    forget_coordinates(out);
    return out;
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
    SQMAP_ASSERT(i < part.samples.count);
    const std::uint16_t stored = view.samples[part.samples.first + i];
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
