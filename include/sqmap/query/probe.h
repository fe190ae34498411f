// A whole probe against a model: which of its points are in contact, penetration depth, direction out.
#pragma once

#include "sqmap/query/body.h"
#include "sqmap/query/contact.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace sqmap::query {

struct ProbeJob;
class TriangleTree;

/// Three points of a triangle by their numbers, counter-clockwise seen from outside.
using ProbeTriangle = std::array<std::uint32_t, 3>;

/// The first thing that forbids triangles to bound a solid.
struct TriangleFault {
    /// The kinds of faults.
    enum class Kind : std::uint8_t {
        None,
        OutOfRange,   ///< a corner is no point of the probe
        NotFinite,    ///< a point is NaN or infinite
        Open,         ///< nothing is on the other side of one of its sides
        TurnedRound,  ///< a neighbour runs along their common side in the same direction: one of both is inverted
        Inverted,     ///< a shell is inside out, clockwise seen from outside, and bounds no cavity of others: its first triangle
        TooMany,      ///< more than 2^28 triangles
        OutOfScale,   ///< the diagonal of their box is below k_least_size or above k_largest_size
    };
    Kind kind = Kind::None;
    std::uint32_t triangle = 0;  ///< which of them; 0 where it is about all
    std::uint32_t side = 0;      ///< of Open and TurnedRound: from this corner of the triangle to the next one
};

/// Sizes of solids, the diagonals of their boxes, whose triangles are told apart in float, whatever the unit.
inline constexpr double k_least_size = 1e-9, k_largest_size = 1e12;

/// Nothing where the triangles close solids that are not inside out; points at the same position count as one. Allocates; cost
/// n log n, and n for each cavity.
[[nodiscard]] TriangleFault find_fault(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles);

/// Points prepared once, queried every tick: rigid, or moved as they deform. Near points make a cluster of 16, near clusters
/// a group of 16, each with a sphere, so that what is far costs nothing.
/// Thread safety: any number of threads may query one probe; move() needs it alone.
class Probe {
public:
    /// Points of a cluster, which are culled together.
    static constexpr std::size_t k_cluster = 16;
    static constexpr float k_far = 1e12f;  ///< where clusters stand that are not active; the probe's own units

    /// points: finite, any order. Allocates; cost n log n.
    explicit Probe(std::span<const Vec3d> points);
    /// The same with the triangles between the points, which complete contacts need (sqmap/query/contacts.h).
    /// @pre find_fault(points, triangles) finds nothing
    Probe(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles);

    /// New positions of the same points in the same order: spheres are refitted, nothing is allocated. Clusters were chosen for
    /// the first positions, so a probe that is turned inside out is slower, never wrong.
    /// @pre points.size() == size()
    void move(std::span<const Vec3d> points) noexcept;
    /// Bytes that the probe keeps in memory.
    [[nodiscard]] std::size_t bytes() const noexcept;
    /// The same, but only points with active[i] != 0 are there: the rest costs next to nothing. Answers about the rest are void:
    /// where they share a cluster with active points they repeat one of those.
    /// @pre active.size() == size()
    void move(std::span<const Vec3d> points, std::span<const std::uint8_t> active) noexcept;

    /// Another number after each move, and for each probe that was made from points: copies share it. Below 2^63.
    [[nodiscard]] std::uint64_t stamp() const noexcept { return stamp_; }
    /// Number of points.
    [[nodiscard]] std::size_t size() const noexcept { return size_; }
    /// Number of clusters; the last one may be filled up.
    [[nodiscard]] std::size_t clusters() const noexcept { return point_.size() / k_cluster; }
    /// Holds every point; the points' own frame.
    [[nodiscard]] Sphere sphere() const noexcept;
    /// False where no point is in the sphere (the points' own frame), by the clusters' spheres; true where one may be.
    [[nodiscard]] bool reaches(const Sphere& sphere) const noexcept;
    /// How far neighbouring points are apart, as though every cluster were spread evenly over a disc.
    [[nodiscard]] double spacing() const noexcept { return static_cast<double>(spacing_); }
    /// Number of its triangles; 0 where it was made without any.
    [[nodiscard]] std::size_t triangle_count() const noexcept;
    /// Its triangles, for the library.
    [[nodiscard]] const TriangleTree& triangles() const noexcept { return triangles_.get(); }

private:
    friend struct ProbeJob;
    friend struct SkinQuery;
    /// A tree that is copied with its probe; whoever uses probes need not know what it is made of.
    class OwnTree {
    public:
        OwnTree();
        OwnTree(const OwnTree& other);
        OwnTree& operator=(const OwnTree& other);
        OwnTree(OwnTree&& other) noexcept;
        OwnTree& operator=(OwnTree&& other) noexcept;
        ~OwnTree();
        [[nodiscard]] TriangleTree& get() noexcept { return *tree_; }
        [[nodiscard]] const TriangleTree& get() const noexcept { return *tree_; }

    private:
        std::unique_ptr<TriangleTree> tree_;
    };
    void refit() noexcept;         ///< tight spheres
    void refit_groups() noexcept;  ///< spheres about those of clusters

    std::size_t size_ = 0;
    std::uint64_t stamp_ = 0;
    Vec3d origin_{};                            ///< stored positions are relative to it, so that float suffices
    std::vector<std::uint32_t> slot_of_point_;  ///< point -> its slot below
    std::vector<float> x_, y_, z_;              ///< k_cluster a cluster; the last cluster repeats its last point
    std::vector<std::uint32_t> point_;          ///< whose position it is
    std::vector<float> centre_x_, centre_y_, centre_z_, radius_;  ///< of clusters
    std::vector<float> group_x_, group_y_, group_z_, group_radius_;
    float sphere_[4] = {};
    float spacing_ = 0;
    OwnTree triangles_;
};

/// Contacts of a probe.
struct ProbeResult {
    std::size_t contacts = 0;    ///< found; at most the span's size are written
    std::uint8_t status = k_ok;  ///< bits of Status
    std::uint32_t unseen = 0;    ///< contacts whose surface no chart shows: depth and normal are those of the locator's plane
    /// Witness points are relative to the anchor. It is zero, unless the touched mesh lies so far from its frame's origin that
    /// float would round by more than 1e-6 of R_max.
    Vec3d anchor{};

    /// The contacts that were written to the query's span.
    [[nodiscard]] std::span<const Contact> written(std::span<const Contact> queried_with) const noexcept
    {
        return queried_with.first(std::min(contacts, queried_with.size()));
    }
    /// Witness point of a contact of this result.
    [[nodiscard]] Vec3d position(const Contact& contact) const noexcept { return anchor + cast<double>(contact.witness); }
};

/// The points of the collider's probe that are inside the touched body's model, in an order that depends on nothing else; in
/// the frame in which the poses are given (see Body). Where either is missing, none. A model without a locator (a surface)
/// is queried point by point. Total, noexcept, no allocation, the same bits on every instruction set;
/// thread-safe.
/// @pre the model came from model::parse, so that its arrays lie in one blob (not checked)
[[nodiscard]] ProbeResult query_probe(const Body& touched, const Body& collider, const QueryOptions& options,
                                      std::span<Contact> contacts) noexcept;

}  // namespace sqmap::query
