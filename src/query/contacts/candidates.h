// Pairs of triangles of two meshes that may have a point in common: few more than do.
#pragma once

#include "query/probe/triangle_tree.h"
#include "sqmap/math/vec.h"

namespace sqmap::query {

/// Triangles of a and b by the caller's numbers.
struct TrianglePair {
    std::uint32_t a, b;
};

/// Two trees and how b's is posed, as kernels in float read them.
struct PosedTrees {
    /// b_in_a: b's frame -> a's, a rotation and a shift. @pre both have triangles, b_in_a is finite
    PosedTrees(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a) noexcept;

    TriangleTree::Columns a, b;
    std::size_t groups_a, groups_b, leaves_a, leaves_b, triangles_a, triangles_b;
    Vec3d between{};  ///< from the centre of a's box to that of b's
    double radius_a, radius_b;

    // Position about the centre of b's box -> position about the centre of a's.
    float rotation[9] = {}, shift[3] = {};
    /// A position that was rounded to float and moved is nearer than this to where it should be.
    float error = 0;
    float margin = 0;  ///< by which boxes of b are larger: what rounding takes, and reach
};

/// The search for pairs, set up once a query, the same for every instruction set.
struct CandidateJob : PosedTrees {
    /// reach: how far points of b may be from there besides. @pre as of PosedTrees
    CandidateJob(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a, double reach = 0) noexcept;

    Boxf box_a;               ///< from its centre
    bool has_planes = false;  ///< a plane of a triangle may separate others; not where points move
    bool is_far = true;       ///< the boxes' spheres do not touch: nothing is found
};

/// Takes pairs as they are found; context: the caller's. False ends the search.
using TakePairs = bool (*)(void* context, std::span<const TrianglePair> pairs) noexcept;

/// Hands over each pair of triangles that have a point in common, and few others, in an order that depends on the trees and the
/// pose alone. Filters err towards taking a pair.
void find_candidates(const CandidateJob& job, TakePairs take, void* context) noexcept;

}  // namespace sqmap::query
