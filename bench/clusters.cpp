// Halving at the median of the longest side, at multiples of the block size so that every block but the last is full;
// spheres by Badoiu and Clarkson, "Smaller core-sets for balls" (2003).
#include "clusters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sqmap::bench {
namespace {

constexpr std::size_t k_group = std::size_t{k_lanes} * k_lanes;

void order_by_halving(std::span<const Vec3d> points, std::span<std::uint32_t> order)
{
    if (order.size() <= k_lanes) return;
    const std::size_t unit = order.size() > k_group ? k_group : k_lanes;
    const std::size_t half = (order.size() / 2 + unit - 1) / unit * unit;
    Vec3d lo = points[order[0]], hi = lo;
    for (const std::uint32_t v : order)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], points[v][k]);
            hi[k] = std::max(hi[k], points[v][k]);
        }
    const Vec3d side = hi - lo;
    const int axis = side.x >= side.y && side.x >= side.z ? 0 : (side.y >= side.z ? 1 : 2);
    std::nth_element(
        order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
        [&](std::uint32_t a, std::uint32_t b) { return std::pair(points[a][axis], a) < std::pair(points[b][axis], b); });
    order_by_halving(points, order.first(half));
    order_by_halving(points, order.subspan(half));
}

struct Sphere {
    Vec3d centre;
    double radius;
};

Sphere bounding_sphere(std::span<const Vec3d> points, std::span<const std::uint32_t> members)
{
    const auto farthest = [&](Vec3d c) {
        return points[*std::max_element(members.begin(), members.end(), [&](std::uint32_t a, std::uint32_t b) {
            return norm_sq(points[a] - c) < norm_sq(points[b] - c);
        })];
    };
    Vec3d centre = points[members[0]];
    for (int i = 1; i <= 200; ++i) centre += (farthest(centre) - centre) / (i + 1.0);
    return {centre, norm(farthest(centre) - centre)};
}

void put(SphereBlock& block, std::size_t lane, const Sphere& sphere)
{
    block.x[lane] = static_cast<float>(sphere.centre.x);
    block.y[lane] = static_cast<float>(sphere.centre.y);
    block.z[lane] = static_cast<float>(sphere.centre.z);
    // Rounding of the centre and of the kernel's own arithmetic.
    block.radius[lane] = static_cast<float>(sphere.radius * (1 + 1e-5) + 1e-6);
}

SphereBlock no_spheres()
{
    SphereBlock block{};
    std::fill(std::begin(block.radius), std::end(block.radius), -1.0f);
    return block;
}

}  // namespace

ClusteredProbe cluster(std::span<const Vec3d> vertices)
{
    std::vector<std::uint32_t> order(vertices.size());
    std::iota(order.begin(), order.end(), 0u);
    order_by_halving(vertices, order);
    const std::span<const std::uint32_t> all = order;
    const auto members = [&](std::size_t i, std::size_t size) {
        return all.subspan(size * i, std::min(size, all.size() - size * i));
    };
    ClusteredProbe probe;
    const std::size_t cluster_count = (all.size() + k_lanes - 1) / k_lanes, group_count = (all.size() + k_group - 1) / k_group;
    probe.groups.assign((group_count + k_lanes - 1) / k_lanes, no_spheres());
    probe.clusters.assign(group_count, no_spheres());
    probe.vertices.resize(group_count * k_lanes);
    for (std::size_t g = 0; g < group_count; ++g)
        put(probe.groups[g / k_lanes], g % k_lanes, bounding_sphere(vertices, members(g, k_group)));
    for (std::size_t c = 0; c < cluster_count; ++c) {
        const auto cluster_members = members(c, k_lanes);
        put(probe.clusters[c / k_lanes], c % k_lanes, bounding_sphere(vertices, cluster_members));
        for (std::size_t i = 0; i < k_lanes; ++i) {
            const std::uint32_t v = cluster_members[std::min(i, cluster_members.size() - 1)];
            probe.vertices[c].x[i] = static_cast<float>(vertices[v].x);
            probe.vertices[c].y[i] = static_cast<float>(vertices[v].y);
            probe.vertices[c].z[i] = static_cast<float>(vertices[v].z);
            probe.vertices[c].vertex[i] = v;
        }
        probe.last_lanes = static_cast<std::uint32_t>(cluster_members.size());
    }
    probe.group_list.resize(group_count + k_lanes);
    probe.cluster_list.resize(cluster_count + k_lanes);
    probe.last_block = static_cast<std::uint32_t>(cluster_count - 1);
    return probe;
}

}  // namespace sqmap::bench
