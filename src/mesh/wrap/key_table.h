// Numbers for lattice points, in the order in which they come.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace sqmap::mesh {

/// A point of the lattice of whole numbers, each below 2^20 in size.
using LatticePoint = std::array<std::int32_t, 3>;

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

}  // namespace sqmap::mesh
