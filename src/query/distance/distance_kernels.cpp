// J. A. Baerentzen, H. Aanaes, "Signed distance computation using the angle weighted pseudonormal", IEEE TVCG 11(3), 2005, is the
// problem; here the side is what the nearest triangles agree on. Beyond the band a tree of bounds answers: distances change no
// faster than positions (S. F. Frisken et al., "Adaptively sampled distance fields", SIGGRAPH 2000).
#include "query/distance/distance_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/distance/distance_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/distance/bounds-inl.h"
#include "query/distance/packet-inl.h"
#include "sqmap/math/assert.h"
#include "sqmap/math/box.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Points are sought together where leaves have several of them, else one by one.
bool are_dense(const ModelView& model, std::span<const Vec3f> points)
{
    constexpr std::size_t k_few = 8;
    constexpr float k_leaves_a_point = 5;
    if (points.size() <= k_few) return false;
    // The number of the object's leaves near the points, as though the surface were spread evenly over the object's sphere.
    const Vec3f extent = size(box_of(points));
    const float share = std::max({extent.x, extent.y, extent.z}) / (2 * model.header.sphere[3]);
    const auto leaves = static_cast<float>(model::leaf_count(model.distance.header.entries));
    return k_leaves_a_point * static_cast<float>(points.size()) >= leaves * std::min(share * share, 1.f);
}

void fill(PointPacket& packet, std::span<const Vec3f> points)
{
    packet.count = points.size();
    for (std::size_t k = 0; k < points.size(); ++k) packet.put(k, points[k]);
    // A whole vector of numbers.
    for (std::size_t k = points.size(); k % hn::Lanes(df) != 0; ++k) packet.put(k, points.back());
}

/// By packets or one by one. near, slack: as a Hierarchy takes them.
void search_all(const ModelView& model, std::span<const Vec3f> points, PointPacket& packet, NearTriangles* near, float slack)
{
    if (are_dense(model, points)) {
        PacketSearch(model, packet, near, slack).run();
        return;
    }
    const Hierarchy hierarchy(model, near, slack);
    for (std::size_t k = 0; k < points.size(); ++k) hierarchy.search(packet, k);
}

/// By how much triangles may be nearer to one of the points than float says, and the nearest farther, together.
float slack_of(const ModelView& model, std::span<const Vec3f> points)
{
    const auto sum = [](Vec3f v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
    float farthest = 0;
    for (const Vec3f& p : points) farthest = std::max(farthest, sum(p));
    const float radius = model.header.sphere[3];
    return 2.1f * (k_box_rounding * (farthest + sum(model::vec3(model.header.sphere)) + radius) + k_flat_height * 2 * radius);
}

}  // namespace

std::size_t find_bounds(const ModelView& model, float within, std::span<const Vec3f> points, std::span<NearestSurface> found,
                        std::uint16_t* near)
{
    const model::DistanceArrays<model::ArrayView>& arrays = model.distance;
    std::size_t count = 0;
    HWY_ALIGN float last[3 * k_lanes] = {};
    for (std::size_t first = 0; first < points.size(); first += hn::Lanes(df)) {
        const std::size_t n = std::min(points.size() - first, hn::Lanes(df));
        const float* from = &points[first].x;
        if (n < hn::Lanes(df)) {
            for (std::size_t i = 0; i < 3 * n; ++i) last[i] = from[i];
            from = last;
        }
        V3 p;
        hn::LoadInterleaved3(df, from, p.x, p.y, p.z);
        const BoundLeaf leaf = find_leaf(arrays, p);
        const I code = hn::And(leaf.word, set_int(static_cast<std::int32_t>(model::k_bound_code)));
        const M beyond = hn::And(hn::Gt(leaf.bound, set(within)),
                                 hn::RebindMask(df, hn::Gt(code, set_int(static_cast<std::int32_t>(model::k_least_bound) - 1))));
        const M inside =
            hn::Not(equal(hn::And(leaf.word, set_int(static_cast<std::int32_t>(model::k_bound_inside))), hn::Zero(di)));
        HWY_ALIGN float bound[k_lanes];
        HWY_ALIGN std::int32_t sides[k_lanes];
        hn::Store(leaf.bound, df, bound);
        hn::Store(blend(inside, set_int(k_seen_inside), set_int(k_seen_outside)), di, sides);
        for (std::size_t i = 0; i < n; ++i) {
            NearestSurface& out = found[first + i];
            out.distance = bound[i];
            out.sides = static_cast<std::uint32_t>(sides[i]);
        }
        each_lane(hn::AndNot(beyond, hn::FirstN(df, n)),
                  [&](std::size_t i) { near[count++] = static_cast<std::uint16_t>(first + i); });
    }
    return count;
}

