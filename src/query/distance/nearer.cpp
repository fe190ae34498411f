// Tests if any point of a probe is nearer than a reach. The tree of bounds drops whole clusters that are farther.
#include "sqmap/query/distance.h"

#include "query/distance/distance_kernels.h"
#include "query/probe/probe_job.h"

#include <array>
#include <cmath>
#include <utility>

namespace sqmap::query {

namespace {

/// Posed points that may be near, asked some hundreds at a time.
class NearPoints {
public:
    static constexpr std::size_t k_size = 512;

    NearPoints(const model::ModelView& model, double reach) : model_(model), reach_(reach) {}

    /// True where one of those asked so far is nearer than the reach.
    [[nodiscard]] bool add(Vec3f in_model)
    {
        const model::Header& h = model_.header;
        points_[count_++] = h.unit * cast<double>(in_model) + Vec3d{h.origin[0], h.origin[1], h.origin[2]};
        return count_ == k_size && flush();
    }
    [[nodiscard]] bool flush()
    {
        distances(model_, std::span(points_.data(), count_), answers_, reach_);
        const std::size_t count = std::exchange(count_, 0);
        for (std::size_t i = 0; i < count; ++i)
            if ((answers_[i].status & k_not_finite) == 0 && answers_[i].distance < reach_) return true;
        return false;
    }

private:
    const model::ModelView& model_;
    double reach_;
    std::size_t count_ = 0;
    std::array<Vec3d, k_size> points_;
    std::array<SignedDistance, k_size> answers_;
};

/// How far a sphere in model space is from the surface, at least; negative where it may touch.
float clearance_of(const model::ModelView& model, Vec3f centre, float radius)
{
    const model::DistanceHeader& h = model.distance.header;
    const Vec3f d = centre - model::vec3(h.root);
    if (std::abs(d.x) < h.half && std::abs(d.y) < h.half && std::abs(d.z) < h.half) {
        NearestSurface found;
        std::uint16_t near = 0;
        (void)bound_surfaces(model, -INFINITY, {&centre, 1}, {&found, 1}, {&near, 1});
        // Inside, or about the surface.
        return found.sides == k_seen_inside ? -1.f : found.distance - radius * 1.00001f;
    }
    const float* sphere = model.header.sphere;
    return norm(centre - model::vec3(sphere)) * 0.99999f - sphere[3] - radius * 1.00001f;
}

}  // namespace

bool is_nearer(const Body& touched, const Body& collider, double reach) noexcept
{
    if (touched.model == nullptr || collider.probe == nullptr) return false;
    const model::ModelView& model = *touched.model;
    const ProbeJob job(touched, collider, {}, {});
    if (!job.finite || job.points == 0 || !(reach > 0) || !model::has_distance(model)) return false;
    const auto reach_in_model = static_cast<float>(reach / model.header.unit * (1 + 1e-6));
    const auto is_far = [&](Vec3f centre, float radius) {
        return clearance_of(model, job.in_model_space(centre), radius * job.scale) > reach_in_model;
    };
    if (is_far({job.sphere[0], job.sphere[1], job.sphere[2]}, job.sphere[3])) return false;
    NearPoints near(model, reach);
    for (std::size_t c = 0; c < job.clusters; ++c) {
        if (is_far({job.centre_x[c], job.centre_y[c], job.centre_z[c]}, job.radius[c])) continue;
        for (std::size_t slot = c * Probe::k_cluster; slot < std::min(job.points, (c + 1) * Probe::k_cluster); ++slot)
            if (near.add(job.in_model_space({job.x[slot], job.y[slot], job.z[slot]}))) return true;
    }
    return near.flush();
}

}  // namespace sqmap::query
