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

/// A unit vector in twice so many bits: the octahedron unfolded onto a square (Meyer et al. 2010).
template <int bits>
inline Vec3f octahedral_normal(std::uint32_t code)
{
    constexpr std::uint32_t mask = (1u << bits) - 1u;
    constexpr float step = 2.f / static_cast<float>(1 << bits), first = 0.5f * step - 1.f;
    const float x = static_cast<float>(code & mask) * step + first;
    const float y = static_cast<float>((code >> bits) & mask) * step + first;
    const float z = 1.f - std::abs(x) - std::abs(y), fold = std::max(-z, 0.f);
    return normalized(Vec3f{x < 0.f ? x + fold : x - fold, y < 0.f ? y + fold : y - fold, z});
}

/// The other way: n need not be of unit length.
template <int bits>
inline std::uint32_t octahedral_code(Vec3d n)
{
    constexpr int cells = 1 << bits;
    n = n / std::max(std::abs(n.x) + std::abs(n.y) + std::abs(n.z), 1e-300);
    const double x = n.z < 0 ? (1 - std::abs(n.y)) * (n.x < 0 ? -1 : 1) : n.x;
    const double y = n.z < 0 ? (1 - std::abs(n.x)) * (n.y < 0 ? -1 : 1) : n.y;
    const auto code = [](double v) {
        return static_cast<std::uint32_t>(std::clamp(static_cast<int>((v + 1) * 0.5 * cells), 0, cells - 1));
    };
    return code(x) | code(y) << bits;
}

/// Outward normal of a seed's plane.
inline Vec3f seed_normal(model::Seed seed) { return octahedral_normal<model::k_seed_normal_bits>(seed.direction >> 8); }

/// How far a point is below a seed's plane, model units. offset: from the centre of the seed's place.
inline float seed_gap(const model::Locator& locator, model::Seed seed, Vec3f offset)
{
    return static_cast<float>(model::seed_distance(seed)) * (model::k_seed_distance_step * locator.cell) -
           dot(seed_normal(seed), offset);
}

/// Outward normal of a flat place's plane.
inline Vec3f plane_normal(std::uint32_t plane) { return octahedral_normal<model::k_plane_normal_bits>(plane); }

/// How far a point is below a plane, model units. offset: from the centre of its place.
inline float plane_gap(const model::Locator& locator, std::uint32_t plane, Vec3f offset)
{
    return model::plane_distance(plane, locator.plane_reach) * locator.cell - dot(plane_normal(plane), offset);
}

/// How far a point is below the planes of a flat place: the lowest of the groups' highest (see model::k_joined), and where that
/// group ends among them.
struct FlatGap {
    float gap = INFINITY;
    std::size_t group_end = 0;
};
inline FlatGap flat_gap(const model::Locator& locator, std::span<const std::uint32_t> planes, Vec3f offset)
{
    FlatGap lowest;
    for (std::size_t k = 0; k < planes.size();) {
        float highest = -INFINITY;
        do highest = std::max(highest, plane_gap(locator, planes[k], offset));
        while (++k < planes.size() && (planes[k] & model::k_joined) != 0);
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
