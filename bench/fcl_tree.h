// Meshes and poses as FCL has them.
#pragma once

#include "sqmap/math/pose.h"

#include <fcl/geometry/bvh/BVH_model.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::bench {

/// The tree of boxes over a mesh. Box: fcl::OBB<double>, say.
template <class Box>
std::shared_ptr<fcl::BVHModel<Box>> fcl_tree(std::span<const Vec3d> vertices,
                                             std::span<const std::array<std::uint32_t, 3>> triangles)
{
    auto tree = std::make_shared<fcl::BVHModel<Box>>();
    std::vector<fcl::Vector3d> points;
    for (const Vec3d& v : vertices) points.emplace_back(v.x, v.y, v.z);
    std::vector<fcl::Triangle> faces;
    for (const auto& t : triangles) faces.emplace_back(t[0], t[1], t[2]);
    tree->beginModel(static_cast<int>(faces.size()), static_cast<int>(points.size()));
    tree->addSubModel(points, faces);
    tree->endModel();
    return tree;
}

inline fcl::Transform3d fcl_transform(const Pose& pose)
{
    fcl::Transform3d t = fcl::Transform3d::Identity();
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) t.linear()(i, j) = pose.rotation.row[i][j];
        t.translation()[i] = pose.translation[i];
    }
    return t;
}

}  // namespace sqmap::bench
