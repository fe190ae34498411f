// The solid a mesh bounds: where the winding number is positive, whatever overlaps or crosses.
#pragma once

#include "sqmap/mesh/bvh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// How a triangle lies to the solid's boundary.
enum class Boundary : std::uint8_t {
    Whole,   ///< all of it is boundary
    Buried,  ///< none of it: both sides are inside, or both outside
    Partly,  ///< another triangle cuts it: decided point by point
};

/// Exact inside, distance and ray crossings of the solid, in double. The mesh must outlive it.
class Solid {
public:
    /// crossed: #triangles, non-zero where another triangle cuts it (see find_self_intersections); empty for none.
    explicit Solid(const Mesh& mesh, std::span<const std::uint8_t> crossed = {});

    [[nodiscard]] bool inside(Vec3d p) const { return bvh_.winding_number(p) > 0; }
    /// Closest point of the solid's boundary; buried pieces do not count. within: how far it is at most, the closer the
    /// faster; where nothing is nearer, the distance is within.
    [[nodiscard]] ClosestPoint closest_boundary(Vec3d p, double within = std::numeric_limits<double>::infinity()) const;
    [[nodiscard]] const Bvh& bvh() const { return bvh_; }
    [[nodiscard]] const Mesh& mesh() const { return mesh_; }
    [[nodiscard]] std::span<const Boundary> boundary() const { return boundary_; }
    [[nodiscard]] bool self_intersecting() const { return self_intersecting_; }

private:
    bool is_boundary(Vec3d p, std::uint32_t triangle) const;

    const Mesh& mesh_;
    Bvh bvh_;
    std::vector<Boundary> boundary_;
    double step_ = 0;  ///< how far beside a surface its two sides are probed
    bool self_intersecting_ = false;
};

}  // namespace sqmap::mesh
