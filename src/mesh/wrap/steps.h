// The steps of wrapping, in their order: labels of the grid's corners, the dual surface between them, positions of its vertices,
// a closed mesh, and a coarser one.
#pragma once

#include "grid.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/mesh.h"
#include "winding.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sqmap::mesh {

/// The solid that a triangle bounds where the grid is too coarse for the winding number alone.
enum class Thin : std::uint8_t {
    No,
    Wall,   ///< a solid thinner than a cell, but not than a shell
    Sheet,  ///< no solid, or a thinner one: a shell is made about it
};

/// The input of a wrap, in units of the cells.
struct Source {
    const Mesh& soup;
    const Bvh& bvh;
    const WindingNumber& winding;
    double thickness;  ///< least thickness of a shell
};

struct Labels {
    std::vector<float> winding;        ///< #corners
    std::vector<std::uint8_t> inside;  ///< #corners: k_solid, k_shell or 0
    std::vector<Thin> thin;            ///< #triangles
};

inline constexpr std::uint8_t k_solid = 1;  ///< the winding number is above 1/2
inline constexpr std::uint8_t k_shell = 2;  ///< the winding number is not, but a thin triangle is near

/// Labels all corners, and adds the cells without triangles that the solid's boundary passes through.
[[nodiscard]] Labels label_corners(Grid& grid, const Source& source);

/// Four sheets about an edge of the grid, one end of which is inside.
struct DualQuad {
    std::array<std::uint32_t, 4> vertices{};  ///< counter-clockwise seen from outside
    /// Vertex k is joined to the next one by a vertex between them, or by KeyTable::k_absent directly: two sheets that meet
    /// across two stretches of one side need two different edges.
    std::array<std::uint32_t, 4> between{};
    std::uint32_t inside = 0, outside = 0;  ///< corners: the ends of the edge
    std::uint32_t cell = 0;                 ///< one of the four
};

/// Closed and manifold whatever the labels are.
struct DualSurface {
    std::vector<std::uint32_t> vertex_cell;  ///< #vertices of sheets
    std::uint32_t between_count = 0;         ///< vertices that follow those of sheets
    std::vector<DualQuad> quads;
};

/// inside: #corners, not zero where inside. @pre all cells that the boundary passes through are in the grid.
[[nodiscard]] DualSurface dual_surface(const Grid& grid, std::span<const std::uint8_t> inside);

/// The surface that an edge of the grid crosses.
enum class Crossed : std::uint8_t { Input, Level, Shell };

struct Positions {
    std::vector<Vec3d> vertices;   ///< #vertices of sheets, then those between
    std::vector<Vec3d> crossings;  ///< #quads
    std::vector<Crossed> kinds;    ///< #quads
    bool has_shells = false;
};

/// The input of the positions.
struct Labelled {
    const Source& source;
    const Grid& grid;
    const Labels& labels;
};

[[nodiscard]] Positions positions_of(const DualSurface& surface, const Labelled& labelled);

struct ClosedMesh {
    std::vector<Vec3d> vertices;
    std::vector<Triangle> triangles;
    std::vector<std::uint8_t> made_up;   ///< #triangles
    std::vector<Vec3d> samples;          ///< of the surface
    std::vector<std::uint32_t> carrier;  ///< #samples: a triangle on or near which it lies
};

/// The quadrilaterals cut into triangles, along the diagonal that is nearer to the crossing.
[[nodiscard]] ClosedMesh triangulated(const DualSurface& surface, const Positions& positions);

/// Leaves out components whose box has a shorter diagonal than that.
void drop_crumbs(ClosedMesh& mesh, double diagonal);

class Enclosed;

struct DecimateLimits {
    double max_error = 0;  ///< distance of any sample from the result
    std::uint32_t max_triangles = 0;
    const Enclosed* enclosed = nullptr;         ///< stays inside where the surface moves
    std::span<const std::uint8_t> locked = {};  ///< #vertices, non-zero: stays; empty: none
};

/// Collapses edges while every sample stays within max_error of the surface, and farther, by doubling it, until the triangles
/// are few enough. Vertices that lie on the input stay on it, if nothing is enclosed. Returns the error that was allowed in the
/// end. Closed and manifold stay as they are.
double decimate(ClosedMesh& mesh, const Bvh& bvh, const DecimateLimits& limits);

}  // namespace sqmap::mesh
