// Contacts of cloth with colliders: what sqmap answers, as half-spaces that the threads' solver respects.
#pragma once

#include "sqmap/query/pair.h"
#include "sqmap/query/skin.h"
#include "sqmap/query/swept.h"
#include "sqmap/sim/cloth.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::sim {

/// A node has to stay where dot(normal, x) >= offset. World, m.
struct HalfSpace {
    Vec3f normal{};
    float offset = 0;
    Vec3f motion{};   ///< of the surface in this step
    float push = 0;   ///< sum of what it moved the node, >= 0
    Vec3f grip{};     ///< sum of what friction moved it
    float depth = 0;  ///< below the collider's surface, of the asked place
    std::uint32_t node = 0;
    std::uint32_t next = 0;  ///< of the same node
    std::uint32_t collider = 0;
    Vec3f at{};                  ///< surface point, world
    float give = 0;              ///< how far it gives way to one that faces it
    std::uint8_t kept = 0;       ///< for so many steps without having been found again
    Vec3f place{}, direction{};  ///< surface point and normal in the collider's frame, the bound one of a skin
};

/// Whether a collider does not move in the step.
[[nodiscard]] inline bool stands(const Collider& s) noexcept
{
    return s.skin != nullptr ? !(s.skin->motion() > 0)
                             : s.pose.translation == s.previous.translation && s.pose.rotation == s.previous.rotation;
}

class Contacts {
public:
    Contacts(std::span<const Vec3d> points, double thickness, double sweep_step, query::Layer layer);

    /// Nodes went from previous to now; finds the half-spaces. Bits of ClothStatus. No allocation.
    std::uint32_t find(std::span<const Vec3d> previous, std::span<const Vec3d> now, std::span<const Collider> colliders,
                       StepReport& report) noexcept;

    /// Room for skinned colliders.
    void expect(const query::SkinLattice& lattice, std::span<const Vec3d> points);
    [[nodiscard]] bool expects_skins() const noexcept { return skin_workspace_ != nullptr; }

    /// Moves the half-spaces of the last step with their colliders.
    void ride(std::span<const Collider> colliders) noexcept;

    [[nodiscard]] std::span<const Vec3d> query_points() const noexcept { return asked_; }
    /// The normal that each node felt last; zero where it is free.
    [[nodiscard]] std::span<const Vec3f> touched() const noexcept { return touched_; }
    /// Most nodes kept their answers in the last step.
    [[nodiscard]] bool rests() const noexcept { return 2 * stale_count_ < stale_.size(); }
    [[nodiscard]] std::span<HalfSpace> all() noexcept { return std::span(spaces_).first(count_); }

private:
    /// Marks the nodes that have to be asked again; false: every node has. still: no collider moves.
    bool mark_stale(std::span<const Vec3d> now, bool still) noexcept;
    /// Where the nodes, or the stale ones alone, are asked about. stand: no collider moves. Returns the longest way of one.
    double place_asked(std::span<const Vec3d> previous, std::span<const Vec3d> now, bool some, bool stand) noexcept;
    /// Sets aside what held the nodes; keeps it for those that are not stale.
    void turn_over(bool some) noexcept;
    void drop_void() noexcept;
    /// Half-spaces that a node is pressed against beside an edge, where nothing is found below it any more.
    void keep_pressed(std::uint32_t node, Vec3d now) noexcept;
    /// Whether a node is asked about the other side of the cloth in this step.
    [[nodiscard]] bool turned(std::size_t node) const noexcept;
    /// What held a node before and was not looked for in this step.
    void keep_unasked(std::uint32_t node, Vec3d now) noexcept;
    /// Between two surfaces that face each other.
    void squeeze(std::uint32_t node, Vec3d now) noexcept;
    std::uint32_t ask(std::uint32_t number, const Collider& collider, std::span<const Vec3d> previous, std::span<const Vec3d> now,
                      double longest, StepReport& report) noexcept;
    std::uint32_t ask_skin(std::uint32_t number, const Collider& collider, std::span<const Vec3d> previous,
                           std::span<const Vec3d> now, StepReport& report) noexcept;
    /// A surface that a node is behind: world, and in the collider's frame.
    struct Touched {
        std::uint32_t node, collider;
        Vec3d at, normal, motion;
        double depth;  ///< m, of the asked place
        Vec3d place, direction;
    };
    void add(const Touched& touched, Vec3d previous, Vec3d now, std::uint32_t& status) noexcept;
    /// How far the surface may be moved along the normal so that it does not jump under a node that hardly moves.
    double steadied(const HalfSpace& space, Vec3d previous, Vec3d now) const noexcept;

    query::Probe probe_;
    query::SweptWorkspace workspace_;
    std::vector<query::ProbeContact> found_;
    std::unique_ptr<query::SkinWorkspace> skin_workspace_;
    std::vector<query::SkinContact> skin_found_;
    std::vector<HalfSpace> spaces_;
    std::vector<std::uint32_t> head_;     ///< of each node
    std::vector<Vec3d> asked_;            ///< the nodes, each a little more than thickness deeper along its last normal
    std::vector<Vec3f> touched_;          ///< that normal; zero where the node is free
    std::vector<std::uint8_t> free_for_;  ///< steps since it was felt
    std::vector<Vec3d> asked_from_;       ///< where the node was when it was asked; kept while no collider moves
    std::vector<HalfSpace> last_;         ///< what held nodes before they were asked again
    std::vector<std::uint32_t> last_head_;
    std::vector<std::uint8_t> stale_;
    enum class Kept { Nothing, Samples, All } kept_ = Kept::Nothing;  ///< of asked_from_
    bool voided_ = false;                                             ///< half-spaces that another one made void
    std::size_t stale_count_ = 0, colliders_ = 0, step_ = 0;
    std::size_t count_ = 0, held_ = 0;  ///< half-spaces; nodes with one
    double thickness_, sweep_step_;
    query::QueryOptions options_;
};

}  // namespace sqmap::sim
