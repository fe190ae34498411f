// Covers of a solid's pieces by balls about points within it.
#pragma once

#include "collider/searches.h"
#include "math/bit_set.h"
#include "sqmap/mesh/solid.h"

#include <cstddef>
#include <vector>

namespace sqmap::collider {

/// A piece of the solid by its corners.
struct GridPiece {
    std::vector<Vec3d> corners;
    Vec3d middle{};
};
/// How far the farthest corner of a piece is from a point.
[[nodiscard]] double reach_of(const GridPiece& piece, Vec3d from);

/// Pieces and a ball about them.
struct Cluster {
    std::vector<std::size_t> pieces;
    Sphere ball{};
    double protrusion = 0;
};

/// Balls with centres near the solid's medial axis. One that reaches no farther than d beyond the surface point nearest to its
/// centre protrudes by d at most.
class InnerBalls {
public:
    /// inner: points within the solid, from which centres are sought as from the pieces' middles. The pieces must outlive the
    /// balls.
    InnerBalls(const std::vector<GridPiece>& pieces, const mesh::Solid& solid, std::vector<Vec3d> inner);

    /// Clusters of all pieces, in at most count of the balls that may protrude so far; none where these do not suffice. Greedy
    /// set cover (V. Chvatal, "A greedy heuristic for the set-covering problem", 1979).
    [[nodiscard]] std::vector<Cluster> cover(double protrusion, std::size_t count) const;

private:
    struct Centre {
        Vec3d at;
        double depth;  ///< below the surface
    };
    static Centre deepest_near(const mesh::Solid& solid, Vec3d p, double step);
    [[nodiscard]] BitSet held_by(const Centre& c, double protrusion) const;

    const std::vector<GridPiece>& pieces_;
    std::vector<double> radii_;  ///< #pieces, of balls about their middles
    std::vector<Centre> centres_;
};

}  // namespace sqmap::collider
