// Exact queries on a triangle mesh in double precision: the reference that maps are baked from and measured against.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace sqmap::mesh {

/// Closest point of a triangle mesh.
struct ClosestPoint {
    Vec3d point;
    std::uint32_t triangle = 0;
    double distance = std::numeric_limits<double>::infinity();
};

/// Bounding volume hierarchy over a mesh that must outlive it. Queries are const and thread-safe.
class Bvh {
public:
    /// Cost: n log n in the number of triangles.
    explicit Bvh(const Mesh& mesh);

    /// Closest point of the surface. Cost: O(log #triangles) as a rule.
    [[nodiscard]] ClosestPoint closest_point(Vec3d p, double within = std::numeric_limits<double>::infinity()) const;

    /// Winding number of a closed mesh about p, by signed ray crossings. A ray that passes within rounding of an edge
    /// is cast again in another direction, so the answer is exact for points off the surface.
    [[nodiscard]] int winding_number(Vec3d p) const;

    /// By how much the winding number grows from one point to another: the crossings between them. Nothing where the line between
    /// passes within rounding of an edge, or an end lies on the surface. Cost: as first_hit's, less where the points are near.
    [[nodiscard]] std::optional<int> winding_change(Vec3d from, Vec3d to) const;

    /// A crossing of a ray: at origin + t direction; sign +1 where it leaves through the triangle's front, -1 entering.
    struct Crossing {
        double t;
        int sign;
        std::uint32_t triangle;
    };
    /// All crossings with t > 0, nearest first. False where the ray passes within rounding of an edge.
    bool ray_crossings(Vec3d origin, Vec3d direction, std::vector<Crossing>& out) const;

    /// A ray: from origin + from direction to origin + to direction, mesh units.
    struct Ray {
        Vec3d origin, direction;
        double from = 0, to = std::numeric_limits<double>::infinity();
    };
    /// Meeting of a ray and a triangle: at origin + t direction, which is (1 - u - v) a + u b + v c of its corners.
    struct Hit {
        double t = 0, u = 0, v = 0;
        std::uint32_t triangle = 0;
        bool entering = false;  ///< it meets the triangle's front
    };
    /// The first triangle that a ray meets, the least one of several at the same t. A ray through an edge or a corner of a closed
    /// mesh meets a triangle there: nothing slips between two. Cost: O(log #triangles) as a rule.
    [[nodiscard]] std::optional<Hit> first_hit(const Ray& ray) const;
    /// True if the ray meets any triangle. Cost: less than first_hit.
    [[nodiscard]] bool meets_any(const Ray& ray) const;
    /// All triangles that it meets, nearest first: both of an edge. Cost: as above, times their number.
    void all_hits(const Ray& ray, std::vector<Hit>& out) const;

    /// Calls visit(triangle, closest_so_far_sq) -> double for every triangle whose box is nearer than the radius that
    /// visit returns; nearest boxes first.
    template <class Visit>
    void visit_nearest(Vec3d p, double radius_sq, Visit&& visit) const;

private:
    static constexpr int k_width = 4;
    static constexpr int k_stack = 64;  ///< three more entries a level, and four levels deep for each 256 triangles

    /// Four boxes side by side, so that one pass tests them all; those not in use are empty.
    struct Node {
        double lo[3][k_width], hi[3][k_width];
        std::uint32_t first[k_width];  ///< leaf: first entry of order_; inner: index of the child
        std::uint32_t count[k_width];  ///< triangles of a leaf, 0 for inner nodes
    };

    template <bool IsOrdered, class Meet>
    bool walk(const Ray& ray, Meet&& meet) const;
    template <class Add>
    bool cross_triangles(const Ray& ray, Add&& add) const;
    [[nodiscard]] std::optional<Hit> meet(const Ray& ray, std::uint32_t triangle) const;
    std::uint32_t build(std::uint32_t first, std::uint32_t last, const std::vector<Vec3d>& centroids);
    std::uint32_t halve(std::uint32_t first, std::uint32_t last, const std::vector<Vec3d>& centroids);

    const Mesh& mesh_;
    std::vector<Node> nodes_;
    std::vector<std::uint32_t> order_;
};

/// See the class.
template <class Visit>
void Bvh::visit_nearest(Vec3d p, double radius_sq, Visit&& visit) const
{
    struct Entry {
        double distance_sq;
        std::uint32_t first, count;
    };
    Entry stack[k_stack];
    int size = 0;
    stack[size++] = {0, 0, 0};
    while (size > 0) {
        const Entry at = stack[--size];
        if (!(at.distance_sq < radius_sq)) continue;
        if (at.count > 0) {
            for (std::uint32_t i = at.first; i < at.first + at.count; ++i) radius_sq = visit(order_[i], radius_sq);
            continue;
        }
        const Node& node = nodes_[at.first];
        double distance_sq[k_width] = {};
        for (int k = 0; k < 3; ++k) {
            const double v = p[k];
            for (int i = 0; i < k_width; ++i) {
                const double below = node.lo[k][i] - v, above = v - node.hi[k][i];
                const double outside = below > above ? below : above, gap = outside > 0 ? outside : 0;
                distance_sq[i] += gap * gap;
            }
        }
        // Farthest first onto the stack.
        const int bottom = size;
        for (int i = 0; i < k_width; ++i) {
            if (!(distance_sq[i] < radius_sq)) continue;
            int slot = size++;
            for (; slot > bottom && stack[slot - 1].distance_sq < distance_sq[i]; --slot) stack[slot] = stack[slot - 1];
            stack[slot] = {distance_sq[i], node.first[i], node.count[i]};
        }
    }
}

}  // namespace sqmap::mesh
