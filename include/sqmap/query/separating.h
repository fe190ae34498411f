// How far one solid has to be moved until it is free of another: along a direction, and at least.
#pragma once

#include "sqmap/query/contacts.h"

#include <cstdint>
#include <vector>

namespace sqmap::query {

/// A translation of b after which the solids only touch. The frame and units of the bodies' poses.
struct SeparatingTranslation {
    double distance = 0;          ///< along the direction; 0 where the solids have no point in common
    double at_least = 0;          ///< no shorter translation of those that were in question separates them
    Vec3d direction{};            ///< unit
    bool exact = false;           ///< the bounds differ by rounding alone
    std::uint16_t status = k_ok;  ///< bits of Status and ContactStatus
};

/// The workspace of separating translations, made outside the tick: one for each thread that queries.
class SeparatingWorkspace {
public:
    /// For probes with at most as many triangles and points as these. Allocates.
    SeparatingWorkspace(const Probe& a, const Probe& b);
    /// True where these triangles fit.
    [[nodiscard]] bool holds(const Probe& a, const Probe& b) const noexcept;

private:
    friend class PartingSearch;
    friend class HullDepth;
    friend class LeastTranslation;
    friend bool is_convex(const TriangleTree& tree, SeparatingWorkspace& workspace) noexcept;
    struct Range {
        Vec3d lo, hi;
    };
    /// Arrays about one of the two meshes.
    struct Side {
        std::vector<Vec3d> points;          ///< the last coordinate along the direction
        std::vector<Range> leaves, groups;  ///< boxes of these
        std::vector<std::uint32_t> pieces;  ///< a point of each connected piece
        std::size_t piece_count = 0;
        std::vector<std::uint32_t> stack;
        std::vector<std::uint8_t> is_reached;

        explicit Side(const TriangleTree& tree);
        [[nodiscard]] bool holds(const TriangleTree& tree) const noexcept;
    };
    /// A facet of the polytope within the difference of two hulls.
    struct Facet {
        std::uint32_t corner[3], neighbour[3];  ///< neighbour k: across the side from corner k to the next one
        Vec3d normal;
        double distance;
        bool is_gone;  ///< from the polytope's surface
    };
    static constexpr std::size_t k_facets = 4096, k_corners = 1024, k_contacts = 4096;
    Side a_, b_;
    std::vector<Facet> facets_;
    std::vector<Vec3d> corners_;
    std::vector<std::uint32_t> visible_;
    ContactWorkspace contacts_;
};

/// How far b has to be moved along a direction until a and b, whose probes have triangles, only touch: by 1e-9 of their sizes
/// more they are free of each other, which exact predicates prove. It ends at the first gap that is wider than 2e-9 of the sizes,
/// so b may end in a cavity of a or between two of its limbs. Solids at most 1e-12 of the sizes apart count as touching. Models
/// are not read. direction: of any length but 0, in the frame of the poses; the normal of a SurfaceContact for what separates its
/// region. A pose or direction that is not finite, or a direction of length 0: distance 0, k_not_finite; a probe without
/// triangles: k_no_triangles; a workspace that is too small: k_full. Total, noexcept, no allocation. Cost: linear in points and
/// triangles, and the pairs of triangles that are met on the way: a millisecond for thousands.
[[nodiscard]] SeparatingTranslation separating_translation(const Body& a, const Body& b, Vec3d direction,
                                                           SeparatingWorkspace& workspace) noexcept;

/// The shortest translation in any direction that is known to separate a and b. Of two convex solids (neighbours rise above a
/// triangle's plane by at most 1e-12 of the size) it is the least of all. Of others it is the least among that of their convex
/// hulls and those along the normals of their contacts, up to 16 that differ, the deepest first; `at_least` is then the depth of
/// the deepest vertex in the other body's model (0 without models), as a point that deep has to be moved so far in any direction.
/// Else as separating_translation. Cost: up to 17 times that of separating_translation, and complete contacts. Source of the
/// search on hulls: G. van den Bergen, "Proximity queries and penetration depth computation on 3D game objects", GDC 2001
/// (expanding polytope).
[[nodiscard]] SeparatingTranslation least_separating_translation(const Body& a, const Body& b,
                                                                 SeparatingWorkspace& workspace) noexcept;

}  // namespace sqmap::query
