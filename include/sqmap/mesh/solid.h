// The solid a mesh bounds: where the winding number is positive, whatever overlaps or crosses.
#pragma once

#include "sqmap/mesh/bvh.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// How a triangle lies to the solid's boundary.
enum class Boundary : std::uint8_t {
    Whole,   ///< all of it is boundary
    Buried,  ///< none of it: both sides are inside, or both outside
    Partly,  ///< another triangle cuts or covers it: see Solid::visible
};

/// Exact inside, distance and ray crossings of the solid, in double. The mesh must outlive it.
/// Thread safety: immutable once made; any number of threads may read it.
class Solid {
public:
    /// crossed: #triangles, non-zero where another triangle cuts it (see find_self_intersections); empty for none.
    explicit Solid(const Mesh& mesh, std::span<const std::uint8_t> crossed = {});

    /// True if the winding number about p is positive; exact for points off the surface.
    [[nodiscard]] bool inside(Vec3d p) const { return bvh_.winding_number(p) > 0; }
    /// Closest point of the solid's boundary; buried pieces do not count. within: how far it is at most, the closer the
    /// faster; where nothing is nearer, the distance is within.
    [[nodiscard]] ClosestPoint closest_boundary(Vec3d p, double within = std::numeric_limits<double>::infinity()) const;
    [[nodiscard]] const Bvh& bvh() const { return bvh_; }                           ///< of all triangles
    [[nodiscard]] const Mesh& mesh() const { return mesh_; }                        ///< as it was given
    [[nodiscard]] std::span<const Boundary> boundary() const { return boundary_; }  ///< #triangles
    /// The parts of a triangle that are boundary, cut into triangles; only for a triangle that is partly boundary.
    [[nodiscard]] std::span<const std::array<Vec3d, 3>> visible(std::uint32_t triangle) const
    {
        return first_piece_.empty()
                   ? std::span<const std::array<Vec3d, 3>>{}
                   : std::span(pieces_).subspan(first_piece_[triangle], first_piece_[triangle + 1] - first_piece_[triangle]);
    }
    [[nodiscard]] bool self_intersecting() const { return self_intersecting_; }  ///< a triangle is crossed

private:
    void find_buried_shells();
    void find_pieces(std::span<const std::uint8_t> crossed);
    /// A point near a triangle, with the winding number about it.
    struct Known {
        Vec3d point;
        int winding;
    };
    /// Inside just below p, which lies on a triangle, and outside just above. known: a point near that triangle, or nothing; set
    /// to the point just below p.
    bool is_boundary(Vec3d p, std::uint32_t triangle, std::optional<Known>& known) const;

    const Mesh& mesh_;
    Bvh bvh_;
    std::vector<Boundary> boundary_;
    std::vector<std::uint32_t> first_piece_;  ///< #triangles + 1, of pieces_; empty where nothing is cut
    std::vector<std::array<Vec3d, 3>> pieces_;
    double step_ = 0;  ///< how far beside a surface its two sides are probed
    bool self_intersecting_ = false;
    bool all_boundary_ = true;  ///< every triangle is boundary, whole
};

}  // namespace sqmap::mesh
