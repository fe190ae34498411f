// A figure with the shape of a person: one smooth surface, which the bones of sim::capsule_human move.
// Pure functions: any number of threads.
#pragma once

#include "sim/walker.h"
#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/skin.h"

#include <vector>

namespace sqmap::app {

/// m: depth of the skin that is seen below the surface that cloth touches. Cloth is flat between its nodes, and this hides the
/// sagitta of a triangle of 24 mm on a limb of 24 mm radius.
constexpr double k_skin_below = 0.003;

/// Rest pose, world, m: y up, looking along +z, arms stretched along x, soles at y = 0.
struct Person {
    mesh::Mesh mesh;              ///< closed: what cloth touches
    std::vector<Vec3d> skin;      ///< #vertices of mesh: what is seen, k_skin_below under it
    mesh::Influences influences;  ///< of its vertices by the bones
    std::vector<sim::Bone> bones;
};

/// Capsules melt into one surface, which is polygonized; each vertex follows the bones near it.
/// height: m, of the standing figure; spacing: of the grid, m, for a figure of 1.75 m.
/// @throw std::invalid_argument for a height or a spacing that is not positive
[[nodiscard]] Person person(double height, double spacing);

}  // namespace sqmap::app
