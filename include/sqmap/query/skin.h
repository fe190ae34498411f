// A skinned shape: points are carried back through the blend of its bones to the pose that it was bound in, where a model is
// queried.
#pragma once

#include "sqmap/query/probe.h"
#include "sqmap/query/swept.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::query {

/// The space about a skinned solid as it was bound, in cells of a grid, each of six tetrahedra (Kuhn 1960: the corner of least
/// coordinates, then one step along each axis, in the six orders). Cells that one bone moves go with it. The corners of the
/// others go where bones take them, and what is between the corners linearly with them. So the bound solid is mapped without a
/// gap, and how often a position is covered, with sign, is the winding number of the posed surface about it. Immutable, so any
/// number of threads may read it; bake::skin_lattice makes it. Bound mesh's frame and units.
struct SkinLattice {
    /// No cell, node or bone.
    static constexpr std::uint32_t k_none = 0xffffffffu;

    /// Adds linear(bone) position + weight shift(bone) to a corner.
    struct Pull {
        Vec3d position{};
        double weight = 0;
        std::uint32_t bone = 0;
    };
    /// A node of the tree over the cells, in depth-first order.
    struct Node {
        Vec3d lo{}, hi{};              ///< of its cells
        std::uint32_t parent = 0;      ///< of the first node: itself
        std::uint32_t next = 0;        ///< after what is below it
        std::uint32_t bone = k_none;   ///< a leaf of cells that this bone moves
        std::uint32_t blend = k_none;  ///< a leaf of one cell, an entry of corners; neither: has nodes below it
    };

    Vec3d origin{};
    double cell = 0;
    std::array<std::uint32_t, 3> size{};  ///< cells along x, y, z
    std::vector<std::uint32_t> leaf_of;   ///< of each cell, x fastest; k_none where nothing of the solid is
    std::vector<Node> nodes;
    std::vector<std::array<std::uint32_t, 8>> corners;  ///< of blended cells; bit k of the entry's number: a step along axis k
    std::vector<std::uint32_t> first_pull;              ///< #corners in use + 1
    std::vector<Pull> pulls;
    std::uint32_t bones = 0;
};

/// A position of the bound solid that is now at the queried one.
struct PreImage {
    Vec3d bound{};
    Affine local{};         ///< what takes its surroundings there
    std::int32_t sign = 1;  ///< -1: turned inside out, as the inner side of a sharp bend is
};

struct SkinCluster;
struct CellHit;

/// A position of the bound solid that is now at the queried one, and the tetrahedron that took it there.
struct SkinPosition {
    Vec3d bound{};
    std::uint32_t leaf = 0;
    std::uint8_t order = 0;  ///< of the six, where the leaf is a blended cell
    std::int8_t sign = 1;    ///< as PreImage's
};

/// A lattice in one pose. pose() needs it alone; the rest may be called from several threads.
class PosedSkin {
public:
    /// lattice: outlives this. Bones are at rest. Allocates.
    explicit PosedSkin(const SkinLattice& lattice);

    /// maps: #bones, bound -> posed. False where one is not finite or their number is wrong: nothing changes then. A bone whose
    /// map cannot be inverted holds nothing. No allocation. Cost: a few operations a blended corner and node of the tree.
    [[nodiscard]] bool pose(std::span<const Affine> maps) noexcept;

    /// All bound positions that are now at a posed one, at most found.size() and 64; returns how many there are. No allocation.
    [[nodiscard]] std::size_t carry_back(Vec3d posed, std::span<PreImage> found) const noexcept;
    /// The map that takes a bound position to its present one. False where no cell holds the position.
    [[nodiscard]] bool carry_forward(Vec3d bound, Affine& local) const noexcept;
    /// A box that holds all of the posed lattice; empty (lo > hi) where nothing is.
    struct Box {
        Vec3d lo{}, hi{};
    };
    /// The box of the present pose, in the posed frame.
    [[nodiscard]] Box box() const noexcept { return boxes_.empty() ? Box{{1, 1, 1}, {-1, -1, -1}} : boxes_.front(); }
    /// The maps of all bones, bound -> posed, that pose() got last. Valid while the skin is.
    [[nodiscard]] std::span<const Affine> maps() const noexcept { return maps_; }
    /// How far a position of the lattice is from where another pose has it, at most. @pre both are of one lattice
    [[nodiscard]] double farthest_from(const PosedSkin& other) const noexcept;

private:
    friend struct SkinQuery;
    void add_rigid(std::uint32_t leaf, Vec3d posed, std::span<SkinPosition> found, std::size_t& count) const noexcept;
    void add_blended(std::uint32_t leaf, const CellHit& hit, std::span<SkinPosition> found, std::size_t& count) const noexcept;
    /// Bound positions of a cluster's points at once, max_count for each; counts: how many each has.
    void carry_back(const SkinCluster& cluster, std::span<SkinPosition> found, std::size_t max_count,
                    std::span<std::size_t, Probe::k_cluster> counts) const noexcept;
    /// The map that takes the surroundings of a bound position to the posed frame.
    Affine local_at(const SkinPosition& position) const noexcept;
    std::uint32_t leaf_at(Vec3d bound) const noexcept;

    const SkinLattice* lattice_;
    std::vector<Affine> maps_, back_;
    std::vector<std::int32_t> sign_;  ///< of each bone's determinant; 0: not invertible
    std::vector<Vec3d> corners_;
    std::vector<Box> boxes_;
};

