// Parts of a mesh that is turned, scaled, reflected, or has 30 % fewer triangles: the share of the area on which they are those
// of the mesh as it is. CGAL's simplification is GPL: it is used by this bench and by nothing that is shipped.
#include "measure.h"

#include "math/random.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/model/named_parts.h"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_ratio_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

namespace {

using namespace sqmap;
using Labels = std::vector<std::uint32_t>;  ///< #triangles

constexpr std::uint32_t k_no_label = 0xffffffff;

struct Parts {
    Labels parts, groups;
};

/// Parts and named parts of each triangle of the input.
Parts parts_of(const mesh::Mesh& input)
{
    BakeMeshOptions options;
    options.bake.locator = options.bake.exact = false;  // parts alone count
    options.bake.target_error = 100;
    const BakedModel baked = bake_mesh(input, options);
    Parts out{Labels(input.triangles.size(), k_no_label), Labels(input.triangles.size(), k_no_label)};
    for (std::size_t t = 0; t < baked.mesh.source_triangle.size(); ++t) {
        const auto source = baked.mesh.source_triangle[t];
        if (source >= input.triangles.size()) continue;
        out.parts[source] = baked.report.partition.part_of_triangle[t];
        out.groups[source] = model::group_of_part(baked.view(), out.parts[source]);
    }
    return out;
}

/// Labels of another mesh of the same surface, read at the middle of each triangle.
Labels carried(const mesh::Mesh& from, const Labels& labels, const mesh::Mesh& to)
{
    const mesh::Bvh tree(from);
    Labels out;
    for (std::uint32_t t = 0; t < to.triangles.size(); ++t)
        out.push_back(labels[tree.closest_point(mesh::triangle_centroid(to, t)).triangle]);
    return out;
}

/// Share of the area on which both agree, when each label of one stands for at most one of the other: largest overlaps first.
double agreement(const mesh::Mesh& mesh, const Labels& a, const Labels& b)
{
    std::map<std::pair<std::uint32_t, std::uint32_t>, double> shared;
    double total = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const double area = mesh::triangle_area(mesh, t);
        total += area;
        if (a[t] != k_no_label && b[t] != k_no_label) shared[{a[t], b[t]}] += area;
    }
    std::vector<std::pair<double, std::pair<std::uint32_t, std::uint32_t>>> order;
    for (const auto& [labels, area] : shared) order.emplace_back(area, labels);
    std::sort(order.rbegin(), order.rend());
    std::map<std::uint32_t, bool> used_a, used_b;
    double same = 0;
    for (const auto& [area, labels] : order) {
        if (used_a[labels.first] || used_b[labels.second]) continue;
        used_a[labels.first] = used_b[labels.second] = true;
        same += area;
    }
    return same / total;
}

mesh::Mesh moved(mesh::Mesh mesh, const std::function<Vec3d(Vec3d)>& to)
{
    for (Vec3d& p : mesh.vertices) p = to(p);
    return mesh;
}

mesh::Mesh reflected(const mesh::Mesh& input)
{
    mesh::Mesh out = moved(input, [](Vec3d p) { return Vec3d{-p.x, p.y, p.z}; });
    for (mesh::Triangle& t : out.triangles) std::swap(t[1], t[2]);
    return out;
}

/// Turned by a rotation that no axis of the mesh knows.
Vec3d turned(Vec3d p)
{
    constexpr double k_w = 0.5, k_x = 0.1, k_y = 0.7, k_z = 0.5;  // a quaternion of length one
    const Vec3d axis{k_x, k_y, k_z}, once = cross(axis, p);
    return p + 2 * k_w * once + 2.0 * cross(axis, once);
}

mesh::Mesh simplified(const mesh::Mesh& input, double share)
{
    using Surface = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;
    Surface surface;
    for (const Vec3d& p : input.vertices) surface.add_vertex({p.x, p.y, p.z});
    using Index = Surface::Vertex_index;
    for (const mesh::Triangle& t : input.triangles)
        if (surface.add_face(Index(t[0]), Index(t[1]), Index(t[2])) == Surface::null_face())
            throw std::runtime_error("the mesh is not manifold");
    CGAL::Surface_mesh_simplification::Count_ratio_stop_predicate<Surface> stop(share);
    CGAL::Surface_mesh_simplification::edge_collapse(surface, stop);
    surface.collect_garbage();
    mesh::Mesh out;
    for (const auto v : surface.vertices()) {
        const auto& p = surface.point(v);
        out.vertices.push_back({p.x(), p.y(), p.z()});
    }
    for (const auto f : surface.faces()) {
        mesh::Triangle triangle{};
        std::size_t k = 0;
        for (const auto v : vertices_around_face(surface.halfedge(f), surface)) triangle[k++] = static_cast<std::uint32_t>(v);
        out.triangles.push_back(triangle);
    }
    return out;
}

/// Shares of the area on which parts, and named parts, agree.
struct Agreement {
    double parts = 0, groups = 0;
};

Agreement agreement_of(const mesh::Mesh& mesh, const Parts& own, const Parts& other)
{
    return {agreement(mesh, own.parts, other.parts), agreement(mesh, own.groups, other.groups)};
}

}  // namespace

int sqmap::bench::measure_invariance(int argc, char** argv)
{
    if (argc < 2) return k_wrong_usage;
    std::puts(
        "| mesh | rotation: parts | named | scale: parts | named | reflection: parts | named | 30 % fewer: parts | named |");
    std::puts("|---|---:|---:|---:|---:|---:|---:|---:|---:|");
    for (int i = 1; i < argc; ++i) {
        const std::filesystem::path path = argv[i];
        const AdmittedMesh admitted = admit_mesh(path);
        if (admitted.refused()) throw mesh::RefusedMesh(admitted.diagnosis);
        const mesh::Mesh& mesh = admitted.mesh;
        const Parts own = parts_of(mesh);
        const mesh::Mesh coarse = simplified(mesh, 0.7);
        const Parts of_coarse = parts_of(coarse);
        const std::array<Agreement, 4> found{
            agreement_of(mesh, own, parts_of(moved(mesh, turned))),
            agreement_of(mesh, own, parts_of(moved(mesh, [](Vec3d p) { return 3.7 * p; }))),
            agreement_of(mesh, own, parts_of(reflected(mesh))),
            agreement_of(mesh, own, {carried(coarse, of_coarse.parts, mesh), carried(coarse, of_coarse.groups, mesh)})};
        std::printf("| %s |", path.stem().string().c_str());
        for (const Agreement& a : found) std::printf(" %.1f | %.1f |", 100 * a.parts, 100 * a.groups);
        std::puts("");
        std::fflush(stdout);
    }
    return 0;
}