void find_nearest(const ModelView& model, std::span<const Vec3f> points, std::span<NearestSurface> found)
{
    PointPacket packet;
    fill(packet, points);
    search_all(model, points, packet, nullptr, 0);
    const Hierarchy hierarchy(model);
    for (std::size_t first = 0; first < points.size(); first += hn::Lanes(df)) hierarchy.finish(packet, first, &found[first]);
}

void find_near_triangles(const ModelView& model, std::span<const Vec3f> points, std::span<NearTriangles> near)
{
    PointPacket packet;
    fill(packet, points);
    for (std::size_t k = 0; k < points.size(); ++k) near[k].count = 0;
    const float slack = slack_of(model, points);
    search_all(model, points, packet, near.data(), slack);
    const Hierarchy hierarchy(model, near.data(), slack);
    for (std::size_t k = 0; k < points.size(); ++k) {
        const std::uint32_t slot = packet.slot[k];
        near[k].entry = slot == PointPacket::k_no_slot ? -1 : static_cast<std::int32_t>(hierarchy.entry_at(slot));
        if (near[k].count != NearTriangles::k_too_many) drop_far(near[k], hierarchy.reach_above(packet.distance_sq[k]));
    }
}

void find_leaves(const ModelView& model, Vec3f point, float reach, LeafVisit visit, void* context)
{
    Hierarchy(model).each_leaf(point, reach, [=](std::uint32_t leaf) { return visit(context, leaf); });
}

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>

namespace sqmap::query {

HWY_EXPORT(find_bounds);
HWY_EXPORT(find_nearest);
HWY_EXPORT(find_near_triangles);
HWY_EXPORT(find_leaves);

std::size_t bound_surfaces(const model::ModelView& model, float within, std::span<const Vec3f> points,
                           std::span<NearestSurface> found, std::span<std::uint16_t> near) noexcept
{
    SQMAP_ASSERT(found.size() >= points.size() && near.size() >= points.size() && model::has_distance(model));
    return HWY_DYNAMIC_DISPATCH(find_bounds)(model, within, points, found, near.data());
}

void search_surfaces(const model::ModelView& model, std::span<const Vec3f> points, std::span<NearestSurface> found) noexcept
{
    SQMAP_ASSERT(found.size() >= points.size());
    if (points.empty()) return;
    if (model.distance.groups.empty())
        std::fill_n(found.begin(), points.size(), NearestSurface{});
    else
        HWY_DYNAMIC_DISPATCH(find_nearest)(model, points, found);
}

void search_near_triangles(const model::ModelView& model, std::span<const Vec3f> points, std::span<NearTriangles> near) noexcept
{
    SQMAP_ASSERT(near.size() >= points.size());
    if (points.empty()) return;
    if (model.distance.groups.empty())
        std::fill_n(near.begin(), points.size(), NearTriangles{-1, 0, {}, {}});
    else
        HWY_DYNAMIC_DISPATCH(find_near_triangles)(model, points, near);
}

void visit_leaves(const model::ModelView& model, Vec3f point, float reach, LeafVisit visit, void* context) noexcept
{
    SQMAP_ASSERT(!model.distance.groups.empty());
    HWY_DYNAMIC_DISPATCH(find_leaves)(model, point, reach, visit, context);
}

}  // namespace sqmap::query
#endif
