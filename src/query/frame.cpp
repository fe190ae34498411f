#include "sqmap/query/frame.h"

#include "frame_job.h"
#include "frame_kernels.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

FrameJob::FrameJob(const model::ModelView& m, const Probe& p, const Pose& pose, const FrameOptions& o,
                   std::span<FrameContact> contacts) noexcept
    : model(m), x(p.x_.data()), y(p.y_.data()), z(p.z_.data()), point(p.point_.data()), centre_x(p.centre_x_.data()),
      centre_y(p.centre_y_.data()), centre_z(p.centre_z_.data()), radius(p.radius_.data()), group_x(p.group_x_.data()),
      group_y(p.group_y_.data()), group_z(p.group_z_.data()), group_radius(p.group_radius_.data()), clusters(p.clusters()),
      groups(p.group_radius_.size()), points(p.size_), layer(o.layer == Layer::Auto ? Layer::Three : o.layer),
      exact(o.layer == Layer::Exact && model::has_exact(m)), first_only(o.first_only), out(contacts)
{
    for (int k = 0; k < 4; ++k) sphere[k] = p.sphere_[k];
    // In double up to here: a mesh may lie far from its origin.
    const double unit = m.header.unit;
    const Vec3d origin{m.header.origin[0], m.header.origin[1], m.header.origin[2]};
    const Vec3d shift = (pose.rotation * p.origin_ + pose.translation - origin) / unit;
    finite = true;
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) rotation[3 * i + j] = static_cast<float>(pose.rotation.row[i][j] / unit);
        largest = std::max(largest, norm(pose.rotation.row[i]));
        translation[i] = static_cast<float>(shift[i]);
        finite = finite && std::isfinite(translation[i]) && std::isfinite(norm(pose.rotation.row[i]));
    }
    scale = static_cast<float>(largest / unit * (1 + 1e-5));
}

namespace {

Vec3f posed(const FrameJob& job, float x, float y, float z)
{
    const float* r = job.rotation;
    return {r[0] * x + r[1] * y + r[2] * z + job.translation[0], r[3] * x + r[4] * y + r[5] * z + job.translation[1],
            r[6] * x + r[7] * y + r[8] * z + job.translation[2]};
}

/// True where a sphere of the probe misses the spheres of all parts.
bool is_clear(const FrameJob& job, float x, float y, float z, float radius)
{
    const Vec3f c = posed(job, x, y, z);
    for (const model::Part& part : job.model.parts) {
        const float reach = radius * job.scale + part.sphere[3];
        if (norm_sq(c - model::vec3(part.sphere)) <= reach * reach) return false;
    }
    return true;
}

/// Point by point: Layer 1, whose superquadrics the locator knows nothing of, and models that have none.
FrameResult ask_each(const FrameJob& job, std::span<FrameContact> contacts)
{
    FrameResult result;
    for (std::size_t g = 0; g < job.groups; ++g) {
        if (is_clear(job, job.group_x[g], job.group_y[g], job.group_z[g], job.group_radius[g])) continue;
        for (std::size_t c = g * Probe::k_cluster; c < std::min(job.clusters, (g + 1) * Probe::k_cluster); ++c) {
            if (is_clear(job, job.centre_x[c], job.centre_y[c], job.centre_z[c], job.radius[c])) continue;
            for (std::size_t i = c * Probe::k_cluster; i < std::min(job.points, (c + 1) * Probe::k_cluster); ++i) {
                const Contact contact = query_point(job.model, posed(job, job.x[i], job.y[i], job.z[i]), job.layer);
                if (!contact.contact) continue;
                if (result.contacts < contacts.size())
                    contacts[result.contacts] = {contact.point, contact.normal, contact.depth, job.point[i], static_cast<std::int16_t>(contact.part),
                                                 contact.certain, contact.status};
                else
                    result.status |= k_frame_full;
                ++result.contacts;
                if (job.first_only) return result;
            }
        }
    }
    return result;
}

}  // namespace

FrameResult query_frame(const model::ModelView& model, const Probe& probe, const Pose& pose, const FrameOptions& options,
                        std::span<FrameContact> contacts) noexcept
{
    const FrameJob job(model, probe, pose, options, contacts);
    if (!job.finite) return {0, k_frame_not_finite, 0};
    FrameResult result = model::has_locator(model) && job.layer != Layer::One ? run_frame(job) : ask_each(job, contacts);
    if (options.layer == Layer::Exact && !job.exact) result.status |= k_frame_no_exact;
    return result;
}

}  // namespace sqmap::query
