#include "sqmap/mesh/solid.h"

#include "math/triangle.h"
#include "math/union_find.h"
#include "pieces.h"
#include "sqmap/mesh/error.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

namespace sqmap::mesh {

namespace {

/// True if every side of a triangle is the side of another, the other way round.
bool is_closed(const Mesh& mesh)
{
    std::vector<std::pair<std::uint32_t, std::uint32_t>> sides, backwards;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            sides.emplace_back(t[k], t[(k + 1) % 3]);
            backwards.emplace_back(t[(k + 1) % 3], t[k]);
        }
    std::sort(sides.begin(), sides.end());
    std::sort(backwards.begin(), backwards.end());
    return sides == backwards;
}

}  // namespace

Solid::Solid(const Mesh& mesh, std::span<const std::uint8_t> crossed)
    : mesh_(mesh), bvh_(mesh), boundary_(mesh.triangles.size(), Boundary::Whole), step_(1e-10 * largest_vertex_distance(mesh))
{
    self_intersecting_ = std::any_of(crossed.begin(), crossed.end(), [](std::uint8_t c) { return c != 0; });
    if (self_intersecting_)
        find_pieces(crossed);
    else
        find_buried_shells();
    all_boundary_ = std::all_of(boundary_.begin(), boundary_.end(), [](Boundary b) { return b == Boundary::Whole; });
}

/// A shell that nothing cuts is boundary as a whole or, within another's solid, not at all. A single shell is boundary; a surface
/// that bounds nothing is kept whole.
void Solid::find_buried_shells()
{
    const std::size_t count = mesh_.vertices.size();
    UnionFind shells(count);
    for (const Triangle& t : mesh_.triangles)
        for (int k = 1; k < 3; ++k) shells.unite(t[0], t[static_cast<std::size_t>(k)]);
    const std::uint32_t first = mesh_.triangles.empty() ? 0 : shells.find(mesh_.triangles[0][0]);
    const bool several = std::any_of(mesh_.triangles.begin(), mesh_.triangles.end(),
                                     [&](const Triangle& t) { return shells.find(t[0]) != first; });
    if (!several || !is_closed(mesh_)) return;
    // A shell's largest triangle decides: a sliver's normal and middle say little.
    std::vector<std::uint32_t> largest(count, 0);
    std::vector<double> area(count, -1);
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
        const std::uint32_t shell = shells.find(mesh_.triangles[i][0]);
        const double own = triangle_area(mesh_, i);
        if (own > area[shell]) {
            area[shell] = own;
            largest[shell] = i;
        }
    }
    std::vector<Boundary> of_shell(count, Boundary::Whole);
    for (std::uint32_t shell = 0; shell < count; ++shell) {
        std::optional<Known> none;
        if (area[shell] >= 0 && !is_boundary(triangle_centroid(mesh_, largest[shell]), largest[shell], none))
            of_shell[shell] = Boundary::Buried;
    }
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) boundary_[i] = of_shell[shells.find(mesh_.triangles[i][0])];
}

void Solid::find_pieces(std::span<const std::uint8_t> crossed)
{
    std::vector<std::uint32_t> near;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
        first_piece_.push_back(static_cast<std::uint32_t>(pieces_.size()));
        const Vec3d middle = triangle_centroid(mesh_, t);
        std::optional<Known> known;
        if (crossed[t] == 0) {
            if (!is_boundary(middle, t, known)) boundary_[t] = Boundary::Buried;
            continue;
        }
        double radius_sq = 0;
        for (const std::uint32_t v : mesh_.triangles[t]) radius_sq = std::max(radius_sq, norm_sq(mesh_.vertices[v] - middle));
        near.clear();
        bvh_.visit_nearest(middle, 1.0001 * radius_sq, [&](std::uint32_t other, double sq) {
            if (other != t && crossed[other] != 0) near.push_back(other);
            return sq;
        });
        const auto pieces = pieces_of(mesh_, t, near, 0.01 * step_);
        if (!pieces)
            throw InvalidInput("triangle " + std::to_string(t) +
                               " is cut into thousands of pieces by others: resolve the self-intersections first");
        std::copy_if(pieces->begin(), pieces->end(), std::back_inserter(pieces_),
                     [&](const auto& p) { return is_boundary((p[0] + p[1] + p[2]) / 3.0, t, known); });
        boundary_[t] = pieces_.size() > first_piece_.back() ? Boundary::Partly : Boundary::Buried;
    }
    first_piece_.push_back(static_cast<std::uint32_t>(pieces_.size()));
}

bool Solid::is_boundary(Vec3d p, std::uint32_t triangle, std::optional<Known>& known) const
{
    const Triangle& t = mesh_.triangles[triangle];
    const Vec3d a = mesh_.vertices[t[0]];
    const Vec3d n = normalized(cross(mesh_.vertices[t[1]] - a, mesh_.vertices[t[2]] - a));
    // A ray across all of the mesh is cast once a triangle: the line from a known point is short.
    const auto winding_at = [&](Vec3d q) {
        const std::optional<int> change = known ? bvh_.winding_change(known->point, q) : std::nullopt;
        return change ? known->winding + *change : bvh_.winding_number(q);
    };
    const Vec3d below = p - step_ * n;
    known = {below, winding_at(below)};
    return known->winding > 0 && winding_at(p + step_ * n) <= 0;
}

ClosestPoint Solid::closest_boundary(Vec3d p, double within) const
{
    if (all_boundary_) return bvh_.closest_point(p, within);
    ClosestPoint best;
    best.distance = within;
    bvh_.visit_nearest(p, within * within, [&](std::uint32_t t, double radius_sq) {
        const auto offer = [&](Vec3d a, Vec3d b, Vec3d c) {
            const Vec3d q = closest_point_on_triangle(p, a, b, c);
            const double distance_sq = norm_sq(q - p);
            if (distance_sq >= radius_sq) return;
            best = {q, t, std::sqrt(distance_sq)};
            radius_sq = distance_sq;
        };
        if (boundary_[t] == Boundary::Whole) {
            const Triangle& tri = mesh_.triangles[t];
            offer(mesh_.vertices[tri[0]], mesh_.vertices[tri[1]], mesh_.vertices[tri[2]]);
        } else if (boundary_[t] == Boundary::Partly) {
            for (const auto& piece : visible(t)) offer(piece[0], piece[1], piece[2]);
        }
        return radius_sq;
    });
    return best;
}

}  // namespace sqmap::mesh
