// The triangles of a closed mesh, prepared once so that all that meet another mesh's are found in microseconds.
#pragma once

#include "sqmap/math/box.h"
#include "sqmap/query/probe.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::query {

/// True where the body's surface is known, not its points alone.
inline bool has_triangles(const Body& body) noexcept { return body.probe != nullptr && body.probe->triangle_count() > 0; }

/// Near triangles make a leaf of 16, near leaves a group of 16, each with a box. Positions stay as they are given, in double.
/// Thread safety: any number of threads may query one tree; move() needs it alone.
class TriangleTree {
public:
    static constexpr std::size_t k_leaf = 16, k_group = 16;
    static constexpr std::size_t k_max = std::size_t{1} << 28;  ///< triangles

    TriangleTree() = default;
    /// @pre find_fault(points, triangles) finds nothing. Allocates; cost n log n.
    TriangleTree(std::span<const Vec3d> points, std::span<const ProbeTriangle> triangles);

    /// New positions of the same points: boxes are refitted, nothing is allocated. @pre as many as before
    void move(std::span<const Vec3d> points) noexcept;

    /// Number of triangles.
    [[nodiscard]] std::size_t size() const noexcept { return triangles_.size(); }
    /// Number of points, with or without a triangle.
    [[nodiscard]] std::size_t points() const noexcept { return points_.size(); }
    /// Bytes that the tree keeps in memory.
    [[nodiscard]] std::size_t bytes() const noexcept;
    /// The caller's triangle. @pre it exists
    [[nodiscard]] const ProbeTriangle& triangle(std::size_t t) const noexcept { return triangles_[t]; }
    /// The caller's position. @pre it exists
    [[nodiscard]] Vec3d point(std::size_t i) const noexcept { return points_[i]; }
    /// Coordinates of point 0, then of point 1, and so on. @pre there are points
    [[nodiscard]] const double* coordinates() const noexcept { return &points_.front().x; }
    /// Half-edge 3 t + k runs from corner k of triangle t to the next one; its twin runs the other way, in the neighbour.
    [[nodiscard]] std::uint32_t twin(std::uint32_t half_edge) const noexcept { return twin_[half_edge]; }
    /// Bit k: the faces along side k of triangle t turned by more than 53 degrees from one to the other in the first positions.
    [[nodiscard]] std::uint32_t sharp(std::size_t t) const noexcept { return sharp_[t]; }
    /// A half-edge that begins at a point; k_no_half_edge where no triangle has the point.
    [[nodiscard]] std::uint32_t half_edge_from(std::size_t point) const noexcept { return from_[point]; }
    static constexpr std::uint32_t k_no_half_edge = 0xffffffffu;
    /// Holds all points; the points' own frame.
    [[nodiscard]] const Box& box() const noexcept { return box_; }

    // Rows begin where a line of the cache does: a vector that reads of two lines takes twice the time.
    /// Boxes side by side; those after the last one repeat it.
    struct alignas(64) BoxRow {
        float lo[3][k_group], hi[3][k_group];
    };
    /// Slabs that hold leaves, side by side: normal . p is between lo and hi for each corner p from box()'s centre. The normals
    /// are about units, the leaf's mean; zero where it has none.
    struct alignas(64) SlabRow {
        float normal[3][k_group], lo[k_group], hi[k_group];
    };
    /// Corners of the triangles of a leaf, from box()'s centre; those after the last one repeat it.
    struct alignas(64) CornerRow {
        float at[3][3][k_leaf];  ///< corner, axis, triangle
    };
    /// Arrays that the kernels read.
    struct Columns {
        std::span<const BoxRow> groups;          ///< 16 groups a row
        std::span<const BoxRow> leaves;          ///< a row for each group
        std::span<const SlabRow> slabs;          ///< as leaves
        std::span<const CornerRow> corners;      ///< for each leaf
        std::span<const std::uint32_t> numbers;  ///< of the leaves' triangles, the caller's
        const ProbeTriangle* triangles;          ///< the caller's
        const std::uint32_t* twins;              ///< of their half-edges
    };
    /// The tree's arrays; valid until the next move.
    [[nodiscard]] Columns columns() const noexcept
    {
        return {groups_, leaves_, slabs_, corners_, numbers_, triangles_.data(), twin_.data()};
    }

private:
    void refit() noexcept;

    std::vector<Vec3d> points_;
    std::vector<ProbeTriangle> triangles_;
    std::vector<std::uint32_t> twin_, from_;
    std::vector<std::uint8_t> sharp_;
    std::vector<std::uint32_t> numbers_;
    std::vector<CornerRow> corners_;
    std::vector<BoxRow> leaves_, groups_;
    std::vector<SlabRow> slabs_;
    Box box_;
};

}  // namespace sqmap::query
