#include "part.h"

#include <utility>

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

}  // namespace sqmap::bake
