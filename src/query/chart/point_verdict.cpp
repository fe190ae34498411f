#undef HWY_COMPILE_ONLY_STATIC
#define HWY_COMPILE_ONLY_SCALAR
#include "point_verdict.h"

#include "query/layer.h"
#include "sqmap/math/assert.h"

#include <hwy/highway.h>

#include "chart_verdict-inl.h"

#include <optional>

namespace sqmap::query {

using namespace HWY_NAMESPACE;

namespace {

/// The side of a point by a part's base map alone; none where a corner of its cell has no surface.
std::optional<bool> side_of_base_map(const ModelView& model, const Part& part, Vec3f p)
{
    const CentralMap map(model, part);
    const model::ChartPoint q = model::to_chart(map.to_chart_frame(p));
    float corner[4];
    const int column = map.column_of(q.s), row = map.column_of(q.t);
    if (!map.base_corners(q.face, column, row, corner)) return std::nullopt;
    const float size = map.cell_size();
    const float u = (q.s + 1.f) / size - static_cast<float>(column), v = (q.t + 1.f) / size - static_cast<float>(row);
    return map.centre_inside() == (q.w > model::bilinear_value(corner, u, v, size).w);
}

}  // namespace

PointVerdict verdict_by_charts(const ModelView& model, Vec3f point, Layer layer, std::uint32_t gate) noexcept
{
    SQMAP_ASSERT(model::has_central_maps(model));
    // Bounds hold at every layer. A side that they leave open, Layer 2 decides by the base map alone.
    const auto refine = [&](std::size_t index, VerdictLanes& v) {
        const Part& part = model.parts[index];
        const bool coarse = layer == Layer::Two || (layer == Layer::Gate && !passes_gate(part, gate));
        if (any(v.certain) || !coarse) return;
        if (const auto inside = side_of_base_map(model, part, point)) v.inside = *inside ? v.held : none();
    };
    I answering;
    const VerdictLanes v =
        ChartVerdicts(model).by_all({set(point.x), set(point.y), set(point.z)}, hn::Not(none()), answering, refine);
    const std::int32_t part = hn::GetLane(answering);
    return part < 0 ? PointVerdict{} : PointVerdict{any(v.inside), any(v.certain), part};
}

}  // namespace sqmap::query
