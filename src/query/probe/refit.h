// Spheres about clusters of moved points, for every instruction set: what a deforming probe pays each frame.
#pragma once

#include "sqmap/math/vec.h"

#include <cstddef>
#include <cstdint>

namespace sqmap::query {

/// A probe's points and its clusters' spheres, in columns.
struct ClusterColumns {
    float *x, *y, *z;                                ///< Probe::k_cluster a cluster
    float *centre_x, *centre_y, *centre_z, *radius;  ///< room for k_cluster more
    std::size_t clusters;
};

/// Places points[index[i]] - origin, in float, and spheres about each cluster's box. wanted: of points, those with 0 stand where
/// a wanted one of their cluster does, or at `far` with all of a cluster's; null for all. The same bits on every instruction set.
void fill_clusters(const Vec3d* points, const std::uint32_t* index, Vec3d origin, const std::uint8_t* wanted, float far,
                   const ClusterColumns& to) noexcept;

}  // namespace sqmap::query
