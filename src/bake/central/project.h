// The mesh as a part's chart sees it: footprints of triangles on the faces, and rays from the centre.
#pragma once

#include "bake/central/chart.h"
#include "bake/central/footprint.h"
#include "model/chart.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/shape/superquadric.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::bake {

/// Margin about each cell of a face: more than float rounding moves a point.
inline constexpr double k_cell_border = 4e-6;

/// A direction from the centre.
struct FacePoint {
    int face = 0;
    double s = 0, t = 0;
};

/// Surface crossings of one ray from the centre, nearest first: values of w where the verdict changes.
struct RaySample {
    bool valid = false;  ///< false: the ray is ambiguous, it meets edges whatever is done
    int count = 0;
    std::array<double, 16> w{};
};

using Footprints = std::array<std::vector<Polygon>, model::k_faces>;

/// All triangles of a mesh that a chart's domain holds, projected from its centre. Const members are thread-safe.
class Projection {
public:
    /// solid: outlives it; in model space.
    Projection(const mesh::Solid& solid, const PartChart& chart);

    [[nodiscard]] const PartChart& chart() const { return chart_; }
    [[nodiscard]] const mesh::Solid& solid() const { return solid_; }
    [[nodiscard]] Vec3d centre() const { return centre_; }
    [[nodiscard]] int centre_winding() const { return centre_winding_; }
    /// Rows of the map from model space, relative to the centre, to the chart's frame. Row-major, as stored.
    [[nodiscard]] const Mat3d& rows() const { return rows_; }
    [[nodiscard]] const Footprints& footprints() const { return footprints_; }
    /// The least weight w of all footprints; 1 where there are none.
    [[nodiscard]] double least_w() const { return least_w_; }
    [[nodiscard]] double max_w() const { return max_w_; }

    /// Both sides of the triangle are inside, or both outside.
    [[nodiscard]] bool is_buried(std::uint32_t triangle) const { return solid_.boundary()[triangle] == mesh::Boundary::Buried; }
    /// The triangle is the part's, and boundary.
    [[nodiscard]] bool is_own(std::uint32_t triangle) const { return own_[triangle] != 0 && !is_buried(triangle); }

    /// Footprints of some triangles of another mesh with the same triangles, appended.
    void append_footprints(const mesh::Mesh& mesh, std::span<const std::uint32_t> triangles, Footprints& to) const;

    /// Crossings of a ray with the triangles of some footprints, which have to be all that are near it.
    [[nodiscard]] RaySample crossings(FacePoint at, std::span<const Polygon> near) const;
    [[nodiscard]] RaySample crossings(FacePoint at, std::span<const Polygon* const> near) const;

    /// True where a point is in the chart's domain.
    [[nodiscard]] bool is_in_domain(FacePoint at, double w) const;

    /// Length, in model units, that a change of w by e moves a surface with that plane.
    [[nodiscard]] double metric_deviation(FacePoint at, const model::ChartPlane<double>& plane, double e) const;

    /// Largest extent of a cell of that size (in s and t) at radius 1/w, model units.
    [[nodiscard]] double metric_size(int face, double size, double w) const;

private:
    friend class CellTriangles;

    /// A triangle as rays from the centre meet it.
    struct Sides {
        Vec3d normal[3];  ///< of the planes through the centre and an edge
        double tiny, volume;
    };

    void clip_to_domain(std::vector<Vec3d>& polygon) const;
    [[nodiscard]] Sides sides_of(const mesh::Triangle& triangle) const;
    [[nodiscard]] const Sides& side_of(const Polygon& p) const { return sides_[side_of_[p.triangle]]; }
    /// target(i): the sides of a triangle, or null for one that the ray is clear of.
    template <class Target>
    [[nodiscard]] RaySample cross_nudged(FacePoint at, std::size_t count, Target&& target) const;
    template <class Target>
    [[nodiscard]] bool cross_all(Vec3d q, std::size_t count, Target&& target, RaySample& result) const;

    const mesh::Solid& solid_;
    PartChart chart_;
    Vec3d centre_;
    int centre_winding_ = 0;
    Mat3d rows_;
    std::vector<std::uint8_t> own_;       ///< #triangles
    std::vector<Vec3d> x_;                ///< #vertices, in the chart's frame
    std::vector<Sides> sides_;            ///< of triangles in the domain
    std::vector<std::uint32_t> side_of_;  ///< #triangles: number in sides_
    Footprints footprints_;
    double least_w_ = 1, max_w_ = 1;
};

/// The triangles near the rays of one cell, laid out for many rays: a polygon fills sixteen cache lines.
class CellTriangles {
public:
    /// near: of the cell; projection: outlives it.
    CellTriangles(const Projection& projection, int face, std::span<const Polygon> near);

    /// As Projection's.
    [[nodiscard]] RaySample crossings(FacePoint at) const;

    /// w of the triangle that crosses a ray at w, with its slopes there; those are 0 where there is no footprint.
    [[nodiscard]] model::ChartPlane<double> plane_at(FacePoint at, double w) const;

private:
    struct Ray {
        Extent whole;
        const Projection::Sides* sides;
    };
    /// w = w + s ws + t wt over a footprint.
    struct Plane {
        double w, ws, wt;
        Extent extent;
    };

    const Projection& projection_;
    std::vector<Ray> rays_;
    std::vector<Plane> planes_;  ///< of the triangles whose plane does not hold the centre
};

}  // namespace sqmap::bake
