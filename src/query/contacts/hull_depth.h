// The least translation that separates two convex hulls.
#pragma once

#include "query/probe/triangle_tree.h"
#include "sqmap/query/separating.h"

namespace sqmap::query {

/// Bounds of the least translation of b that separates the hulls of two meshes, by a polytope within the difference of the hulls
/// that grows where it is nearest to the origin.
class HullDepth {
public:
    HullDepth(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a, SeparatingWorkspace& workspace) noexcept;

    void run() noexcept;

    [[nodiscard]] double upper() const { return upper_; }         ///< along direction(); 0 where the hulls are apart
    [[nodiscard]] double lower() const { return lower_; }         ///< no shorter one separates the hulls
    [[nodiscard]] Vec3d direction() const { return direction_; }  ///< unit, in a's frame
    [[nodiscard]] bool is_exact() const { return is_exact_; }     ///< the bounds differ by rounding alone

private:
    using Facet = SeparatingWorkspace::Facet;

    /// The point of the difference a - b that is farthest along a direction, and how far the direction's plane is: an upper
    /// bound.
    [[nodiscard]] Vec3d support(Vec3d direction);
    [[nodiscard]] bool begin();
    /// False where there is no space left, or the polytope is too thin to go on.
    [[nodiscard]] bool grow(std::uint32_t facet, Vec3d corner);
    [[nodiscard]] bool is_visible(const Facet& f, Vec3d corner) const { return dot(f.normal, corner) > f.distance + near_; }
    bool set_facet(std::uint32_t f, std::uint32_t a, std::uint32_t b, std::uint32_t c);

    const TriangleTree &a_, &b_;
    const Affine b_in_a_;
    SeparatingWorkspace& workspace_;
    Vec3d middle_{};
    double near_ = 0;
    double upper_, lower_ = 0;
    Vec3d direction_{0, 0, 1};
    bool is_exact_ = false;
    std::size_t facets_ = 0, corners_ = 0;
};

/// True where the mesh is one convex piece: no neighbour of a triangle is above its plane by more than 1e-12 of the size.
/// @pre one side of the workspace has space for it
[[nodiscard]] bool is_convex(const TriangleTree& tree, SeparatingWorkspace& workspace) noexcept;

}  // namespace sqmap::query
