#include "object.h"

#include "../error.h"
#include "sqmap/bake_mesh.h"
#include "sqmap/model/parse.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

namespace sqmap::bench {

namespace {

constexpr double k_step = 1e-4;        ///< m a tick: 0.1 m/s at 1 kHz
constexpr double k_hand_sigma = 3e-3;  ///< m

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b)
{
    return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

/// Closed outlines as runs of (point, triangle that it leaves through).
struct Corner {
    Vec3d point;
    std::uint32_t triangle;
};

std::vector<Corner> longest_outline(const mesh::Mesh& mesh, Vec3d n, double offset)
{
    // Every crossed triangle has two crossed edges; an outline walks from edge to edge.
    const auto side = [&](std::uint32_t v) { return dot(n, mesh.vertices[v]) - offset; };
    struct Crossed {
        std::uint64_t edge[2];
    };
    std::map<std::uint32_t, Crossed> crossed;
    std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> on_edge;
    std::unordered_map<std::uint64_t, Vec3d> point;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        Crossed c{};
        int k = 0;
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
            const double sa = side(a), sb = side(b);
            if ((sa > 0) == (sb > 0)) continue;
            const std::uint64_t key = edge_key(a, b);
            point[key] = mesh.vertices[a] + (sa / (sa - sb)) * (mesh.vertices[b] - mesh.vertices[a]);
            if (k < 2) c.edge[k++] = key;
        }
        if (k != 2) continue;
        crossed[t] = c;
        for (const std::uint64_t e : c.edge) on_edge[e].push_back(t);
    }
    std::vector<Corner> best;
    double best_length = 0;
    while (!crossed.empty()) {
        std::vector<Corner> run;
        double length = 0;
        std::uint32_t t = crossed.begin()->first;
        std::uint64_t edge = crossed.begin()->second.edge[0];
        for (auto it = crossed.find(t); it != crossed.end(); it = crossed.find(t)) {
            const Crossed c = it->second;
            crossed.erase(it);
            run.push_back({point[edge], t});
            const std::uint64_t next = c.edge[0] == edge ? c.edge[1] : c.edge[0];
            length += norm(point[next] - point[edge]);
            edge = next;
            const auto& sharing = on_edge[edge];
            if (sharing.size() != 2) break;
            t = sharing[0] == t ? sharing[1] : sharing[0];
        }
        if (length > best_length) best_length = length, best = std::move(run);
    }
    return best;
}

}  // namespace

TouchObject::TouchObject(const std::filesystem::path& file, Models models, const paper::MapOptions& maps)
{
    AdmittedMesh admitted = admit_mesh(file);
    if (admitted.refused())
        throw BenchError(file.string() + ": " + admitted.diagnosis.message + "\n  cure: " + admitted.diagnosis.cure.text());
    mesh = std::move(admitted.mesh);
    const double scale = k_object_size / mesh::largest_vertex_distance(mesh);
    for (Vec3d& v : mesh.vertices) v = scale * v;
    solid = std::make_unique<mesh::Solid>(mesh, admitted.crossed);
    const auto bake = [&](const std::optional<paper::MapOptions>& paper_maps, Opened& opened, model::ModelView& view) {
        opened.bytes = bake_mesh(mesh, {.paper_maps = paper_maps}).bytes();
        if (opened.model.parse(opened.bytes) != model::ParseStatus::Ok)
            throw BenchError(file.string() + ": the model does not parse");
        view = opened.model.view();
    };
    if (models != Models::Paper) bake(std::nullopt, central_, central);
    if (models != Models::Central) bake(maps, paper_, paper);

    vertex_normals.resize(mesh.vertices.size());
    std::unordered_map<std::uint64_t, std::uint32_t> first;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& v = mesh.triangles[t];
        face_normals.push_back(
            normalized(cross(mesh.vertices[v[1]] - mesh.vertices[v[0]], mesh.vertices[v[2]] - mesh.vertices[v[0]])));
        for (int i = 0; i < 3; ++i) {  // weighted by the angle at the vertex
            const Vec3d a = normalized(mesh.vertices[v[(i + 1) % 3]] - mesh.vertices[v[i]]),
                        b = normalized(mesh.vertices[v[(i + 2) % 3]] - mesh.vertices[v[i]]);
            vertex_normals[v[i]] += std::acos(std::clamp(dot(a, b), -1., 1.)) * face_normals[t];
        }
    }
    for (Vec3d& n : vertex_normals) n = normalized(n);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
            const auto [it, is_new] = first.emplace(edge_key(a, b), t);
            if (is_new || dot(face_normals[t], face_normals[it->second]) > std::cos(std::acos(-1.) / 4)) continue;
            const auto at = static_cast<std::uint32_t>(sharp_.vertices.size());
            const Vec3d middle = 0.5 * (mesh.vertices[a] + mesh.vertices[b]) - 1e-7 * face_normals[t];
            sharp_.vertices.insert(sharp_.vertices.end(), {mesh.vertices[a], mesh.vertices[b], middle});
            sharp_.triangles.push_back({at, at + 1, at + 2});
        }
    if (!sharp_.triangles.empty()) sharp_bvh_ = std::make_unique<mesh::Bvh>(sharp_);
}

