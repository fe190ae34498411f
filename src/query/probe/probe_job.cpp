#include "probe_job.h"

#include "query/layer.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {

ProbeJob::ProbeJob(const Body& touched, const Body& collider, const QueryOptions& o, std::span<Contact> contacts) noexcept
    : model(*touched.model),
      x(collider.probe->x_.data()),
      y(collider.probe->y_.data()),
      z(collider.probe->z_.data()),
      point(collider.probe->point_.data()),
      centre_x(collider.probe->centre_x_.data()),
      centre_y(collider.probe->centre_y_.data()),
      centre_z(collider.probe->centre_z_.data()),
      radius(collider.probe->radius_.data()),
      group_x(collider.probe->group_x_.data()),
      group_y(collider.probe->group_y_.data()),
      group_z(collider.probe->group_z_.data()),
      group_radius(collider.probe->group_radius_.data()),
      clusters(collider.probe->clusters()),
      groups(collider.probe->group_radius_.size()),
      points(collider.probe->size_),
      layer(chosen_layer(model, o)),
      gate(o.gate),
      first_only(o.first_only),
      caller(model.header, touched.pose),
      out(contacts)
{
    const Probe& p = *collider.probe;
    const Pose pose = compose(inverse(touched.pose), collider.pose);
    for (int k = 0; k < 4; ++k) sphere[k] = p.sphere_[k];
    // In double up to here: a mesh may lie far from its origin.
    const double unit = model.header.unit;
    const Vec3d origin{model.header.origin[0], model.header.origin[1], model.header.origin[2]};
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
        unproven[i] = 0;
    }
}

ProbeJob::ProbeJob(const model::ModelView& m, PointBatch& batch, const QueryOptions& o, std::span<Contact> contacts) noexcept
    : model(m),
      x(batch.x),
      y(batch.y),
      z(batch.z),
      point(batch.point),
      points(batch.count),
      unproven(batch.unproven),
      layer(chosen_layer(m, o)),
      gate(o.gate),
      first_only(false),
      out(contacts)
{
}

}  // namespace sqmap::query
