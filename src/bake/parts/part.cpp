#include "part.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

namespace sqmap::bake {

std::vector<Patch> patches_of(const mesh::Mesh& mesh, const decompose::Partition& partition)
{
    std::vector<Patch> patches(partition.part_count);
    for (std::uint32_t t = 0; t < partition.part_of_triangle.size(); ++t)
        patches[partition.part_of_triangle[t]].triangles.push_back(t);
    std::vector<std::vector<CapTriangle>> caps = cap_parts(mesh, partition);
    for (std::size_t i = 0; i < patches.size(); ++i) patches[i].caps = std::move(caps[i]);
    return patches;
}

std::vector<Vec3d> corners_of(const mesh::Mesh& mesh, const Patch& patch)
{
    std::vector<Vec3d> points;
    for (const std::uint32_t t : patch.triangles)
        for (const std::uint32_t v : mesh.triangles[t]) points.push_back(mesh.vertices[v]);
    for (const CapTriangle& t : patch.caps) points.insert(points.end(), t.begin(), t.end());
    return points;
}

double enclosed_volume(const mesh::Mesh& mesh, const Patch& patch)
{
    double six = 0;
    const auto add = [&](Vec3d a, Vec3d b, Vec3d c) { six += dot(a, cross(b, c)); };
    for (const std::uint32_t t : patch.triangles) {
        const mesh::Triangle& tri = mesh.triangles[t];
        add(mesh.vertices[tri[0]], mesh.vertices[tri[1]], mesh.vertices[tri[2]]);
    }
    for (const CapTriangle& t : patch.caps) add(t[0], t[1], t[2]);
    return six / 6;
}

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
