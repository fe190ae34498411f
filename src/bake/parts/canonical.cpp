#include "canonical.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

namespace sqmap::bake {

CanonicalMesh canonical_mesh(const mesh::Mesh& mesh)
{
    CanonicalMesh canonical;
    canonical.frame = mesh::principal_frame(mesh);
    std::vector<std::uint32_t> order(mesh.vertices.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<Vec3d> turned;
    for (const Vec3d& v : mesh.vertices) turned.push_back(canonical.frame * v);
    std::sort(order.begin(), order.end(), [&](std::uint32_t l, std::uint32_t r) {
        return std::tuple(turned[l].x, turned[l].y, turned[l].z, l) < std::tuple(turned[r].x, turned[r].y, turned[r].z, r);
    });
    std::vector<std::uint32_t> rank(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        rank[order[i]] = i;
        canonical.mesh.vertices.push_back(turned[order[i]]);
    }
    for (const mesh::Triangle& t : mesh.triangles) {
        mesh::Triangle r{rank[t[0]], rank[t[1]], rank[t[2]]};
        std::rotate(r.begin(), std::min_element(r.begin(), r.end()), r.end());
        canonical.mesh.triangles.push_back(r);
    }
    return canonical;
}

}  // namespace sqmap::bake
