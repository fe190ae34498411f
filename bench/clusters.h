// A probe cut into clusters of 16 nearby vertices and groups of 16 clusters, each with a bounding sphere.
#pragma once

#include "dense_simd_kernel.h"
#include "sqmap/math/vec.h"

#include <cstddef>
#include <span>
#include <vector>

namespace sqmap::bench {

struct ClusteredProbe {
    std::vector<SphereBlock> groups, clusters;
    std::vector<VertexBlock> vertices;
    std::uint32_t last_lanes = 0, last_block = 0;

    std::vector<std::uint32_t> group_list, cluster_list;  ///< scratch, see ProbeView

    [[nodiscard]] ProbeView view()
    {
        return {groups.data(), clusters.data(), vertices.data(),   static_cast<std::uint32_t>(groups.size()),
                last_lanes,    last_block,      group_list.data(), cluster_list.data()};
    }
    [[nodiscard]] std::size_t bytes() const
    {
        return (groups.size() + clusters.size()) * sizeof(SphereBlock) + vertices.size() * sizeof(VertexBlock);
    }
};

/// @pre vertices is not empty.
[[nodiscard]] ClusteredProbe cluster(std::span<const Vec3d> vertices);

}  // namespace sqmap::bench
