// J. A. Baerentzen, H. Aanaes, "Signed distance computation using the angle weighted pseudonormal", IEEE TVCG 11(3), 2005, is the
// problem; here the side is what the nearest triangles agree on. Beyond the band a tree of bounds answers: distances change no
// faster than places (S. F. Frisken et al., "Adaptively sampled distance fields", SIGGRAPH 2000).
#include "query/distance/distance_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/distance/distance_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/distance/bounds-inl.h"
#include "query/distance/packet-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Points are sought together where leaves have several of them, else one by one.
bool are_dense(const ModelView& model, std::span<const Vec3f> points, std::span<const std::uint16_t> near)
{
    constexpr std::size_t k_few = 8;
    constexpr float k_leaves_a_point = 5;
    if (near.size() <= k_few) return false;
    Vec3f lo = points[near.front()], hi = lo;
    for (const std::uint16_t i : near)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], points[i][k]);
            hi[k] = std::max(hi[k], points[i][k]);
        }
    // Of the object's leaves those about the points, as though the surface were spread over its sphere.
    const Vec3f extent = hi - lo;
    const float share = std::max({extent.x, extent.y, extent.z}) / (2 * model.header.sphere[3]);
    const auto leaves = static_cast<float>(model::leaf_count(model.distance.header.entries));
    return k_leaves_a_point * static_cast<float>(near.size()) >= leaves * std::min(share * share, 1.f);
}

/// Bounds for all; near: those that are not beyond, returns how many.
HWY_NOINLINE std::size_t find_bounds(const ModelView& model, float within, std::span<const Vec3f> points,
                                     std::span<NearestSurface> found, std::uint16_t* near)
{
    const model::DistanceArrays<model::ArrayView>& arrays = model.distance;
    std::size_t count = 0;
    HWY_ALIGN float at[3][k_lanes];
    for (std::size_t first = 0; first < points.size(); first += hn::Lanes(df)) {
        const std::size_t n = std::min(points.size() - first, hn::Lanes(df));
        for (std::size_t i = 0; i < hn::Lanes(df); ++i)
            for (int k = 0; k < 3; ++k) at[k][i] = points[first + std::min(i, n - 1)][k];
        const BoundLeaf leaf = find_leaf(arrays, {hn::Load(df, at[0]), hn::Load(df, at[1]), hn::Load(df, at[2])});
        HWY_ALIGN float bound[k_lanes];
        HWY_ALIGN std::int32_t word[k_lanes];
        hn::Store(leaf.bound, df, bound);
        hn::Store(leaf.word, di, word);
        for (std::size_t i = 0; i < n; ++i) {
            NearestSurface& out = found[first + i];
            out = {};
            const bool inside = (static_cast<std::uint32_t>(word[i]) & model::k_bound_inside) != 0;
            out.sides = inside ? k_seen_inside : k_seen_outside;
            out.bound = bound[i] > within && (static_cast<std::uint32_t>(word[i]) & model::k_bound_code) >= model::k_least_bound;
            out.distance = bound[i];
            if (out.bound) continue;
            near[count++] = static_cast<std::uint16_t>(first + i);
        }
    }
    return count;
}

HWY_NOINLINE void find_near(const ModelView& model, std::span<const Vec3f> points, std::span<NearestSurface> found,
                            std::span<const std::uint16_t> near)
{
    PointPacket packet;
    packet.count = near.size();
    for (std::size_t k = 0; k < near.size(); ++k) packet.put(k, points[near[k]]);
    // A whole vector of numbers.
    for (std::size_t k = near.size(); k % hn::Lanes(df) != 0; ++k) packet.put(k, points[near.back()]);
    const Hierarchy hierarchy(model);
    if (are_dense(model, points, near))
        PacketSearch(model, packet).run();
    else
        for (std::size_t k = 0; k < near.size(); ++k) hierarchy.search(packet, k);
    NearestSurface some[k_lanes];
    for (std::size_t first = 0; first < near.size(); first += hn::Lanes(df)) {
        hierarchy.finish(packet, first, some);
        for (std::size_t k = first; k < std::min(near.size(), first + hn::Lanes(df)); ++k) found[near[k]] = some[k - first];
    }
}

}  // namespace

void find_nearest(const ModelView& model, float within, std::span<const Vec3f> points, std::span<NearestSurface> found)
{
    std::uint16_t near[PointPacket::k_size];
    for (std::size_t first = 0; first < points.size(); first += PointPacket::k_size) {
        const auto some = points.subspan(first, std::min(points.size() - first, PointPacket::k_size));
        const auto out = found.subspan(first, some.size());
        const std::size_t count = find_bounds(model, within, some, out, near);
        if (model.distance.groups.empty() || count == 0) continue;
        find_near(model, some, out, {near, count});
    }
}

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(find_nearest);

void nearest_surfaces(const model::ModelView& model, float within, std::span<const Vec3f> points,
                      std::span<NearestSurface> found) noexcept
{
    HWY_DYNAMIC_DISPATCH(find_nearest)(model, within, points, found);
}

}  // namespace sqmap::query
#endif
