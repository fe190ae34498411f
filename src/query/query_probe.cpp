#include "sqmap/query/probe.h"

#include "query/exact/probe_exact.h"
#include "query/point/probe_job.h"
#include "query/point/probe_kernels.h"
#include "query/point/probe_pointwise.h"

#include <cmath>

namespace sqmap::query {

ProbeJob::ProbeJob(const model::ModelView& m, const Probe& p, const Pose& pose, const ProbeOptions& o,
                   std::span<ProbeContact> contacts) noexcept
    : model(m),
      x(p.x_.data()),
      y(p.y_.data()),
      z(p.z_.data()),
      point(p.point_.data()),
      centre_x(p.centre_x_.data()),
      centre_y(p.centre_y_.data()),
      centre_z(p.centre_z_.data()),
      radius(p.radius_.data()),
      group_x(p.group_x_.data()),
      group_y(p.group_y_.data()),
      group_z(p.group_z_.data()),
      group_radius(p.group_radius_.data()),
      clusters(p.clusters()),
      groups(p.group_radius_.size()),
      points(p.size_),
      layer(o.layer == Layer::Auto || (o.layer == Layer::Exact && !model::has_exact(m)) ? Layer::Three : o.layer),
      exact(o.layer == Layer::Exact && model::has_exact(m)),
      first_only(o.first_only),
      out(contacts)
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

ProbeResult query_probe(const model::ModelView& model, const Probe& probe, const Pose& pose, const ProbeOptions& options,
                        std::span<ProbeContact> contacts) noexcept
{
    const ProbeJob job(model, probe, pose, options, contacts);
    if (!job.finite) return {0, k_probe_not_finite, 0};
    // The locator knows nothing of a surface that has moved.
    const bool by_points = options.offset || options.margin > 0.f || !model::has_locator(model);
    ProbeResult result = by_points ? run_probe_pointwise(job, options) : (job.exact ? run_probe_exact(job) : run_probe(job));
    if (options.layer == Layer::Exact && !job.exact) result.status |= k_probe_no_exact;
    return result;
}

}  // namespace sqmap::query
