// Exact queries on a triangle mesh in double precision: the reference that maps are baked from and measured against.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace sqmap::mesh {

/// Closest point of a triangle mesh.
struct ClosestPoint {
    Vec3d point;
    std::uint32_t triangle = 0;
    double distance = std::numeric_limits<double>::infinity();
};

/// Closest point of one triangle to p (Ericson, Real-Time Collision Detection, 5.1.5).
[[nodiscard]] Vec3d closest_point_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c);

/// Bounding volume hierarchy over a mesh that must outlive it. Queries are const and thread-safe.
class Bvh {
public:
    explicit Bvh(const Mesh& mesh);

    /// Closest point of the surface. Cost: O(log #triangles) as a rule.
    [[nodiscard]] ClosestPoint closest_point(Vec3d p, double within = std::numeric_limits<double>::infinity()) const;

    /// Winding number of a closed mesh about p, by signed ray crossings. A ray that passes within rounding of an edge
    /// is cast again in another direction, so the answer is exact for points off the surface.
    [[nodiscard]] int winding_number(Vec3d p) const;

    /// A crossing of a ray: at origin + t direction; sign +1 where it leaves through the triangle's front, -1 entering.
    struct Crossing {
        double t;
        int sign;
        std::uint32_t triangle;
    };
    /// All crossings with t > 0, nearest first. False where the ray passes within rounding of an edge.
    bool ray_crossings(Vec3d origin, Vec3d direction, std::vector<Crossing>& out) const;

    /// Calls visit(triangle, closest_so_far_sq) -> double for every triangle whose box is nearer than the radius that
    /// visit returns; nearest boxes first.
    template <class Visit>
    void visit_nearest(Vec3d p, double radius_sq, Visit&& visit) const;

private:
    struct Node {
        Vec3d lo, hi;
        std::uint32_t first = 0;  ///< leaf: first entry of order_; inner: index of the right child (left is the next node)
        std::uint32_t count = 0;  ///< triangles of a leaf, 0 for inner nodes
    };

    static constexpr int k_max_depth = 40;  ///< halves of 2^32 triangles, and room

    std::uint32_t build(std::uint32_t first, std::uint32_t last, std::vector<Vec3d>& centroids);
    static double box_distance_sq(const Node& node, Vec3d p);

    const Mesh& mesh_;
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
};

template <class Visit>
void Bvh::visit_nearest(Vec3d p, double radius_sq, Visit&& visit) const
{
    struct Entry {
        double distance_sq;
        std::uint32_t node;
    };
    Entry stack[k_max_depth];
    int size = 0;
    stack[size++] = {box_distance_sq(nodes_[0], p), 0u};
    while (size > 0) {
        const auto [distance_sq, index] = stack[--size];
        if (distance_sq > radius_sq) continue;
        const Node& node = nodes_[index];
        if (node.count > 0) {
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) radius_sq = visit(order_[i], radius_sq);
            continue;
        }
        const double left = box_distance_sq(nodes_[index + 1], p), right = box_distance_sq(nodes_[node.first], p);
        const Entry l{left, index + 1}, r{right, node.first};
        stack[size++] = left < right ? r : l;
        stack[size++] = left < right ? l : r;
    }
}

}  // namespace sqmap::mesh
