// The steps of closing a surface: stitching cracks, resolving edges with more than two faces, filling holes, dropping sheets.
#pragma once

#include "../surface.h"

#include <cstdint>
#include <vector>

namespace sqmap::mesh {

/// Loops that run along the boundary against the faces, each vertex once in a loop: where two holes touch in a vertex they come
/// apart there. Each starts at its least position, and they are sorted by it. @pre faces agree in orientation.
std::vector<std::vector<std::uint32_t>> boundary_loops(const Surface& surface);

/// Closes every loop of the boundary; the faces made have no polygon. Returns how many loops were closed.
/// max_triangles: about how many are made; past that, fillings are coarse; 0: only between the points there are. @pre faces agree
/// in orientation, every edge has at most two of them. Cost: 1e4 areas a boundary edge, and of each filling a sparse system.
std::uint32_t fill_holes(Surface& surface, std::size_t max_triangles);

/// Joins vertices of the boundary nearer than tolerance, and splits edges of the boundary at vertices that near, in steps from a
/// thousandth of it; a step that does not make the boundary shorter is taken back. Returns how many edges of the boundary were
/// joined. Cost: n log n.
std::uint64_t stitch(Surface& surface, double tolerance);

/// Counts of drop_sheets.
struct Sheets {
    std::uint64_t dropped_faces = 0;
    double outside_area = 0;  ///< of the dropped ones that lie neither in the rest's solid nor on it
    bool all = false;         ///< there is nothing but sheets: nothing was dropped
};

/// Drops the components that consist of a sheet and a filling over it. surface: every component closed, faces made up have no
/// polygon; tolerance: how near a doubled sheet lies to the surface.
Sheets drop_sheets(Surface& surface, double tolerance);

/// Shares of the rays from either side of a region that meet nothing.
struct Seen {
    double front = 0, back = 0;
};

/// For each region, at its least face; region: of every face, its least face. About 20,000 rays a side, at least eight a region,
/// always the same ones. Cost: rays times log n.
[[nodiscard]] std::vector<Seen> seen_from_outside(const Surface& surface, std::span<const std::uint32_t> region);

/// Counts of resolve_edges.
struct Resolved {
    std::uint64_t turned_faces = 0;
    std::uint64_t wall_faces = 0;   ///< dropped: walls within the solid, seen from neither side
    std::uint64_t cut_edges = 0;    ///< sides of faces that found no partner: boundary now
    std::uint64_t fin_faces = 0;    ///< dropped: they hang on a surface that is whole without them
    std::uint64_t stuck_faces = 0;  ///< dropped: without a partner, and not to be cut off
};

/// Leaves faces that agree with their neighbours, two at most at an edge. It turns regions towards the side from which they are
/// seen, drops walls that are seen from neither side, and at an edge with more faces joins those with solid between them, then
/// those whose sides differ most in visibility; it cuts off the rest. Cost: n log n, and rays at edges with more than two faces.
Resolved resolve_edges(Surface& surface);

/// Turns faces to agree with their neighbours, and regions that are clearly seen from behind; nothing is cut or dropped. Returns
/// how many faces were turned.
std::uint64_t orient_outward(Surface& surface);

}  // namespace sqmap::mesh
