#include "sqmap/query/frame.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

namespace {

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

Pose compose(const Pose& a, const Pose& b) noexcept
{
    return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}

Pose inverse(const Pose& pose) noexcept { return {transpose(pose.rotation), -transpose_mul(pose.rotation, pose.translation)}; }

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

Sphere Probe::sphere() const noexcept
{
    return {origin_ + cast<double>(Vec3f{sphere_[0], sphere_[1], sphere_[2]}), static_cast<double>(sphere_[3])};
}

void Probe::refit() noexcept
{
    const auto place = [&](std::size_t slot) { return Vec3f{x_[slot], y_[slot], z_[slot]}; };
    float s[4], sum = 0.f;
    for (std::size_t c = 0; c < clusters(); ++c) {
        fit_sphere(
            k_cluster, [&](std::size_t i) { return place(c * k_cluster + i); }, s);
        centre_x_[c] = s[0];
        centre_y_[c] = s[1];
        centre_z_[c] = s[2];
        radius_[c] = s[3];
        sum += s[3];
    }
    for (std::size_t g = 0; g < group_radius_.size(); ++g) {
        const std::size_t first = g * k_cluster * k_cluster, last = std::min(point_.size(), first + k_cluster * k_cluster);
        fit_sphere(
            last - first, [&](std::size_t i) { return place(first + i); }, s);
        group_x_[g] = s[0];
        group_y_[g] = s[1];
        group_z_[g] = s[2];
        group_radius_[g] = s[3];
    }
    if (size_ > 0) {
        fit_sphere(point_.size(), place, sphere_);
        // n points, each with a square of its own: pi r^2 = n spacing^2.
        spacing_ = sum / static_cast<float>(clusters()) * std::sqrt(3.14159f / static_cast<float>(k_cluster));
    }
}

}  // namespace sqmap::query
