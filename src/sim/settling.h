// The last corrections before cloth is shown: edges of closed seams are brought together, and points that are inside skinned
// colliders are moved out, by the exact layer.
#pragma once

#include "interiors.h"
#include "self_contacts.h"
#include "sqmap/query/skin.h"
#include "sqmap/sim/cloth.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::sim {

/// The nodes of a cloth at the end of a step.
struct SettlingNodes {
    std::span<Vec3d> at;             ///< world, m; moved
    std::span<const Moving> mass;    ///< pinned ones stay
    std::span<const Vec3f> normals;  ///< of each node's contacts; zero where it is free
    std::span<const InteriorSpace> held;
};

/// One thread at a time.
class Settling {
public:
    Settling(std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t nodes, double thickness);

    /// Allocates for skinned colliders.
    void expect(const query::SkinLattice& lattice);

    /// Forgets what was joined.
    void begin_seams() noexcept;
    /// The next run leaves both nodes, and all that were joined to either, at one position.
    void join(std::uint32_t a, std::uint32_t b) noexcept;

    /// Brings joined nodes together, then returns how many points were moved out of the colliders. No allocation.
    std::size_t run(const SettlingNodes& nodes, std::span<const Collider> colliders) noexcept;

private:
    /// A point of a triangle or of an edge, or a node.
    struct Sample {
        std::array<std::uint32_t, 3> node;
        std::array<float, 3> weight;
    };

    /// Brings joined nodes to their middle, or to where one of them is pinned; the others are pinned then as well.
    void close_seams(const SettlingNodes& nodes) noexcept;
    /// Adds the middle of a triangle and two points of each edge that it owns.
    void add_triangle(std::size_t triangle) noexcept;
    /// Queries all samples, moves those that are inside out and keeps them alone. Returns how many they are.
    std::size_t pass(const SettlingNodes& nodes, const Collider& collider) noexcept;

    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::vector<std::uint8_t> owned_;  ///< of each triangle: bit k where the edge from its corner k is counted with it
    std::vector<Sample> samples_;
    std::size_t count_ = 0;
    std::vector<std::uint8_t> moved_;    ///< of each node: whether this run has moved it
    std::vector<std::uint32_t> next_;    ///< of each node: the next one of a ring of joined ones, itself where it is alone
    std::vector<std::uint8_t> pinned_;   ///< of each node: it stays, or one that is joined to it
    std::vector<std::uint8_t> touches_;  ///< of each node, as the run begins
    std::unique_ptr<query::SkinWorkspace> workspace_;
    std::vector<Vec3d> points_;  ///< of the workspace
    std::vector<std::uint8_t> active_;
    std::vector<query::SkinContact> found_;
    double thickness_;
};

}  // namespace sqmap::sim
