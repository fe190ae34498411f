// Flat faces that lie on each other: where corners and sides of one rest on the other.
#pragma once

#include "candidates.h"
#include "separating_axes.h"

namespace sqmap::query {

/// A corner of the area that two opposed faces share, seen along the mean of their normals: a vertex over a face, or where two
/// sides cross.
struct Support {
    Separation separation;  ///< along that direction
    std::uint32_t triangle_a, triangle_b;
};

/// Takes supports as they are found; context: the caller's.
using TakeSupport = void (*)(void* context, const Support& support) noexcept;

/// Two solids that lie on each other meet where a side face of one crosses the face that bears it. For such a pair of triangles:
/// the ends of the sharp sides (TriangleTree::sharp) below the bearing face, and where they cross its own sharp sides, as far as
/// faces that are opposed to within 15 degrees are in each other by at most an eighth of the side's length. Deeper solids are
/// not at rest.
void find_supports(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a, const TrianglePair& meeting,
                   TakeSupport take, void* context) noexcept;

}  // namespace sqmap::query
