// From a seed to the surface that a query finds about it, estimated when seeds are chosen. The query's own search
// (query/chart/chart_search-inl.h) rounds differently: these roundings decide bytes of a model.
#pragma once

#include "model/central_map.h"
#include "query/chart/search_limits.h"

namespace sqmap::bake {

/// The surface found.
struct Approach {
    float distance_sq = INFINITY;  ///< model units
    Vec3f offset{};                ///< from the point to the surface, chart frame times axes
};

/// Looks the surface up over a start, takes the point's foot on the tangent plane there for the next start, while that comes
/// nearer. x: the point, start: its foot on the seed's plane, both in the chart frame.
inline Approach approach(const model::CentralMap& map, const model::Part& part, Vec3f x, Vec3f start)
{
    using namespace model;  // the chart and its cells
    ChartPoint q = to_chart(start);
    float expected = 1.f / q.w;  // along the face's axis: of several surfaces the one nearest to there
    Approach best;
    for (int step = 0; step < query::k_approach_steps; ++step) {
        const Leaf leaf = map.leaf_at(q.face, q.s, q.t);
        SheetValue value{0, 0, 0};
        float least = INFINITY;
        for (int j = 0; j < leaf.sheets; ++j) {
            const SheetValue v = sheet_value(leaf, j, q.s, q.t);
            if (!(v.w > 1e-6f)) continue;
            const float miss = std::abs(1.f / v.w - expected);
            if (!(miss < least)) continue;
            least = miss;
            value = v;
        }
        if (!(value.w > 1e-6f)) break;
        const Vec3f foot = (1.f / value.w) * face_direction(q.face, q.s, q.t);
        const Vec3f offset{part.a[0] * (foot.x - x.x), part.a[1] * (foot.y - x.y), part.a[2] * (foot.z - x.z)};
        const float distance_sq = norm_sq(offset);
        if (!(distance_sq < best.distance_sq)) break;
        best = {distance_sq, offset};
        const Vec3f n = plane_vector(q.face, q.s, q.t, value);
        const Vec3f scaled = map.over_axes_sq(n);
        const float length_sq = dot(n, scaled), gap = 1.f - dot(n, x);
        if (!(length_sq > 0.f)) break;
        const float along = gap / length_sq, plane_sq = gap * along;
        if (distance_sq <= query::k_approach_near * plane_sq) {
            best = {plane_sq, {along * n.x / part.a[0], along * n.y / part.a[1], along * n.z / part.a[2]}};
            break;
        }
        q = to_chart(x + along * scaled);
        expected = 1.f / q.w;
    }
    return best;
}

}  // namespace sqmap::bake
