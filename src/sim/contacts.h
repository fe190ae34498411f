// Contacts of cloth with colliders: the answers of sqmap's queries, as half-spaces for the threads' solver.
#pragma once

#include "sqmap/query/pair.h"
#include "sqmap/query/skin.h"
#include "sqmap/query/swept.h"
#include "sqmap/sim/cloth.h"

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::sim {

/// A node has to stay where dot(normal, x) >= offset. World, m.
struct HalfSpace {
    Vec3f normal{};
    float offset = 0;
    Vec3f motion{};   ///< of the surface in this step
    float push = 0;   ///< by how much it has moved the node in this step, >= 0
    Vec3f grip{};     ///< by how much friction has moved it
    float depth = 0;  ///< below the collider's surface, of the query point
    std::uint32_t node = 0;
    std::uint32_t next = 0;  ///< of the same node
    std::uint32_t collider = 0;
    Vec3f at{};                        ///< surface point, world
    float give = 0;                    ///< how far it yields to a half-space that faces it
    std::uint8_t kept = 0;             ///< number of steps that it was kept without being found again
    Vec3f local_at{}, local_normal{};  ///< surface point and normal in the collider's frame, the bound one of a skin
};

/// True if a collider does not move in the step.
[[nodiscard]] inline bool stands(const Collider& s) noexcept
{
    return s.skin != nullptr ? !(s.skin->motion() > 0)
                             : s.pose.translation == s.previous.translation && s.pose.rotation == s.previous.rotation;
}

[[nodiscard]] inline bool all_stand(std::span<const Collider> colliders) noexcept
{
    return std::all_of(colliders.begin(), colliders.end(), stands);
}

/// The nodes of a cloth in a step. World, m.
struct Nodes {
    std::span<const Vec3d> previous, now;
};

/// Made and sized outside the loop. One thread at a time.
class Contacts {
public:
    Contacts(std::span<const Vec3d> points, double thickness, double sweep_step, query::Layer layer);

    /// Nodes went from previous to now; finds the half-spaces. Bits of ClothStatus. No allocation.
    std::uint32_t find(const Nodes& nodes, std::span<const Collider> colliders, StepReport& report) noexcept;

    /// Allocates for skinned colliders.
    void expect(const query::SkinLattice& lattice, std::span<const Vec3d> points);
    [[nodiscard]] bool expects_skins() const noexcept { return skin_workspace_ != nullptr; }

    /// Moves the half-spaces of the last step with their colliders.
    void ride(std::span<const Collider> colliders) noexcept;

    [[nodiscard]] std::span<const Vec3d> query_points() const noexcept { return query_points_; }
    /// The last normal of each node's contacts; zero where it is free.
    [[nodiscard]] std::span<const Vec3f> normals() const noexcept { return normals_; }
    /// True if most nodes kept their answers in the last step.
    [[nodiscard]] bool rests() const noexcept { return 2 * stale_count_ < stale_.size(); }
    [[nodiscard]] std::span<HalfSpace> all() noexcept { return std::span(spaces_).first(count_); }

private:
    /// Marks the nodes that need a query; false if every node does. still: no collider moves.
    bool mark_stale(std::span<const Vec3d> now, bool still) noexcept;
    /// Sets the query points of all nodes, or of the stale ones alone. stand: no collider moves. Returns the longest path of a
    /// node, m.
    double set_query_points(const Nodes& nodes, bool some, bool stand) noexcept;
    /// Sets aside the half-spaces of the last step; keeps those of nodes that are not stale.
    void turn_over(bool some) noexcept;
    /// Adds a half-space to those of its node. @pre count_ < spaces_.size()
    void append(const HalfSpace& space) noexcept;
    /// Removes half-spaces that another one made void.
    void drop_void() noexcept;
    /// Keeps half-spaces that press a node beside an edge although a query finds nothing below it any more.
    void keep_pressed(std::uint32_t node, Vec3d now) noexcept;
    /// True if a node's query looks on the other side of the cloth in this step.
    [[nodiscard]] bool turned(std::size_t node) const noexcept;
    /// Keeps half-spaces that held a node before and that the query of this step could not find.
    void keep_unseen(std::uint32_t node, Vec3d now) noexcept;
    /// Shares the thickness out between two surfaces that face each other.
    void squeeze(std::uint32_t node, Vec3d now) noexcept;
    /// The nodes, the longest path of one, m, and the colliders.
    struct Search {
        Nodes nodes;
        std::span<const Collider> colliders;
        double longest = 0;
    };
    /// Add the half-spaces of one collider; return bits of ClothStatus.
    std::uint32_t query_rigid(std::uint32_t number, const Search& search, StepReport& report) noexcept;
    std::uint32_t query_skinned(std::uint32_t number, const Search& search, StepReport& report) noexcept;
    /// A surface that a node is behind: world, and in the collider's frame.
    struct Surface {
        std::uint32_t node, collider;
        Vec3d at, normal, motion;
        double depth;  ///< m, of the query point
        Vec3d local_at, local_normal;
    };
    /// Adds a half-space; false if there is no space for it.
    bool add(const Surface& surface, const Nodes& nodes) noexcept;
    /// How far the surface may be moved along the normal so that it does not jump under a node that hardly moves.
    double steadied(const HalfSpace& space, Vec3d previous, Vec3d now) const noexcept;

    query::Probe probe_;
    query::SweptWorkspace workspace_;
    std::vector<query::Contact> found_;
    std::unique_ptr<query::SkinWorkspace> skin_workspace_;
    std::vector<query::SkinContact> skin_found_;
    std::vector<HalfSpace> spaces_;
    std::vector<std::uint32_t> head_;     ///< of each node
    std::vector<Vec3d> query_points_;     ///< the nodes, each a little more than thickness deeper along its last normal
    std::vector<Vec3f> normals_;          ///< that normal; zero where the node is free
    std::vector<std::uint8_t> free_for_;  ///< steps since its last contact
    std::vector<Vec3d> queried_from_;     ///< position of the node at its last query; kept while no collider moves
    std::vector<HalfSpace> last_;         ///< half-spaces of the last step
    std::vector<std::uint32_t> last_head_;
    std::vector<std::uint8_t> stale_;
    enum class Kept { Nothing, Samples, All } kept_ = Kept::Nothing;  ///< of queried_from_
    bool voided_ = false;                                             ///< some half-spaces are void: another one hides them
    std::size_t stale_count_ = 0, colliders_ = 0, step_ = 0;
    std::size_t count_ = 0, held_ = 0;  ///< half-spaces; nodes with one
    double thickness_, sweep_step_;
    query::QueryOptions options_;
};

inline double cpu_seconds() noexcept
{
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace sqmap::sim
