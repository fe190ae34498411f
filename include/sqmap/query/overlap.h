// How much two solids share: the volume of their intersection, exact from their triangles.
#pragma once

#include "sqmap/query/contacts.h"

#include <cstdint>
#include <vector>

namespace sqmap::query {

/// The intersection of two solids.
struct Overlap {
    double volume = 0;  ///< of the probes' triangles, in the cube of the poses' unit; a solid that is covered twice counts twice
    double error = 0;   ///< bound of what the shift below changes, without rounding
    std::uint16_t status = k_ok;  ///< bits of Status and ContactStatus
};

/// The workspace of overlap(), made outside the tick: one for each thread that queries.
class OverlapWorkspace {
public:
    /// For probes with at most as many triangles and points as these. Allocates.
    OverlapWorkspace(const Probe& a, const Probe& b);
    /// True where these triangles fit.
    [[nodiscard]] bool holds(const Probe& a, const Probe& b) const noexcept;

private:
    friend class OverlapQuery;
    /// Arrays about one of the two meshes.
    struct Side {
        std::vector<std::int16_t> winding;     ///< of points in the other mesh
        std::vector<std::int16_t> change;      ///< of the winding along an edge, by its lower half-edge
        std::vector<double> inside;            ///< sum of the shares at which the edge leaves, less those at which it enters
        std::vector<std::uint32_t> triangles;  ///< in the order in which a walk over the mesh reaches them
        std::vector<std::uint8_t> is_reached;

        explicit Side(const TriangleTree& tree);
        [[nodiscard]] bool holds(const TriangleTree& tree) const noexcept;
    };
    Side a_, b_;
};

/// Volume of the intersection of a and b, whose probes have triangles; models are not read. Where features are in special
/// position (coplanar faces, a vertex on a face), b is shifted by 1e-13 of the larger size, and `error` says how much that can
/// change. A pose that is not finite: volume 0, k_not_finite. A probe without triangles: k_no_triangles. A workspace that is too
/// small, or special position at every shift: k_full. Total, noexcept, no allocation.
/// Cost: that of complete contacts without vertices, and linear in all triangles.
/// Source: V = 1/6 sum of (p - q) . (s x e) over oriented edges of the intersection, where p and q are points of its two planes.
[[nodiscard]] Overlap overlap(const Body& a, const Body& b, OverlapWorkspace& workspace) noexcept;

}  // namespace sqmap::query
