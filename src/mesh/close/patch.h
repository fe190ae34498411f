// A filling while it is made: a triangulated disc in a loop, with the surface around it; and its first triangles, of least area.
#pragma once

#include "sqmap/mesh/mesh.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

namespace sqmap::mesh {

/// Looked up and never walked, so that its order has no influence.
class EdgeSet {
public:
    void insert(std::uint32_t a, std::uint32_t b) { keys_.insert(key(a, b)); }
    void erase(std::uint32_t a, std::uint32_t b) { keys_.erase(key(a, b)); }
    [[nodiscard]] bool contains(std::uint32_t a, std::uint32_t b) const { return keys_.contains(key(a, b)); }

private:
    static std::uint64_t key(std::uint32_t a, std::uint32_t b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }
    std::unordered_set<std::uint64_t> keys_;
};

/// Points: the loop's, then those of the rim, then those made up within.
struct Patch {
    std::vector<Vec3d> points;
    std::uint32_t loop_size = 0;
    std::uint32_t first_inner = 0;    ///< of the points that are made up
    std::vector<Triangle> triangles;  ///< turned as the loop runs
    std::vector<Triangle> rim;        ///< faces of the surface with a corner in the loop
    std::vector<double> spacing;      ///< #points: length of the edges about one
    EdgeSet taken;                    ///< edges of the surface between points of the loop
};

/// Puts points into the patch until its triangles are as small as those about it, and turns edges so that they are well shaped.
/// At most max_triangles: beyond, the patch stays coarser. After Liepa.
void refine(Patch& patch, std::size_t max_triangles);

/// How a patch continues the surface around it.
enum class Fairing {
    Taut,    ///< of least area: its Laplacian is zero
    Smooth,  ///< its bi-Laplacian is zero: it continues in the surface's direction
};

/// Moves the points within. False, and nothing moved, where the equations cannot be solved.
bool fair(Patch& patch, Fairing fairing);

/// Share of the loop's length where the patch continues the surface, bending by less than 60 degrees.
[[nodiscard]] double smooth_share(const Patch& patch);

/// Triangles of positions in the loop, turned as it runs, of least total area without a side that is in taken; of loops longer
/// than about 200 points each piece of such length is. Empty if every triangulation needs a taken side. Cost: at most 1e4 areas a
/// point.
[[nodiscard]] std::vector<Triangle> least_area(std::span<const Vec3d> loop, const EdgeSet& taken);

}  // namespace sqmap::mesh