/// A skin that moves through a step: where it began, where it ends, and where it is queried in between. One for each thread that
/// queries: a swept query changes what is in between.
class MovingSkin {
public:
    /// lattice: outlives this. Begins and ends at rest. Allocates.
    explicit MovingSkin(const SkinLattice& lattice);

    /// The end of the last step becomes the beginning, and the maps (#bones, bound -> posed) take the lattice to the end. False
    /// as for PosedSkin::pose: the lattice then stands still in this step. No allocation. Cost: that of one pose.
    [[nodiscard]] bool step(std::span<const Affine> maps) noexcept;

    /// As it was given.
    [[nodiscard]] const SkinLattice& lattice() const noexcept { return *lattice_; }
    /// The lattice as the step begins.
    [[nodiscard]] const PosedSkin& from() const noexcept { return from_; }
    /// The lattice as the step ends.
    [[nodiscard]] const PosedSkin& to() const noexcept { return to_; }
    /// How far a position of the lattice goes in the step at most; zero where it stands still.
    [[nodiscard]] double motion() const noexcept { return motion_; }

private:
    friend struct SkinSweep;
    const SkinLattice* lattice_;
    PosedSkin from_, to_, between_;
    std::vector<Affine> maps_;
    double motion_ = 0;
};

/// One contact of a skinned shape, the posed frame and its units.
struct SkinContact {
    Vec3d witness{};          ///< on the tangent plane of the nearest surface: the queried point + depth normal
    Vec3d normal{};           ///< unit, outward
    Vec3d bound_witness{};    ///< the nearest surface point in the bound mesh's frame: rides the skin
    Vec3d bound_normal{};     ///< and its unit normal there
    double depth = 0;         ///< >= 0
    std::uint32_t index = 0;  ///< of the queried point
    std::int16_t part = -1;   ///< of the bound model
    std::uint8_t status = k_ok;
};

/// The workspace of query_skin, made outside the tick: one for each thread that queries.
class SkinWorkspace {
public:
    /// Positions in the bound frame that are found for a point at most.
    static constexpr std::size_t k_max = 8;

    /// points: where they are at first, which chooses the probe's clusters. Allocates.
    SkinWorkspace(const SkinLattice& lattice, std::span<const Vec3d> points);

private:
    friend struct SkinQuery;
    friend struct SkinSweep;
    std::size_t size_;
    Probe probe_;                                ///< in the bound frame
    std::vector<SkinPosition> positions_;        ///< all that were found, a point's together
    std::vector<SkinPosition> found_positions_;  ///< of a cluster, k_max a point
    std::vector<std::uint32_t> first_;           ///< of a point's positions
    std::vector<std::uint8_t> count_;            ///< of them
    std::vector<Vec3d> active_positions_;
    std::vector<std::uint8_t> active_;
    std::vector<std::int32_t> covered_;  ///< how often the solid covers the point, with sign
    std::vector<SkinContact> best_;
    std::vector<Contact> found_;
    std::vector<Vec3d> at_;  ///< of a sweep; so below
    std::vector<std::uint8_t> fast_;
    std::vector<std::uint32_t> contact_;
    std::vector<SkinContact> swept_;
};

/// The unit normal of a surface with this one where a map takes it (the cofactors, as areas go).
[[nodiscard]] Vec3d carried_normal(const Affine& local, Vec3d normal) noexcept;

/// Points against a posed solid.
struct SkinnedQuery {
    const model::ModelView* bound = nullptr;  ///< baked from the bound mesh
    const PosedSkin* skin = nullptr;
    std::span<const Vec3d> points;         ///< as many as the workspace was made for, the posed frame
    std::span<const std::uint8_t> active;  ///< of each point, whether it is queried; empty for all
};

/// Which points are in the posed solid (where the winding number of the posed surface is positive), how deep and which direction
/// leads out; in order of their index. Points that are not finite have no contacts. Depth is that to the tangent plane at the
/// nearest surface of the bound pose, carried forward with its surroundings; of several bound positions at a point the deepest
/// counts. Total, noexcept, no allocation. first_only stops at the contact of lowest index. In the posed frame.
/// @pre options.offset and margin are off
/// Cost: a walk down the tree a point, and a probe query of the points that it finds something for.
[[nodiscard]] ProbeResult query_skin(const SkinnedQuery& query, const QueryOptions& options, SkinWorkspace& workspace,
                                     std::span<SkinContact> contacts) noexcept;

/// Points that move against a skin that moves.
struct SweptSkinQuery {
    const model::ModelView* bound = nullptr;  ///< baked from the bound mesh
    MovingSkin* skin = nullptr;
    std::span<const Vec3d> previous, now;  ///< the points at both ends of the step, the posed frame; as many as the workspace's
    std::span<const std::uint8_t> active;  ///< of each point, whether it is queried; empty for all
};

/// Contacts of the points at the end of the skin's step and their own, as query_skin gives them, and of those that crossed the
/// surface on their path, as query_swept has it: with the surface that was crossed first, carried to where the step ends, and the
/// depth behind its tangent plane there. In between, bones' maps are blended, which is right to the square of half the angle that
/// they turn in a step.
/// @pre as query_skin
/// Cost: a query, and for each options.step of the longest path a pose and a query of the points that move farther than one.
[[nodiscard]] SweptResult query_swept_skin(const SweptSkinQuery& query, const SweptOptions& options, SkinWorkspace& workspace,
                                           std::span<SkinContact> contacts) noexcept;

}  // namespace sqmap::query
