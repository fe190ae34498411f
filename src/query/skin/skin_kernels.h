// The inner part of asking a posed lattice, for every instruction set: a cluster of points goes down the tree at once, and the
// six tetrahedra of a cell are asked side by side. In double and in the order of the plain code, so that all give the same bits.
#pragma once

#include "sqmap/query/skin.h"

namespace sqmap::query {

/// A corner path of one of a cell's six tetrahedra (Kuhn 1960), and whether its axes turn as they are written.
struct KuhnOrder {
    int axis[3];
    std::int32_t parity;
};
inline constexpr KuhnOrder k_kuhn_orders[6] = {{{0, 1, 2}, 1},  {{1, 2, 0}, 1},  {{2, 0, 1}, 1},
                                               {{1, 0, 2}, -1}, {{0, 2, 1}, -1}, {{2, 1, 0}, -1}};

/// Points that are queried together; a cell holds no position that is not a number.
struct SkinCluster {
    static constexpr std::size_t k_points = Probe::k_cluster;
    alignas(64) double x[k_points], y[k_points], z[k_points];
};

struct SkinLeaf {
    std::uint32_t leaf;
    std::uint32_t points;  ///< bit k: point k of the cluster is in its box
};

/// Leaves with points in their boxes, in depth-first order, from a node on, until the room is full; returns the node to go on
/// from, #nodes at the end. slack: that far outside of a box is in it.
std::uint32_t leaves_about(std::span<const SkinLattice::Node> nodes, std::span<const PosedSkin::Box> boxes, double slack,
                           const SkinCluster& cluster, std::uint32_t from, std::span<SkinLeaf> found,
                           std::size_t& count) noexcept;

/// A point in a tetrahedron of a cell: how far along the three edges of its path.
struct CellHit {
    double along[3];
    std::uint8_t point, order;
    bool positive;  ///< its determinant
};
inline constexpr std::size_t k_max_cell_hits = 6 * SkinCluster::k_points;

/// The tetrahedra that hold points of a mask, point after point; corners: posed, bit k of their number a step along axis k.
/// least: of a determinant, below which a tetrahedron holds nothing; border: of an edge, that far outside is in it.
std::size_t cell_hits(const std::array<Vec3d, 8>& corners, double least, double border, const SkinCluster& cluster,
                      std::uint32_t points, std::span<CellHit, k_max_cell_hits> hits) noexcept;

}  // namespace sqmap::query
