// The solid as it is seen from outside. Every step keeps the input inside, and the end is proven on the coordinates of the
// result.
#include "grid.h"
#include "outer_steps.h"
#include "steps.h"

#include "../surface.h"

#include "sqmap/math/box.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/wrap.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace sqmap::mesh {

namespace {

constexpr double k_outer_cell = 3;      ///< side of a cell, in tolerances
constexpr double k_offset_share = 0.4;  ///< distance from flat input, in tolerances
constexpr double k_outer_error = 0.3;   ///< error of the decimation, in tolerances
constexpr double k_apart = 1e-6;        ///< the surface stays so far from the input, cells
constexpr double k_max_dense = 1.6e8;   ///< corners of the dense grid, a byte each
constexpr int k_locks = 3;              ///< decimations that may start again with crossings locked
constexpr double k_lock_reach = 2;      ///< about a crossing, cells

constexpr Vec3d k_off_planes{0.3819660113, 0.4142135624, 0.4721359550};

void check_outer(const OuterOptions& options)
{
    if (!(options.tolerance > 0 && options.tolerance <= 0.1)) throw InvalidInput("OuterOptions::tolerance is not in (0, 0.1]");
    if (!k_gap_range.holds(options.gap)) throw InvalidInput("OuterOptions::gap is not " + words(k_gap_range));
    if (options.max_cells < 10'000) throw InvalidInput("OuterOptions::max_cells is below 10,000");
}

/// In cells about the origin. with_area: leaves out triangles without.
Mesh in_cells(std::span<const Vec3d> points, std::span<const Triangle> triangles, bool with_area)
{
    Mesh out{{points.begin(), points.end()}, {}};
    for (const Triangle& t : triangles)
        if (!with_area || norm_sq(cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]])) > 0)
            out.triangles.push_back(t);
    return out;
}

/// Locks the vertices about triangles of a decimated mesh that cross; false where none does.
bool lock_crossings(const ClosedMesh& decimated, const ClosedMesh& fine, std::vector<std::uint8_t>& locked)
{
    const SelfIntersections found = find_self_intersections({decimated.vertices, decimated.triangles});
    if (found.pair_count == 0) return false;
    std::vector<Box> boxes;
    for (std::size_t t = 0; t < found.crossed.size(); ++t) {
        if (found.crossed[t] == 0) continue;
        Box box;
        for (const std::uint32_t v : decimated.triangles[t]) extend(box, decimated.vertices[v]);
        box.lo -= k_lock_reach * Vec3d{1, 1, 1};
        box.hi += k_lock_reach * Vec3d{1, 1, 1};
        boxes.push_back(box);
    }
    for (std::size_t v = 0; v < fine.vertices.size(); ++v)
        for (const Box& box : boxes)
            if (overlap(box, Box{fine.vertices[v], fine.vertices[v]})) locked[v] = 1;
    return true;
}

/// Fewer triangles, without crossings where the fine mesh has none.
ClosedMesh coarser(const ClosedMesh& fine, const Bvh& bvh, DecimateLimits limits)
{
    std::vector<std::uint8_t> locked(fine.vertices.size());
    limits.locked = locked;
    for (int i = 0; i <= k_locks; ++i) {
        ClosedMesh out = fine;
        decimate(out, bvh, limits);
        if (!lock_crossings(out, fine, locked)) return out;
    }
    return fine;
}

}  // namespace

std::optional<std::uint32_t> first_not_enclosed(std::span<const Vec3d> points, std::span<const Triangle> triangles,
                                                const Mesh& solid, double margin)
{
    const Mesh soup{{points.begin(), points.end()}, {triangles.begin(), triangles.end()}};
    const Enclosed enclosed(soup, margin);
    for (const Triangle& t : solid.triangles)
        if (const auto met = enclosed.met_by({solid.vertices[t[0]], solid.vertices[t[1]], solid.vertices[t[2]]})) return met;
    const Bvh bvh(solid);
    std::vector<std::uint8_t> inside(points.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        std::uint8_t& is_in = inside[triangles[t][0]];
        if (is_in == 0) is_in = bvh.winding_number(points[triangles[t][0]]) > 0 ? 1 : 2;
        if (is_in == 2) return t;
    }
    return std::nullopt;
}

OuterResult outer_solid(std::span<const Vec3d> points, std::span<const Triangle> triangles, const OuterOptions& options)
{
    check_outer(options);
    OuterResult result;
    Mesh all = in_cells(points, triangles, false), soup = in_cells(points, triangles, true);
    if (soup.triangles.empty()) return result;
    Box box;
    for (const Triangle& t : triangles)
        for (const std::uint32_t v : t) extend(box, points[v]);
    Mesh used;
    for (const Triangle& t : triangles)
        for (const std::uint32_t v : t) used.vertices.push_back(points[v]);
    const double r_max = largest_vertex_distance(used);
    double side = k_outer_cell * options.tolerance * r_max;
    const Vec3d sides = size(box);
    const auto corners = [&] {
        const double rim = 2 * (0.5 * options.gap * r_max / side + 6);
        return (sides.x / side + rim) * (sides.y / side + rim) * (sides.z / side + rim);
    };
    while (estimated_pairs(soup, side) > double(options.max_cells) || corners() > k_max_dense) side *= 1.1;
    const Vec3d origin = box.lo - side * k_off_planes;
    for (Mesh* m : {&all, &soup})
        for (Vec3d& p : m->vertices) p = (p - origin) / side;
    const double tolerance = options.tolerance * r_max / side;

    const OuterLabels labels = outer_labels(all, options.gap * r_max / side);
    const DualSurface surface = dual_surface(labels.grid, labels.inside);
    const Bvh bvh(soup);
    const Enclosed enclosed(all, k_apart);
    const ClosedMesh fine = shrunk(surface, labels, {soup, bvh, enclosed, k_offset_share * tolerance});
    ClosedMesh closed = coarser(
        fine, bvh, {.max_error = k_outer_error * tolerance, .max_triangles = options.max_triangles, .enclosed = &enclosed});
    const auto to_result = [&](const ClosedMesh& mesh) {
        Mesh out{mesh.vertices, mesh.triangles};
        for (Vec3d& p : out.vertices) p = origin + side * p;
        return out;
    };
    result.mesh = to_result(closed);
    result.made_up = closed.made_up;
    result.cell = side;
    return result;
}

}  // namespace sqmap::mesh
