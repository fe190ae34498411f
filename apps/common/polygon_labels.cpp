#include "common/polygon_labels.h"

#include "sqmap/mesh/bvh.h"

#include <algorithm>
#include <map>

namespace sqmap::app {
namespace {

/// Labels of the triangles nearest to the polygons' centroids.
std::vector<std::int32_t> nearest_labels(const io::PolygonSoup& soup, const mesh::Mesh& mesh,
                                         std::span<const std::uint32_t> label_of_triangle, double unit)
{
    const mesh::Bvh bvh(mesh);
    std::vector<std::int32_t> labels;
    for (std::size_t p = 0; p + 1 < soup.polygon_offsets.size(); ++p) {
        const std::uint32_t first = soup.polygon_offsets[p], end = soup.polygon_offsets[p + 1];
        Vec3d sum{};
        for (std::uint32_t i = first; i < end; ++i) sum += soup.positions[static_cast<std::size_t>(soup.indices[i])];
        const Vec3d centroid = unit / std::max(1.0, static_cast<double>(end - first)) * sum;
        labels.push_back(static_cast<std::int32_t>(label_of_triangle[bvh.closest_point(centroid).triangle]));
    }
    return labels;
}

}  // namespace

std::vector<std::int32_t> polygon_labels(const io::PolygonSoup& soup, const AdmittedMesh& mesh,
                                         std::span<const std::uint32_t> label_of_triangle, double unit)
{
    if (mesh.admission == mesh::Admission::Wrapped) return nearest_labels(soup, mesh.mesh, label_of_triangle, unit);
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> area;  // of a polygon under a label
    for (std::uint32_t t = 0; t < label_of_triangle.size(); ++t)
        if (mesh.source_triangle[t] != mesh::k_no_polygon)
            area[{mesh.source_triangle[t], label_of_triangle[t]}] += mesh::triangle_area(mesh.mesh, t);
    std::vector<std::int32_t> labels(soup.polygon_offsets.size() - 1, -1);
    std::vector<double> largest(labels.size(), -1);
    for (const auto& [key, a] : area) {
        const auto [polygon, label] = key;
        if (a <= largest[polygon]) continue;
        largest[polygon] = a;
        labels[polygon] = static_cast<std::int32_t>(label);
    }
    return labels;
}

}  // namespace sqmap::app
