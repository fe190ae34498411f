// Interiors of triangles: where a collider's sharp place pokes through cloth between the nodes, which feel nothing of it.
#pragma once

#include "sqmap/sim/cloth.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::sim {

/// A place of a triangle has to stay where dot(normal, x) >= offset. World, m.
struct InteriorSpace {
    std::array<std::uint32_t, 3> nodes{};
    Vec3f weights{};  ///< of the nodes: the place's barycentric coordinates
    Vec3f normal{};
    float offset = 0;
    Vec3f motion{};  ///< of the surface in this step
    float push = 0;  ///< sum of what it moved the place, >= 0
    std::uint32_t number = 0, collider = 0;
    bool settled = true;         ///< it is where it is to be
    Vec3d asked_from{};          ///< the place when it was asked
    Vec3f place{}, direction{};  ///< in the collider's frame
};

/// Asks a share of the places within triangles whose nodes feel normals that part, a share in each step, and again and again
/// those that were found in a collider. Colliders with a skin are not asked.
class Interiors {
public:
    Interiors(std::span<const std::array<std::uint32_t, 3>> triangles, double thickness, query::Layer layer);

    /// After the nodes' contacts are known. touched: the normal that each node feels, zero where none. rests: the cloth hardly
    /// moves. No allocation.
    void find(std::span<const Vec3d> now, std::span<const Vec3f> touched, std::span<const Collider> colliders,
              bool rests) noexcept;

    /// Moves what the last step found with its colliders.
    void ride(std::span<const Collider> colliders) noexcept;

    [[nodiscard]] std::span<InteriorSpace> all() noexcept { return std::span(spaces_).first(count_); }

private:
    /// Fills where and how the place is to be held, unless no collider is below it.
    bool ask(InteriorSpace& space, std::span<const Vec3d> now, std::span<const Vec3f> touched,
             std::span<const Collider> colliders, bool rests) const noexcept;

    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::vector<InteriorSpace> spaces_;
    std::vector<std::uint8_t> held_;     ///< of each triangle's places: whether a space holds it
    std::size_t count_ = 0, first_ = 0;  ///< spaces; which is asked first
    std::size_t next_ = 0, visit_ = 0;   ///< the triangle that is looked at next, and the first of its places
    double thickness_;
    query::Layer layer_;
};

}  // namespace sqmap::sim
