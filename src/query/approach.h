// From a seed to the nearest surface about it, one point at a time: what bake tries seeds with, and the reference of the frame
// query's kernel.
#pragma once

#include "central_map.h"

#include <span>

namespace sqmap::query {

inline constexpr int k_approach_steps = 5;
/// Squared distance to the surface point found over that to its tangent plane: within it, the plane's foot is the nearest
/// point, with an error of second order.
inline constexpr float k_approach_near = 1.01f;

/// Outward normal of a seed's plane.
inline Vec3f seed_normal(model::Seed seed)
{
    constexpr std::uint32_t mask = (1u << model::k_seed_normal_bits) - 1u;
    constexpr float step = 2.f / static_cast<float>(1 << model::k_seed_normal_bits);
    const float x = (static_cast<float>((seed.direction >> 8) & mask) + 0.5f) * step - 1.f;
    const float y = (static_cast<float>((seed.direction >> (8 + model::k_seed_normal_bits)) & mask) + 0.5f) * step - 1.f;
    const float z = 1.f - std::abs(x) - std::abs(y), fold = std::max(-z, 0.f);
    return normalized(Vec3f{x < 0.f ? x + fold : x - fold, y < 0.f ? y + fold : y - fold, z});
}

/// How far a point is below a seed's plane, model units. offset: from the centre of the seed's place.
inline float seed_gap(const model::Locator& locator, model::Seed seed, Vec3f offset)
{
    return static_cast<float>(model::seed_distance(seed)) * (model::k_seed_distance_step * locator.cell) -
           dot(seed_normal(seed), offset);
}

/// How far a point is below the planes of a flat chain: the lowest of the groups' highest (see model::k_joined), and where that
/// group ends in the chain.
struct FlatGap {
    float gap = INFINITY;
    std::size_t group_end = 0;
};
inline FlatGap flat_gap(const model::Locator& locator, std::span<const model::Seed> chain, Vec3f offset)
{
    FlatGap lowest;
    for (std::size_t k = 0; k < chain.size();) {
        float highest = -INFINITY;
        do highest = std::max(highest, seed_gap(locator, chain[k], offset));
        while (++k < chain.size() && (chain[k].extent & model::k_joined) != 0);
        if (highest < lowest.gap) lowest = {highest, k};
    }
    return lowest;
}

struct Approach {
    float distance_sq = INFINITY;  ///< model units
    Vec3f offset{};                ///< from the point to the surface, chart frame times axes
};

/// x: the point, start: its foot on the seed's plane, both in the chart frame. Looks the surface up over start, takes the
/// point's foot on the tangent plane there for the next start, while that comes nearer.
inline Approach approach(const CentralMap& map, const model::Part& part, Vec3f x, Vec3f start)
{
    ChartPoint q = to_chart(start);
    float expected = 1.f / q.w;  // along the face's axis: of several surfaces the one nearest to there
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
        const Vec3f offset{part.a[0] * (foot.x - x.x), part.a[1] * (foot.y - x.y), part.a[2] * (foot.z - x.z)};
        const float distance_sq = norm_sq(offset);
        if (!(distance_sq < best.distance_sq)) break;
        best = {distance_sq, offset};
        Vec3f n{};
        n[m] = face_sign(q.face) * (value.w - value.ws * q.s - value.wt * q.t);
        n[u] = value.ws;
        n[v] = value.wt;
        const Vec3f scaled = map.over_axes_sq(n);
        const float length_sq = dot(n, scaled), gap = 1.f - dot(n, x);
        if (!(length_sq > 0.f)) break;
        const float along = gap / length_sq, plane_sq = gap * along;
        if (distance_sq <= k_approach_near * plane_sq) {
            best = {plane_sq, {along * n.x / part.a[0], along * n.y / part.a[1], along * n.z / part.a[2]}};
            break;
        }
        q = to_chart(x + along * scaled);
        expected = 1.f / q.w;
    }
    return best;
}

}  // namespace sqmap::query
