// The look-up kernel of dense_simd.cpp: one source, compiled for several instruction sets by dense_simd_*.cpp.
#pragma once

#include <cstdint>

namespace sqmap::bench {

inline constexpr std::uint32_t k_lanes = 16;  ///< vertices of a cluster, clusters of a group

/// The field in 16 bits.
struct FieldView {
    const std::int16_t* values;  ///< samples^3, x fastest
    std::int32_t samples;
    float step;        ///< distance of one unit of a value
    float spacing[3];  ///< of the grid, to measure how far outside it a centre lies
    float slope;       ///< no two points of the box differ in distance by more than slope times their distance
};

/// Sixteen spheres in structure of arrays.
struct alignas(64) SphereBlock {
    float x[k_lanes], y[k_lanes], z[k_lanes], radius[k_lanes];
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
};

/// From the probe's frame to cells of the grid: m times (x, y, z, 1).
struct CellPose {
    float m[3][4];
};

/// Where answers go: room for a block more than all vertices.
struct ContactRoom {
    std::uint32_t* vertex;
    float* depth;
};

/// Number of contacts written.
using DenseKernel = std::uint32_t (*)(const FieldView&, const ProbeView&, const CellPose&, const ContactRoom&);

std::uint32_t dense_kernel_avx512(const FieldView&, const ProbeView&, const CellPose&, const ContactRoom&);
std::uint32_t dense_kernel_avx2(const FieldView&, const ProbeView&, const CellPose&, const ContactRoom&);
std::uint32_t dense_kernel_plain(const FieldView&, const ProbeView&, const CellPose&, const ContactRoom&);

}  // namespace sqmap::bench
