// Interiors of triangles: something sharp may poke through cloth between nodes that have no contact with it.
#pragma once

#include "sqmap/query/skin.h"
#include "sqmap/sim/cloth.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::sim {

/// A point of a triangle has to stay where dot(normal, x) >= offset. World, m.
struct InteriorSpace {
    std::array<std::uint32_t, 3> nodes{};
    Vec3f weights{};  ///< of the nodes: the point's barycentric coordinates
    Vec3f normal{};
    float offset = 0;
    Vec3f motion{};  ///< of the surface in this step
    float push = 0;  ///< by how much it has moved the point in this step, >= 0
    std::uint32_t number = 0, collider = 0;
    bool settled = true;               ///< the point has reached its offset
    Vec3d queried_from{};              ///< the point at its last query
    Vec3f local_at{}, local_normal{};  ///< in the collider's frame
};

/// The nodes of a cloth after their contacts are known.
struct TouchingNodes {
    std::span<const Vec3d> now;      ///< world, m
    std::span<const Vec3f> normals;  ///< of each node's contacts; zero where it is free
    bool rests = false;              ///< the cloth hardly moves
};

/// Queries points within triangles whose nodes' normals part: in each step a share of them, and again and again the points that
/// were found in a collider. Of a collider with a skin, the middles of all triangles every few steps. One thread at a time.
class Interiors {
public:
    Interiors(std::span<const std::array<std::uint32_t, 3>> triangles, double thickness, query::Layer layer);

    /// Allocates for skinned colliders. points: of the cloth's nodes.
    void expect(const query::SkinLattice& lattice, std::span<const Vec3d> points);

    /// No allocation.
    void find(const TouchingNodes& nodes, std::span<const Collider> colliders) noexcept;

    /// Moves the spaces of the last step with their colliders.
    void ride(std::span<const Collider> colliders) noexcept;

    [[nodiscard]] std::span<InteriorSpace> all() noexcept { return std::span(spaces_).first(count_); }

private:
    /// Sets the plane that holds the point; false if no collider is below it.
    bool hold(InteriorSpace& space, const TouchingNodes& nodes, std::span<const Collider> colliders) const noexcept;

    /// Holds the middles of triangles that are in a skinned collider, in place of those that were held before.
    void find_skinned(const TouchingNodes& nodes, std::span<const Collider> colliders, std::size_t number) noexcept;

    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::unique_ptr<query::SkinWorkspace> skin_workspace_;
    std::vector<Vec3d> middles_, outward_;  ///< of each triangle: the point that is queried; the cloth's outer side, or zero
    std::vector<query::SkinContact> skin_found_;
    std::size_t step_ = 0;
    std::vector<InteriorSpace> spaces_;
    std::vector<std::uint8_t> held_;     ///< 1 for each point of a triangle that a space holds
    std::size_t count_ = 0, first_ = 0;  ///< spaces; the first to be queried
    std::size_t next_ = 0, visit_ = 0;   ///< the next triangle, and the first of its points
    double thickness_;
    query::Layer layer_;
};

}  // namespace sqmap::sim