TouchObject::Exact TouchObject::exact(Vec3d p) const
{
    const mesh::ClosestPoint closest = solid->closest_boundary(p);
    Exact e{solid->inside(p) ? -closest.distance : closest.distance,
            face_normals[closest.triangle],
            {},
            closest.point,
            closest.triangle};
    const auto& v = mesh.triangles[closest.triangle];
    const Vec3d a = mesh.vertices[v[0]], ab = mesh.vertices[v[1]] - a, ac = mesh.vertices[v[2]] - a, n = cross(ab, ac);
    const double area = norm_sq(n), s = dot(cross(closest.point - a, ac), n) / area,
                 t = dot(cross(ab, closest.point - a), n) / area;
    e.shaded_normal = normalized((1 - s - t) * vertex_normals[v[0]] + s * vertex_normals[v[1]] + t * vertex_normals[v[2]]);
    return e;
}

bool TouchObject::near_sharp_edge(Vec3d p, double reach) const
{
    return sharp_bvh_ != nullptr && sharp_bvh_->closest_point(p, reach).distance < reach;
}

std::vector<Vec3d> slide_path(const TouchObject& object, Vec3d plane_normal, double plane_offset, double depth)
{
    const std::vector<Corner> outline = longest_outline(object.mesh, plane_normal, plane_offset);
    if (outline.size() < 3) return {};
    // Even samples of the outline with the normals of the faces they lie on.
    std::vector<Vec3d> at, normal;
    double left = 0;
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const Vec3d a = outline[i].point, b = outline[(i + 1) % outline.size()].point;
        const double length = norm(b - a);
        double s = left;
        for (; s < length; s += k_step) {
            at.push_back(a + (s / length) * (b - a));
            normal.push_back(object.face_normals[outline[i].triangle]);
        }
        left = s - length;
    }
    const auto n = static_cast<std::ptrdiff_t>(at.size());
    const auto reach = static_cast<std::ptrdiff_t>(3 * k_hand_sigma / k_step);
    if (n < 2 * reach) return {};
    std::vector<double> kernel;
    for (std::ptrdiff_t j = -reach; j <= reach; ++j) {
        const double u = static_cast<double>(j) * k_step / k_hand_sigma;
        kernel.push_back(std::exp(-0.5 * u * u));
    }
    std::vector<Vec3d> smoothed;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        Vec3d mean{};
        for (std::ptrdiff_t j = -reach; j <= reach; ++j)
            mean += kernel[static_cast<std::size_t>(j + reach)] * normal[static_cast<std::size_t>((i + j + n) % n)];
        smoothed.push_back(at[static_cast<std::size_t>(i)] - depth * normalized(mean));
    }
    // The steps are made even again, since turning about an edge has stretched and pressed them together.
    std::vector<Vec3d> path{smoothed.front()};
    for (std::size_t i = 1; i < smoothed.size(); ++i)
        while (norm(smoothed[i] - path.back()) >= k_step) {
            // Forward along the smoothed curve's own piece.
            const Vec3d a = smoothed[i - 1], d = smoothed[i] - a, to = a - path.back();
            const double dd = norm_sq(d), b = dot(to, d), c = norm_sq(to) - k_step * k_step, root = b * b - dd * c;
            const double s = root > 0 && dd > 0 ? std::clamp((-b + std::sqrt(root)) / dd, 0., 1.) : 1.;
            path.push_back(a + s * d);
            if (s >= 1) break;
        }
    return path;
}

}  // namespace sqmap::bench
