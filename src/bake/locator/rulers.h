// The triangles that are nearest at the corners of a box, and others' distances measured against theirs.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sqmap::bake {

/// From each point of a lattice the distance to a triangle and the vector to its nearest point; arrays by lattice point.
struct LatticeDistances {
    const float* distance;
    const float* offset[3];
};

/// Triangles that are nearest at some corner of a box, with their distances from all of them. Corner k lies at the greater end of
/// axis 0, 1, 2 where bit 0, 1, 2 of k is set.
struct Rulers {
    std::uint32_t triangle[8];
    alignas(32) float value[8][8];
    std::size_t count = 0;

    /// True if a triangle is farther than some ruler everywhere in the box: by the planes that touch its distance at corners
    /// nearest, nearest ^ 1 and on, so many of them as tried. corners: of the box, as lattice points; side: of the box; slack: of
    /// the rounding of a distance. The bits do not depend on the machine.
    [[nodiscard]] bool rule_out(const LatticeDistances& of, const std::size_t (&corners)[8], std::size_t nearest,
                                std::size_t tried, float side, float slack) const;
};

}  // namespace sqmap::bake
