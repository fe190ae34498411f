// A partition of a mesh by position, for tests.
#pragma once

#include "sqmap/decompose/decompose.h"
#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <functional>

namespace sqmap::test {

/// Parts by where the triangles' centroids are.
inline decompose::Partition parts_by(const mesh::Mesh& mesh, std::uint32_t count,
                                     const std::function<std::uint32_t(Vec3d)>& part_at)
{
    decompose::Partition partition;
    partition.part_count = count;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        partition.part_of_triangle.push_back(part_at(mesh::triangle_centroid(mesh, t)));
    return partition;
}

}  // namespace sqmap::test
