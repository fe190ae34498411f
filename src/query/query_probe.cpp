#include "sqmap/query/probe.h"

#include "query/exact/probe_exact.h"
#include "query/point/layer.h"
#include "query/point/probe_job.h"
#include "query/point/probe_kernels.h"
#include "query/point/probe_pointwise.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

ProbeJob::ProbeJob(const model::ModelView& m, const Probe& p, const Pose& pose, const QueryOptions& o,
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
      layer(chosen_layer(m, o)),
      layer3_gate(o.layer3_gate),
      first_only(o.first_only),
      out(contacts)
{
    for (int k = 0; k < 4; ++k) sphere[k] = p.sphere_[k];
    // In double up to here: a mesh may lie far from its origin.
    const double unit = m.header.unit;
    const Vec3d origin{m.header.origin[0], m.header.origin[1], m.header.origin[2]};
    const Vec3d shift = (pose.rotation * p.origin_ + pose.translation - origin) / unit;
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) rotation[3 * i + j] = static_cast<float>(pose.rotation.row[i][j] / unit);
        largest = std::max(largest, norm(pose.rotation.row[i]));
        translation[i] = static_cast<float>(shift[i]);
        finite = finite && std::isfinite(translation[i]) && std::isfinite(norm(pose.rotation.row[i]));
    }
    scale = static_cast<float>(largest / unit * (1 + 1e-5));
}

PointBatch::PointBatch(std::span<const Vec3f> points) noexcept : count(std::min(points.size(), k_size))
{
    const std::size_t filled = (count + Probe::k_cluster - 1) / Probe::k_cluster * Probe::k_cluster;
    for (std::size_t i = 0; i < filled; ++i) {
        const Vec3f& p = points[std::min(i, count - 1)];
        x[i] = p.x;
        y[i] = p.y;
        z[i] = p.z;
        point[i] = static_cast<std::uint32_t>(i);
        reached[i] = 0;
    }
}

ProbeJob::ProbeJob(const model::ModelView& m, PointBatch& batch, const QueryOptions& o, std::span<ProbeContact> contacts) noexcept
    : model(m),
      x(batch.x),
      y(batch.y),
      z(batch.z),
      point(batch.point),
      points(batch.count),
      reached(batch.reached),
      layer(chosen_layer(m, o)),
      layer3_gate(o.layer3_gate),
      first_only(false),
      out(contacts)
{
}

ProbeResult query_probe(const model::ModelView& model, const Probe& probe, const Pose& pose, const QueryOptions& options,
                        std::span<ProbeContact> contacts) noexcept
{
    const ProbeJob job(model, probe, pose, options, contacts);
    if (!job.finite) return {0, k_probe_not_finite, 0};
    // The locator knows nothing of a surface that has moved.
    const bool by_points = options.offset || options.margin > 0.f ||
                           !(job.layer == Layer::One ? model::has_locator(model) : is_located(model, job.layer));
    ProbeResult result =
        by_points ? run_probe_pointwise(job, options) : (job.layer == Layer::Exact ? run_probe_exact(job) : run_probe(job));
    if (lacks_exact(model, options)) result.status |= k_probe_no_exact;
    return result;
}

}  // namespace sqmap::query
