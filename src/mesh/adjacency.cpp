#include "sqmap/mesh/adjacency.h"

#include <algorithm>
#include <tuple>

namespace sqmap::mesh {

DualGraph dual_graph(const Mesh& mesh)
{
    struct Side {
        std::uint32_t low, high, triangle, corner;
    };
    std::vector<Side> sides;
    sides.reserve(3 * mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::uint32_t e = 0; e < 3; ++e) {
            const std::uint32_t a = mesh.triangles[t][e], b = mesh.triangles[t][(e + 1) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), t, e});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::tie(a.low, a.high, a.triangle, a.corner) < std::tie(b.low, b.high, b.triangle, b.corner);
    });
    DualGraph graph;
    graph.neighbours.assign(mesh.triangles.size(), {k_no_triangle, k_no_triangle, k_no_triangle});
    for (std::size_t i = 0; i + 1 < sides.size();) {
        const Side &a = sides[i], &b = sides[i + 1];
        if (a.low != b.low || a.high != b.high) {
            ++i;
            continue;
        }
        graph.neighbours[a.triangle][a.corner] = b.triangle;
        graph.neighbours[b.triangle][b.corner] = a.triangle;
        i += 2;
    }
    return graph;
}

}  // namespace sqmap::mesh
