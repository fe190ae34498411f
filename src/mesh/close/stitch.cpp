// After G. Barequet and S. Kumar, "Repairing CAD models", 1997, with vertices before edges and near before far.
#include "steps.h"

#include "sqmap/mesh/bvh.h"

#include <cmath>
#include <numeric>
#include <utility>

namespace sqmap::mesh {
namespace {

constexpr int k_split_passes = 4;  // a face whose sides are split is split again

struct OpenEdges {
    std::vector<EdgeUse> edges;
    std::vector<std::uint32_t> vertices;  ///< ascending
    std::size_t too_many = 0;             ///< edges of more than two faces
};

OpenEdges open_edges_of(const Surface& surface)
{
    OpenEdges out;
    for_each_edge(edge_uses(surface.faces), [&](std::span<const EdgeUse> edge) {
        if (edge.size() > 2) ++out.too_many;
        if (edge.size() != 1) return;
        out.edges.push_back(edge[0]);
        out.vertices.push_back(edge[0].lo);
        out.vertices.push_back(edge[0].hi);
    });
    std::sort(out.vertices.begin(), out.vertices.end());
    out.vertices.erase(std::unique(out.vertices.begin(), out.vertices.end()), out.vertices.end());
    return out;
}

void join_vertices(Surface& surface, const OpenEdges& boundary, double tolerance)
{
    std::vector<Vec3d> points;
    for (const std::uint32_t v : boundary.vertices) points.push_back(surface.points[v] - surface.points[boundary.vertices[0]]);
    const std::vector<std::uint32_t> first = coincident_within(points, tolerance);
    std::vector<std::uint32_t> to(surface.points.size());
    std::iota(to.begin(), to.end(), 0u);
    for (std::size_t i = 0; i < first.size(); ++i) to[boundary.vertices[i]] = boundary.vertices[first[i]];
    for (Face& f : surface.faces)
        for (std::uint32_t& v : f.v) v = to[v];
    std::erase_if(surface.faces, [](const Face& f) { return f.v[0] == f.v[1] || f.v[1] == f.v[2] || f.v[2] == f.v[0]; });
}

/// Gives each edge with vertices on it the nearest of them. True if an edge has one.
bool split_edges(Surface& surface, const OpenEdges& boundary, double tolerance)
{
    // Edges as triangles without width.
    Mesh edges{surface.points, {}};
    for (const EdgeUse& u : boundary.edges) edges.triangles.push_back({u.lo, u.hi, u.hi});
    std::vector<std::vector<std::uint32_t>> beside(surface.points.size());
    for (const EdgeUse& u : boundary.edges) {
        beside[u.lo].push_back(u.hi);
        beside[u.hi].push_back(u.lo);
    }
    const auto distance = [&](std::uint32_t v, const EdgeUse& u) {
        const Vec3d a = surface.points[u.lo], side = surface.points[u.hi] - a, p = surface.points[v] - a;
        const double t = std::clamp(dot(p, side) / norm_sq(side), 0.0, 1.0);
        return norm(p - t * side);
    };
    const Bvh bvh(edges);
    std::vector<std::pair<double, std::uint32_t>> nearest(boundary.edges.size(), {tolerance, k_none});
    for (const std::uint32_t v : boundary.vertices)
        bvh.visit_nearest(surface.points[v], 1.0001 * tolerance * tolerance, [&](std::uint32_t e, double radius_sq) {
            const EdgeUse& u = boundary.edges[e];
            const Triangle& face = surface.faces[u.half / 3].v;
            if (std::find(face.begin(), face.end(), v) != face.end()) return radius_sq;
            const double ends =
                std::min(norm(surface.points[v] - surface.points[u.lo]), norm(surface.points[v] - surface.points[u.hi]));
            if (ends <= tolerance) return radius_sq;  // for joining vertices
            // The boundary runs on along the edge from here, or it only touches the edge.
            const bool goes_on = std::any_of(beside[v].begin(), beside[v].end(), [&](std::uint32_t w) {
                return w == u.lo || w == u.hi || distance(w, u) <= tolerance;
            });
            if (goes_on) nearest[e] = std::min(nearest[e], {distance(v, u), v});
            return radius_sq;
        });
    std::vector<bool> touched(surface.faces.size(), false);
    bool any = false;
    for (std::size_t e = 0; e < nearest.size(); ++e) {
        const std::uint32_t v = nearest[e].second, half = boundary.edges[e].half, f = half / 3;
        if (v == k_none || touched[f]) continue;
        const Triangle t = surface.faces[f].v;
        const std::uint32_t k = half % 3;
        surface.faces[f].v = {t[k], v, t[(k + 2) % 3]};
        surface.faces.push_back({{v, t[(k + 1) % 3], t[(k + 2) % 3]}, surface.faces[f].polygon});
        touched[f] = true;
        any = true;
    }
    return any;
}

/// Number of edges that are not between two faces: less is better.
std::size_t faults(const OpenEdges& boundary) { return boundary.edges.size() + 3 * boundary.too_many; }

}  // namespace

std::uint64_t stitch(Surface& surface, double tolerance)
{
    OpenEdges boundary = open_edges_of(surface);
    const std::size_t before = boundary.edges.size();
    const auto attempt = [&](auto change) {
        const std::vector<Face> faces = surface.faces;
        change();
        OpenEdges after = open_edges_of(surface);
        if (faults(after) < faults(boundary))
            boundary = std::move(after);
        else
            surface.faces = faces;
    };
    for (const double step : {1e-3, 1e-2, 0.1, 0.3, 1.0}) {
        if (boundary.edges.empty()) break;
        attempt([&] { join_vertices(surface, boundary, step * tolerance); });
        if (boundary.edges.empty()) break;
        attempt([&] {
            OpenEdges now = boundary;
            for (int pass = 0; pass < k_split_passes && split_edges(surface, now, step * tolerance); ++pass)
                now = open_edges_of(surface);
        });
    }
    return before - std::min(before, boundary.edges.size());
}

}  // namespace sqmap::mesh
