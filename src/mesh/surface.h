// The working copy of a mesh during admission: triangles that remember where they come from, and their edges.
#pragma once

#include "math/union_find.h"
#include "sqmap/mesh/mesh.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace sqmap::mesh {

inline constexpr std::uint32_t k_none = std::numeric_limits<std::uint32_t>::max();

struct Face {
    Triangle v{};
    std::uint32_t polygon = 0;  ///< number in the file, from zero; k_none: made here
};

struct Surface {
    std::vector<Vec3d> points;
    std::vector<std::uint32_t> source;  ///< vertex number in the file, from zero
    std::vector<Face> faces;
};

/// One side of a face: from corner k to the next.
struct EdgeUse {
    std::uint32_t lo = 0, hi = 0;  ///< vertices, lo < hi
    std::uint32_t half = 0;        ///< 3 * face + k
    bool forward = false;          ///< the face runs lo -> hi
};

/// All sides, those of one edge next to each other.
std::vector<EdgeUse> edge_uses(std::span<const Face> faces);

/// Calls visit(span of EdgeUse) once for each edge.
template <class Visit>
void for_each_edge(std::span<const EdgeUse> uses, Visit visit)
{
    for (std::size_t i = 0; i < uses.size();) {
        std::size_t j = i + 1;
        while (j < uses.size() && uses[j].lo == uses[i].lo && uses[j].hi == uses[i].hi) ++j;
        visit(uses.subspan(i, j - i));
        i = j;
    }
}

/// Every edge has exactly two faces.
bool is_closed(std::span<const Face> faces);

/// Corners of a polygon as triangles of positions in it: the short diagonal of a quadrilateral where both diagonals
/// serve, ears of the best shape otherwise. corners: 4 at least.
std::vector<std::array<std::uint32_t, 3>> triangulated(std::span<const Vec3d> corners);

/// For each vertex the first one in its position (distance 0), or within a distance (chains of such vertices count as one).
std::vector<std::uint32_t> coincident(std::span<const Vec3d> points);
std::vector<std::uint32_t> coincident_within(std::span<const Vec3d> points, double distance);

}  // namespace sqmap::mesh
