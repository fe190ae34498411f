// The grid of a wrap: its cells and corners, numbered in the order in which they come.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// A point of the lattice of whole numbers, each below 2^20 in size.
using LatticePoint = std::array<std::int32_t, 3>;

[[nodiscard]] inline Vec3d position(LatticePoint p) { return {double(p[0]), double(p[1]), double(p[2])}; }

/// Gives each lattice point a number, from zero. Open addressing.
class KeyTable {
public:
    static constexpr std::uint32_t k_absent = std::numeric_limits<std::uint32_t>::max();

    /// The point's number; a new one where it has none.
    std::uint32_t insert(LatticePoint p);
    /// The point's number, or k_absent.
    [[nodiscard]] std::uint32_t find(LatticePoint p) const;
    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(points_.size()); }
    [[nodiscard]] const LatticePoint& point(std::uint32_t i) const { return points_[i]; }

private:
    void grow();
    [[nodiscard]] std::size_t slot_of(LatticePoint p) const;

    std::vector<std::uint32_t> slots_;  ///< a power of two of them, at most half of them in use
    std::vector<LatticePoint> points_;
};

/// A sparse grid. Cell (x, y, z) is [x, x + 1] x [y, y + 1] x [z, z + 1]; its corner k = i + 2 j + 4 l is (x + i, y + j, z + l).
struct Grid {
    KeyTable cells, corners;
    std::vector<std::array<std::uint32_t, 8>> cell_corners;  ///< #cells
    std::vector<std::uint32_t> first;                        ///< of triangles; the cells made with the grid + 1
    std::vector<std::uint32_t> triangles;                    ///< that touch the cell, ascending

    [[nodiscard]] std::span<const std::uint32_t> triangles_of(std::uint32_t cell) const
    {
        if (cell + 1 >= first.size()) return {};
        return std::span(triangles).subspan(first[cell], first[cell + 1] - first[cell]);
    }
    /// The cell's number; where it is new, it has no triangles.
    std::uint32_t add_cell(LatticePoint p);
};

/// The cells that the triangles touch. soup: in units of the cells.
[[nodiscard]] Grid make_grid(const Mesh& soup);

/// About how many pairs of a cell and a triangle make_grid finds, when cells have that side.
[[nodiscard]] double estimated_pairs(const Mesh& soup, double side);

/// True if a triangle and the box between two corners have a point in common (Akenine-Moller 2001).
[[nodiscard]] bool touches(const std::array<Vec3d, 3>& triangle, Vec3d lo, Vec3d hi);

}  // namespace sqmap::mesh
