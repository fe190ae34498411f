#include "sqmap/query/frame.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sqmap::query {

namespace {

/// Orders points so that each run of k_cluster is near together: halves along the longest side, whole clusters on the left.
void order_by_halves(std::span<std::uint32_t> order, std::span<const Vec3d> points)
{
    if (order.size() <= Probe::k_cluster) return;
    Vec3d lo = points[order.front()], hi = lo;
    for (const std::uint32_t i : order)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], points[i][k]);
            hi[k] = std::max(hi[k], points[i][k]);
        }
    const Vec3d side = hi - lo;
    const int axis = side.x >= side.y && side.x >= side.z ? 0 : (side.y >= side.z ? 1 : 2);
    const std::size_t clusters = (order.size() + Probe::k_cluster - 1) / Probe::k_cluster;
    const std::size_t half = clusters / 2 * Probe::k_cluster;
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return points[a][axis] != points[b][axis] ? points[a][axis] < points[b][axis] : a < b;
    });
    order_by_halves(order.first(half), points);
    order_by_halves(order.subspan(half), points);
}

/// A sphere that holds the points: about the box's centre, moved towards what sticks out (Ritter 1990).
template <class At>
void fit_sphere(std::size_t count, At&& at, float sphere[4])
{
    Vec3f lo = at(0), hi = lo;
    for (std::size_t i = 1; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], at(i)[k]);
            hi[k] = std::max(hi[k], at(i)[k]);
        }
    Vec3f centre = 0.5f * (lo + hi);
    float best = INFINITY;
    Vec3f c = centre;
    float pull = 0.3f;
    for (int step = 0; step < 12; ++step, pull *= 0.8f) {
        float radius_sq = 0.f;
        Vec3f farthest = c;
        for (std::size_t i = 0; i < count; ++i)
            if (const float d = norm_sq(at(i) - c); d > radius_sq) {
                radius_sq = d;
                farthest = at(i);
            }
        if (radius_sq < best) {
            best = radius_sq;
            centre = c;
        }
        c += pull * (farthest - c);
    }
    for (int k = 0; k < 3; ++k) sphere[k] = centre[k];
    sphere[3] = std::sqrt(best) * 1.00001f;
}

}  // namespace

Pose compose(const Pose& a, const Pose& b) noexcept { return {a.rotation * b.rotation, a.rotation * b.translation + a.translation}; }

Pose inverse(const Pose& pose) noexcept
{
    return {transpose(pose.rotation), -transpose_mul(pose.rotation, pose.translation)};
}

Probe::Probe(std::span<const Vec3d> points) : size_(points.size())
{
    if (points.empty()) return;
    Vec3d lo = points.front(), hi = lo;
    for (const Vec3d& p : points)
        for (int k = 0; k < 3; ++k) {
            lo[k] = std::min(lo[k], p[k]);
            hi[k] = std::max(hi[k], p[k]);
        }
    origin_ = 0.5 * (lo + hi);
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
}

void Probe::move(std::span<const Vec3d> points) noexcept
{
    if (points.size() != size_) return;
    for (std::size_t slot = 0; slot < point_.size(); ++slot) {
        const Vec3d p = points[point_[slot]] - origin_;
        x_[slot] = static_cast<float>(p.x);
        y_[slot] = static_cast<float>(p.y);
        z_[slot] = static_cast<float>(p.z);
    }
    refit();
}

void Probe::refit() noexcept
{
    const auto place = [&](std::size_t slot) { return Vec3f{x_[slot], y_[slot], z_[slot]}; };
    float s[4];
    for (std::size_t c = 0; c < clusters(); ++c) {
        fit_sphere(k_cluster, [&](std::size_t i) { return place(c * k_cluster + i); }, s);
        centre_x_[c] = s[0];
        centre_y_[c] = s[1];
        centre_z_[c] = s[2];
        radius_[c] = s[3];
    }
    for (std::size_t g = 0; g < group_radius_.size(); ++g) {
        const std::size_t first = g * k_cluster * k_cluster, last = std::min(point_.size(), first + k_cluster * k_cluster);
        fit_sphere(last - first, [&](std::size_t i) { return place(first + i); }, s);
        group_x_[g] = s[0];
        group_y_[g] = s[1];
        group_z_[g] = s[2];
        group_radius_[g] = s[3];
    }
    if (size_ > 0) fit_sphere(point_.size(), place, sphere_);
}

}  // namespace sqmap::query
