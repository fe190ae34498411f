// A cloth's contacts with itself: near pairs, and pairs that would cross in a step.
#pragma once

#include "sqmap/math/vec.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::sim {

[[nodiscard]] inline btVector3 to_bullet(Vec3d v)
{
    return {static_cast<btScalar>(v.x), static_cast<btScalar>(v.y), static_cast<btScalar>(v.z)};
}

/// A node while its position is solved for.
struct Moving {
    Vec3f at;
    float inverse_mass;
};

/// Pairs of a node and a triangle, or of two edges, without a vertex in common. The step's beginning, when nothing went through,
/// decides on which side of each other they are: the contact's normal points between their nearest points then.
/// One thread at a time; begin, find and stop may allocate.
class SelfContacts {
public:
    using Triangle = std::array<std::uint32_t, 3>;

    /// same: vertices with equal numbers are sewn together. thickness: distance that is kept, m. @pre triangles outlives this
    SelfContacts(std::span<const Vec3d> start, std::span<const Triangle> triangles, double thickness);
    ~SelfContacts();

    /// Before the iterations: collects near pairs, each on its present side.
    void begin(std::span<const Vec3d> now);
    /// One of the iterations: keeps near pairs apart, with friction.
    void solve(std::span<const Vec3d> previous, std::span<Moving> moving, double friction) noexcept;
    /// Finds pairs that may touch on the path from previous to now; none if a position is not finite. same: vertices with equal
    /// numbers are sewn together.
    void find(std::span<const Vec3d> previous, std::span<const Moving> moving, std::span<const std::uint32_t> same);
    /// Puts back pairs that would cross on their paths; returns how many would.
    std::size_t push_apart(std::span<const Vec3d> previous, std::span<Moving> moving) noexcept;
    /// Pairs that would still cross take the mean path of their neighbours instead. Returns how many pairs still cross then.
    std::size_t stop(std::span<const Vec3d> previous, std::span<Vec3d> now, std::span<const Moving> mass);

private:
    struct Pair {
        std::array<std::uint32_t, 4> node;  ///< the node and the triangle's, or the ends of both edges
        bool edges;
    };
    struct Watched : Pair {
        Vec3f normal;  ///< from nearest points at the beginning
        float distance;
    };
    struct Near : Pair {
        std::array<float, 4> weight;  ///< of the nearest points' difference
        Vec3f normal;
        float offset, push;
        Vec3f grip;
    };
    struct Box {
        Vec3f low, high;
    };
    struct PairVisitor;
    using Tree = btDbvntNode;

    [[nodiscard]] static Box around(const Box& a, const Box& b) noexcept;
    /// number: count of the nodes before it, from the root down, first child first.
    void refit(Tree& node, std::size_t& number);
    std::vector<std::uint32_t> join(const Tree& node, std::span<const std::array<std::uint32_t, 3>> beside);
    void search(std::span<const Vec3d> previous);
    void consider(std::uint32_t a, std::uint32_t b);
    void watch(const Pair& pair);
    [[nodiscard]] std::uint32_t zone_of(std::uint32_t v) noexcept;
    std::size_t join_zones(std::span<const Vec3d> previous, std::span<const Vec3d> now) noexcept;
    void move_zones(std::span<const Vec3d> previous, std::span<Vec3d> now, std::span<const Moving> mass) noexcept;
    [[nodiscard]] bool share(std::span<const std::uint32_t> a, std::span<const std::uint32_t> b) const noexcept;

    std::span<const Triangle> triangles_;
    double thickness_;
    std::unique_ptr<Tree> root_;
    std::vector<std::uint8_t> joined_;  ///< 1 for each node of the tree whose triangles are one piece
    std::vector<std::uint8_t> owned_;   ///< of each triangle: the corners and the edges that it represents, three bits each
    std::span<const Vec3d> previous_;
    std::span<const std::uint32_t> same_;
    std::vector<Vec3d> now_;
    std::vector<Box> swept_;  ///< of nodes, widened by half the distance k_looks
    std::vector<Near> near_;
    std::vector<Watched> watched_;
    std::vector<std::uint32_t> zone_;
    std::vector<Vec3d> zone_path_;
    std::vector<double> zone_mass_;
};

}  // namespace sqmap::sim
