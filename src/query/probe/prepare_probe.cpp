// Constructors of probes, which allocate: they run outside the frame.
#include "sqmap/math/box.h"
#include "sqmap/query/probe.h"

#include <algorithm>
#include <numeric>

namespace sqmap::query {

namespace {

/// Orders points so that each run of k_cluster is near together: halves along the longest side, whole clusters on the left.
void order_by_halves(std::span<std::uint32_t> order, std::span<const Vec3d> points)
{
    if (order.size() <= Probe::k_cluster) return;
    Box box;
    for (const std::uint32_t i : order) extend(box, points[i]);
    const int axis = longest_axis(box);
    const std::size_t clusters = (order.size() + Probe::k_cluster - 1) / Probe::k_cluster;
    const std::size_t half = clusters / 2 * Probe::k_cluster;
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                         return points[a][axis] != points[b][axis] ? points[a][axis] < points[b][axis] : a < b;
                     });
    order_by_halves(order.first(half), points);
    order_by_halves(order.subspan(half), points);
}

}  // namespace

Probe::Probe(std::span<const Vec3d> points) : size_(points.size())
{
    if (points.empty()) return;
    origin_ = centre(box_of(points));
    std::vector<std::uint32_t> order(size_);
    std::iota(order.begin(), order.end(), 0u);
    order_by_halves(order, points);

    const std::size_t clusters = (size_ + k_cluster - 1) / k_cluster, groups = (clusters + k_cluster - 1) / k_cluster;
    for (auto* v : {&x_, &y_, &z_}) v->resize(clusters * k_cluster);
    point_.resize(clusters * k_cluster);
    slot_of_point_.resize(size_);
    for (std::size_t slot = 0; slot < point_.size(); ++slot) {
        point_[slot] = order[std::min(slot, size_ - 1)];
        if (slot < size_) slot_of_point_[point_[slot]] = static_cast<std::uint32_t>(slot);
    }
    for (auto* v : {&centre_x_, &centre_y_, &centre_z_, &radius_}) v->resize(clusters + k_cluster);  // read by whole vectors
    for (auto* v : {&group_x_, &group_y_, &group_z_, &group_radius_}) v->resize(groups);
    move(points);
    refit();
}

}  // namespace sqmap::query
