// The look-up kernel of dense_simd.cpp: one source, compiled for several instruction sets by dense_simd_*.cpp.
#pragma once

#include <cstdint>

namespace sqmap::bench {

inline constexpr std::uint32_t k_lanes = 16;  ///< vertices of a cluster, clusters of a group

/// Distances in 16 bits at the points of a grid.
struct Samples {
    const std::int16_t* values;  ///< count^3, x fastest
    std::int32_t count;
};

struct FieldView {
    Samples fine;
    Samples coarse;    ///< every stride-th point of the fine grid, lowered until it is nowhere above the fine field
    float per_stride;  ///< 1 / stride
    float step;        ///< distance of one unit of a value
    float spacing[3];  ///< of the fine grid, to measure how far outside it a centre lies
};

/// Sixteen spheres in structure of arrays.
struct alignas(64) SphereBlock {
    float x[k_lanes], y[k_lanes], z[k_lanes], radius[k_lanes];
    float reach[k_lanes];  ///< no value within the sphere is below zero where that at its centre is above this
};
/// Sixteen vertices.
struct alignas(64) VertexBlock {
    float x[k_lanes], y[k_lanes], z[k_lanes];
    std::uint32_t vertex[k_lanes];
};

/// The probe: groups of 16 clusters of 16 vertices. Missing lanes repeat the last; a radius below zero marks them.
struct ProbeView {
    const SphereBlock* groups;    ///< spheres of 16 groups each
    const SphereBlock* clusters;  ///< spheres of the clusters of one group each
    const VertexBlock* vertices;  ///< 16 blocks a group
    std::uint32_t group_blocks;
    std::uint32_t last_lanes;  ///< vertices in the last block of all that is in use
    std::uint32_t last_block;  ///< its number
    // Scratch of the kernel: workspace for a block more than all groups, and than all clusters.
    std::uint32_t *group_list, *cluster_list;
};

/// From the probe's frame to cells of the grid: m times (x, y, z, 1).
struct CellPose {
    float m[3][4];
};

/// Output of a kernel: workspace for a block more than all vertices.
struct ContactWorkspace {
    std::uint32_t* vertex;
    float* depth;
    float* normal[3];  ///< null where nobody asks for normals
};

/// Number of contacts written.
using DenseKernel = std::uint32_t (*)(const FieldView&, const ProbeView&, const CellPose&, const ContactWorkspace&);

std::uint32_t dense_kernel_avx512(const FieldView&, const ProbeView&, const CellPose&, const ContactWorkspace&);
std::uint32_t dense_kernel_avx2(const FieldView&, const ProbeView&, const CellPose&, const ContactWorkspace&);
std::uint32_t dense_kernel_plain(const FieldView&, const ProbeView&, const CellPose&, const ContactWorkspace&);

}  // namespace sqmap::bench
