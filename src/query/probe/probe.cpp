#include "sqmap/query/probe.h"
#include "query/probe/triangle_tree.h"

#include "math/small_sphere.h"
#include "refit.h"
#include "sqmap/math/assert.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace sqmap::query {

namespace {

/// A sphere that holds the points.
template <class At>
void fit_sphere(std::size_t count, At&& at, float sphere[4])
{
    const Sphere3<float> small = small_sphere<float>(count, at, {.steps = 12, .pull = 0.3f, .shrink = 0.8f});
    for (int k = 0; k < 3; ++k) sphere[k] = small.centre[k];
    sphere[3] = small.radius * 1.00001f;
}

/// Numbers the positions of all probes.
std::uint64_t next_stamp() noexcept
{
    static constinit std::atomic<std::uint64_t> stamp{0};
    return stamp.fetch_add(1, std::memory_order_relaxed) + 1;
}

float least(float a, float b) { return a < b ? a : b; }
float greatest(float a, float b) { return a > b ? a : b; }

/// A sphere about spheres, those of hidden clusters left out; far away where all are hidden.
void bound_spheres(std::size_t count, const float* x, const float* y, const float* z, const float* r, float sphere[4])
{
    constexpr float k_shown = 0.5f * Probe::k_far;
    float lo[3] = {Probe::k_far, Probe::k_far, Probe::k_far}, hi[3] = {-Probe::k_far, -Probe::k_far, -Probe::k_far};
    const float* at[3] = {x, y, z};
    for (std::size_t i = 0; i < count; ++i)
        if (x[i] < k_shown)
            for (int k = 0; k < 3; ++k) {
                lo[k] = least(lo[k], at[k][i] - r[i]);
                hi[k] = greatest(hi[k], at[k][i] + r[i]);
            }
    float radius = 0.f;
    const bool none = lo[0] >= hi[0] && !(lo[0] < k_shown);
    for (int k = 0; k < 3; ++k) sphere[k] = none ? Probe::k_far : 0.5f * (lo[k] + hi[k]);
    for (std::size_t i = 0; i < count && !none; ++i)
        if (x[i] < k_shown) radius = greatest(radius, norm(Vec3f{x[i] - sphere[0], y[i] - sphere[1], z[i] - sphere[2]}) + r[i]);
    sphere[3] = radius * 1.00001f;
}

}  // namespace

std::size_t Probe::bytes() const noexcept
{
    const auto size_of = [](const auto&... values) { return (std::span(values).size_bytes() + ...); };
    return sizeof(*this) +
           size_of(slot_of_point_, x_, y_, z_, point_, centre_x_, centre_y_, centre_z_, radius_, group_x_, group_y_, group_z_,
                   group_radius_) +
           sizeof(TriangleTree) + triangles_.get().bytes();
}

void Probe::move(std::span<const Vec3d> points) noexcept { move(points, {}); }

void Probe::move(std::span<const Vec3d> points, std::span<const std::uint8_t> wanted) noexcept
{
    SQMAP_ASSERT(points.size() == size() && (wanted.empty() || wanted.size() == size()));
    if (points.size() != size_) return;
    stamp_ = next_stamp();
    fill_clusters(
        points.data(), point_.data(), origin_, wanted.size() == size_ ? wanted.data() : nullptr, k_far,
        {x_.data(), y_.data(), z_.data(), centre_x_.data(), centre_y_.data(), centre_z_.data(), radius_.data(), clusters()});
    refit_groups();
    if (TriangleTree& tree = triangles_.get(); tree.size() > 0) tree.move(points);
}

std::size_t Probe::triangle_count() const noexcept { return triangles_.get().size(); }

Sphere Probe::sphere() const noexcept
{
    return {origin_ + cast<double>(Vec3f{sphere_[0], sphere_[1], sphere_[2]}), static_cast<double>(sphere_[3])};
}

bool Probe::reaches(const Sphere& sphere) const noexcept
{
    const Vec3f c = cast<float>(sphere.centre - origin_);
    const auto radius = static_cast<float>(sphere.radius * (1 + 1e-6));
    const auto touches = [&](float x, float y, float z, float r) {
        return norm_sq(Vec3f{x, y, z} - c) <= (r + radius) * (r + radius);
    };
    if (size_ == 0 || !touches(sphere_[0], sphere_[1], sphere_[2], sphere_[3])) return false;
    for (std::size_t g = 0; g < group_radius_.size(); ++g) {
        if (!touches(group_x_[g], group_y_[g], group_z_[g], group_radius_[g])) continue;
        for (std::size_t i = g * k_cluster; i < std::min((g + 1) * k_cluster, clusters()); ++i)
            if (touches(centre_x_[i], centre_y_[i], centre_z_[i], radius_[i])) return true;
    }
    return false;
}

void Probe::refit() noexcept
{
    const auto position = [&](std::size_t slot) { return Vec3f{x_[slot], y_[slot], z_[slot]}; };
    float s[4], sum = 0.f;
    for (std::size_t c = 0; c < clusters(); ++c) {
        fit_sphere(
            k_cluster, [&](std::size_t i) { return position(c * k_cluster + i); }, s);
        centre_x_[c] = s[0];
        centre_y_[c] = s[1];
        centre_z_[c] = s[2];
        radius_[c] = s[3];
        sum += s[3];
    }
    for (std::size_t g = 0; g < group_radius_.size(); ++g) {
        const std::size_t first = g * k_cluster * k_cluster, last = std::min(point_.size(), first + k_cluster * k_cluster);
        fit_sphere(
            last - first, [&](std::size_t i) { return position(first + i); }, s);
        group_x_[g] = s[0];
        group_y_[g] = s[1];
        group_z_[g] = s[2];
        group_radius_[g] = s[3];
    }
    if (size_ > 0) {
        fit_sphere(point_.size(), position, sphere_);
        // n points, each with a square of its own: pi r^2 = n spacing^2.
        spacing_ = sum / static_cast<float>(clusters()) * std::sqrt(3.14159f / static_cast<float>(k_cluster));
    }
}

void Probe::refit_groups() noexcept
{
    // Spheres about the boxes' centres: a few percent larger than the least ones and found in a tenth of the time, which counts
    // where points move every frame.
    float sum = 0.f;
    std::size_t shown = 0;
    for (std::size_t c = 0; c < clusters(); ++c)
        if (centre_x_[c] < 0.5f * k_far) {
            sum += radius_[c];
            ++shown;
        }
    for (std::size_t g = 0; g < group_radius_.size(); ++g) {
        const std::size_t first = g * k_cluster;
        float s[4];
        bound_spheres(std::min(clusters() - first, k_cluster), &centre_x_[first], &centre_y_[first], &centre_z_[first],
                      &radius_[first], s);
        group_x_[g] = s[0];
        group_y_[g] = s[1];
        group_z_[g] = s[2];
        group_radius_[g] = s[3];
    }
    if (size_ > 0) {
        bound_spheres(group_radius_.size(), group_x_.data(), group_y_.data(), group_z_.data(), group_radius_.data(), sphere_);
        // n points, each with a square of its own: pi r^2 = n spacing^2.
        if (shown > 0) spacing_ = sum / static_cast<float>(shown) * std::sqrt(3.14159f / static_cast<float>(k_cluster));
    }
}

}  // namespace sqmap::query
