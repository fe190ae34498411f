// From a cell of the chart to the nearest surface about it, one point at a time: what bake tries seeds with, and the reference
// of the frame query's kernel.
#pragma once

#include "central_map.h"

namespace sqmap::query {

inline constexpr int k_approach_steps = 6;
/// Squared distance over that to the tangent plane: the point is above the surface point found when they agree so well.
inline constexpr float k_approach_near = 1.002f;

struct Approach {
    float distance_sq = INFINITY;  ///< model units
    Vec3f foot{};                  ///< chart frame
};

/// x: chart frame. The foot of x on the tangent plane over the seed cell's middle, looked up again there, while that comes
/// nearer.
inline Approach approach(const CentralMap& map, const model::Part& part, Vec3f x, std::uint32_t cell)
{
    const std::uint32_t n = model::k_seed_fine * part.base, row_index = cell / n;
    const float size = 2.f / static_cast<float>(n);
    ChartPoint q{static_cast<int>(row_index / n), -1.f + size * (static_cast<float>(cell % n) + 0.5f),
                 -1.f + size * (static_cast<float>(row_index % n) + 0.5f), 0.f};
    // Where the surface is expected, along the face's axis: of several over a cell the one nearest to the point.
    float expected = face_sign(q.face) * x[face_axis(q.face)];
    Approach best;
    for (int step = 0; step < k_approach_steps; ++step) {
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
        const int m = face_axis(q.face), u = (m + 1) % 3, v = (m + 2) % 3;
        const Vec3f foot = (1.f / value.w) * face_direction(q.face, q.s, q.t);
        const Vec3f d{part.a[0] * (foot.x - x.x), part.a[1] * (foot.y - x.y), part.a[2] * (foot.z - x.z)};
        const float distance_sq = norm_sq(d);
        const bool nearer = distance_sq < best.distance_sq;
        if (nearer) best = {distance_sq, foot};
        if (!nearer) break;
        Vec3f n{};
        n[m] = face_sign(q.face) * (value.w - value.ws * q.s - value.wt * q.t);
        n[u] = value.ws;
        n[v] = value.wt;
        const Vec3f scaled = map.over_axes_sq(n);
        const float length_sq = dot(n, scaled);
        const float gap = 1.f - dot(n, x);  // to the tangent plane, times the root of length_sq
        if (!(length_sq > 0.f) || distance_sq * length_sq <= k_approach_near * gap * gap) break;
        q = to_chart(x + (gap / length_sq) * scaled);
        expected = 1.f / q.w;
    }
    return best;
}

}  // namespace sqmap::query
