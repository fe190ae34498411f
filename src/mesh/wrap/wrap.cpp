// Jacobson, Kavan, Sorkine-Hornung 2013 for inside and outside, dual marching cubes for the surface.
#include "sqmap/mesh/wrap.h"

#include "grid.h"
#include "steps.h"
#include "winding.h"

#include "sqmap/math/box.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/error.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

namespace sqmap::mesh {

namespace {

constexpr double k_cell = 2;           ///< side of a cell, in tolerances
constexpr double k_decimation = 0.25;  ///< error of the decimation, in tolerances
constexpr double k_finer = 0.9;        ///< of the tolerance that would just have been enough
constexpr double k_crumb = 2;          ///< cells: diagonal of pieces that are left out

/// Shift of the grid, so that no face at a round coordinate lies in a plane of it.
constexpr Vec3d k_offset{0.3819660113, 0.4142135624, 0.4721359550};

void check(const WrapOptions& options, std::size_t triangles)
{
    if (!(options.tolerance > 0 && options.tolerance <= 0.1)) throw InvalidInput("WrapOptions::tolerance is not in (0, 0.1]");
    if (!(options.thickness > 0 && options.thickness <= 2 * options.tolerance))
        throw InvalidInput("WrapOptions::thickness is not in (0, 2 tolerance]");
    if (options.max_triangles < 100) throw InvalidInput("WrapOptions::max_triangles is below 100");
    if (options.max_cells < 10'000) throw InvalidInput("WrapOptions::max_cells is below 10,000");
    if (triangles > options.max_cells / 2)
        throw RefusedMesh({Refusal::Limit, "mesh", std::to_string(triangles) + " triangles are too many to wrap",
                           Words("raise the limit of cells above twice that with ", Setting::MaxCells)});
}

/// The triangles with area, without vertices that none uses.
Mesh soup_of(std::span<const Vec3d> points, std::span<const Triangle> triangles)
{
    Mesh soup;
    std::vector<std::uint32_t> number(points.size(), KeyTable::k_absent);
    for (Triangle t : triangles) {
        if (norm_sq(cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]])) == 0) continue;
        for (std::uint32_t& v : t) {
            if (number[v] == KeyTable::k_absent) {
                number[v] = static_cast<std::uint32_t>(soup.vertices.size());
                soup.vertices.push_back(points[v]);
            }
            v = number[v];
        }
        soup.triangles.push_back(t);
    }
    return soup;
}

/// The side that the tolerance allows, or a larger one with which the grid has no more cells than the options allow.
double cell_side(const Mesh& soup, double largest_distance, const WrapOptions& options)
{
    double side = k_cell * options.tolerance * largest_distance;
    while (estimated_pairs(soup, side) > double(options.max_cells)) side *= 1.1;
    return side;
}

/// Flags of triangles all of whose samples are near the input fall.
void settle_flags(ClosedMesh& mesh, const Bvh& bvh, double tolerance)
{
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!mesh.made_up[t]) continue;
        const auto& [i, j, k] = mesh.triangles[t];
        const Vec3d a = mesh.vertices[i], b = mesh.vertices[j], c = mesh.vertices[k];
        const Vec3d samples[] = {(a + b + c) / 3.0, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), a, b, c};
        mesh.made_up[t] = std::any_of(std::begin(samples), std::end(samples),
                                      [&](Vec3d p) { return !(bvh.closest_point(p, tolerance).distance < tolerance); });
    }
}

/// In the order of canonicalized(), flags with their triangles.
void set_canonical(const ClosedMesh& closed, WrapResult& result)
{
    struct Flagged {
        Triangle t;
        std::uint8_t made_up;
    };
    const auto n = static_cast<std::uint32_t>(closed.vertices.size());
    std::vector<std::uint32_t> order(n), rank(n);
    for (std::uint32_t i = 0; i < n; ++i) order[i] = i;
    const auto key = [&](std::uint32_t i) {
        const Vec3d& v = closed.vertices[i];
        return std::tuple(v.x, v.y, v.z, i);
    };
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    for (std::uint32_t i = 0; i < n; ++i) {
        rank[order[i]] = i;
        result.mesh.vertices.push_back(closed.vertices[order[i]]);
    }
    std::vector<Flagged> triangles;
    for (std::size_t i = 0; i < closed.triangles.size(); ++i) {
        Triangle t;
        for (int k = 0; k < 3; ++k) t[k] = rank[closed.triangles[i][k]];
        std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
        triangles.push_back({t, closed.made_up[i]});
    }
    std::sort(triangles.begin(), triangles.end(), [](const Flagged& a, const Flagged& b) { return a.t < b.t; });
    for (const Flagged& f : triangles) {
        result.mesh.triangles.push_back(f.t);
        result.made_up.push_back(f.made_up);
    }
}

/// soup: with a triangle at least.
WrapResult wrapped(Mesh soup, double largest_distance, const WrapOptions& options)
{
    WrapResult result;
    const double side = cell_side(soup, largest_distance, options);
    const Vec3d origin = box_of(soup.vertices).lo - side * k_offset;
    for (Vec3d& p : soup.vertices) p = (p - origin) / side;

    const double tolerance = options.tolerance * largest_distance / side, thickness = options.thickness * largest_distance / side;
    const WindingNumber winding(soup);
    Grid grid = make_grid(soup);
    const Bvh bvh(soup);
    const Source source{soup, bvh, winding, thickness};
    const Labels labels = label_corners(grid, source);
    const DualSurface surface = dual_surface(grid, labels.inside);
    const Positions positions = positions_of(surface, {source, grid, labels});
    ClosedMesh closed = triangulated(surface, positions);
    drop_crumbs(closed, k_crumb);
    const double error = decimate(closed, bvh, {.max_error = k_decimation * tolerance, .max_triangles = options.max_triangles});
    settle_flags(closed, bvh, tolerance);

    for (Vec3d& p : closed.vertices) p = origin + side * p;
    set_canonical(closed, result);
    result.cell = side;
    result.thickness = positions.has_shells ? options.thickness * largest_distance : 0;
    result.bound = error * side;
    return result;
}

}  // namespace

WrapResult wrap(std::span<const Vec3d> points, std::span<const Triangle> triangles, const WrapOptions& options)
{
    check(options, triangles.size());
    const Mesh soup = soup_of(points, triangles);
    if (soup.triangles.empty()) return {};
    const double largest_distance = largest_vertex_distance(soup);
    const auto attempt = [&](const WrapOptions& o) {
        WrapResult result = wrapped(soup, largest_distance, o);
        if (!result.mesh.triangles.empty()) result.moved = bounding_distances(soup, result.mesh);
        return result;
    };
    WrapResult result = attempt(options);
    const double target = options.tolerance * largest_distance, reached = result.moved.p99;
    if (reached > target && result.mesh.triangles.size() < options.max_triangles) {
        WrapOptions finer = options;
        finer.tolerance = std::max(k_finer * options.tolerance * target / reached, 0.5 * options.thickness);
        WrapResult second = attempt(finer);
        if (second.moved.p99 < reached) result = std::move(second);
    }
    return result;
}

}  // namespace sqmap::mesh
