// Least-weight cut in a band, after Katz and Tal, "Hierarchical mesh decomposition using fuzzy clustering and cuts",
// SIGGRAPH 2003.
#include "cut.h"

#include "maximum_flow.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace sqmap::decompose {

CutSurface::CutSurface(const mesh::Mesh& m) : mesh(m), graph(mesh::dual_graph(m))
{
    const std::size_t n = mesh.triangles.size();
    area.resize(n);
    std::vector<Vec3d> centre(n), normal(n);
    for (std::uint32_t t = 0; t < n; ++t) {
        area[t] = mesh::triangle_area(mesh, t);
        total_area += area[t];
        centre[t] = mesh::triangle_centroid(mesh, t);
        const mesh::Triangle& tri = mesh.triangles[t];
        normal[t] = 0.5 * cross(mesh.vertices[tri[1]] - mesh.vertices[tri[0]], mesh.vertices[tri[2]] - mesh.vertices[tri[0]]);
    }
    // Normals averaged over the neighbours: concavity should see the shape, not the scanner's noise.
    std::vector<Vec3d> smooth = normal;
    for (std::uint32_t t = 0; t < n; ++t) {
        for (const auto o : graph.neighbours[t])
            if (o != mesh::k_no_triangle) smooth[t] += normal[o];
        smooth[t] = sqmap::normalized(smooth[t]);
    }
    edge_length.assign(n, {});
    edge_concavity.assign(n, {});
    for (std::uint32_t t = 0; t < n; ++t)
        for (int e = 0; e < 3; ++e) {
            edge_length[t][e] = norm(mesh.vertices[mesh.triangles[t][(e + 1) % 3]] - mesh.vertices[mesh.triangles[t][e]]);
            const std::uint32_t o = graph.neighbours[t][e];
            if (o == mesh::k_no_triangle) continue;
            const Vec3d d = centre[o] - centre[t];
            const double angle = std::atan2(norm(cross(smooth[t], smooth[o])), dot(smooth[t], smooth[o]));
            const double length = norm(d);
            if (length > 0 && dot(smooth[t] - smooth[o], d) > 0) edge_concavity[t][e] = angle / length;
        }
}

CutSurface::CutSurface(const mesh::Mesh& m, const CutSurface& whole, std::span<const std::uint32_t> triangles) : mesh(m)
{
    for (const std::uint32_t t : triangles) {
        area.push_back(whole.area[t]);
        total_area += whole.area[t];
        edge_length.push_back(whole.edge_length[t]);
        edge_concavity.push_back(whole.edge_concavity[t]);
        std::array<std::uint32_t, 3>& neighbours = graph.neighbours.emplace_back(whole.graph.neighbours[t]);
        for (std::uint32_t& o : neighbours) {
            const auto it = std::lower_bound(triangles.begin(), triangles.end(), o);
            o = it != triangles.end() && *it == o ? static_cast<std::uint32_t>(it - triangles.begin()) : mesh::k_no_triangle;
        }
    }
}

namespace {

/// Triangles of a mesh as one of their own.
mesh::Mesh mesh_of(const mesh::Mesh& whole, std::span<const std::uint32_t> triangles)
{
    std::vector<std::uint32_t> number(whole.vertices.size(), 0);
    for (const std::uint32_t t : triangles)
        for (const std::uint32_t v : whole.triangles[t]) number[v] = 1;
    mesh::Mesh part;
    for (std::uint32_t v = 0; v < number.size(); ++v) {
        if (number[v] == 0) continue;
        number[v] = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back(whole.vertices[v]);
    }
    for (const std::uint32_t t : triangles) {
        const mesh::Triangle& corners = whole.triangles[t];
        part.triangles.push_back({number[corners[0]], number[corners[1]], number[corners[2]]});
    }
    return part;
}

}  // namespace

PartSurface::PartSurface(const CutSurface& whole, std::span<const std::uint32_t> triangles)
    : mesh_(mesh_of(whole.mesh, triangles)), surface_(mesh_, whole, triangles)
{
}

std::vector<std::uint8_t> best_cut(const CutSurface& s, std::span<const std::uint32_t> triangles, std::span<const double> field,
                                   const CutBand& at)
{
    constexpr std::uint32_t k_outside = mesh::k_no_triangle, k_source = 0, k_sink = 1;
    std::vector<std::uint32_t> node(s.mesh.triangles.size(), k_outside);
    std::uint32_t count = 2;
    for (const auto t : triangles)
        node[t] = field[t] <= at.level - at.band ? k_source : (field[t] >= at.level + at.band ? k_sink : count++);
    MaximumFlow flow(count);
    double longest = 0;
    for (const auto t : triangles) {
        if (node[t] < 2) continue;
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t o = s.graph.neighbours[t][e];
            if (o == mesh::k_no_triangle || node[o] == k_outside) continue;
            if (node[o] >= 2 && o < t) continue;
            const double weight = s.edge_length[t][e] / (1 + at.radius * s.edge_concavity[t][e]);
            longest = std::max(longest, weight);
            flow.add_edge(node[t], node[o], weight, weight);
        }
    }
    const auto near = flow.source_side(k_source, k_sink, 1e-12 * longest);
    std::vector<std::uint8_t> side(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) side[i] = near[node[triangles[i]]];
    return side;
}

double mean_concavity(const CutSurface& s, std::span<const std::uint32_t> triangles, const std::vector<std::uint8_t>& near,
                      double radius)
{
    std::vector<std::uint8_t> side(s.area.size(), 2);
    for (std::size_t i = 0; i < triangles.size(); ++i) side[triangles[i]] = near[i];
    double length = 0, concave = 0;
    for (const auto t : triangles)
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t o = s.graph.neighbours[t][e];
            if (o == mesh::k_no_triangle || side[o] == 2 || side[o] == side[t]) continue;
            length += s.edge_length[t][e];
            concave += s.edge_length[t][e] * std::min(1.0, radius * s.edge_concavity[t][e]);
        }
    return length > 0 ? concave / length : 0.0;
}

double ellipsoid_volume(const CutSurface& s, std::span<const std::uint32_t> triangles)
{
    const mesh::Mesh& mesh = s.mesh;
    double total = 0;
    Vec3d mean{};
    for (const auto t : triangles) {
        const double w = s.area[t];
        total += w;
        mean += w * mesh::triangle_centroid(mesh, t);
    }
    if (total <= 0) return 0;
    mean = mean / total;
    double c[6] = {};  // xx xy xz yy yz zz
    const auto add = [&](double w, Vec3d v) {
        c[0] += w * v.x * v.x, c[1] += w * v.x * v.y, c[2] += w * v.x * v.z;
        c[3] += w * v.y * v.y, c[4] += w * v.y * v.z, c[5] += w * v.z * v.z;
    };
    for (const auto t : triangles) {
        const double w = s.area[t] / (12 * total);
        Vec3d sum{};
        for (const auto v : mesh.triangles[t]) {
            add(w, mesh.vertices[v] - mean);
            sum += mesh.vertices[v] - mean;
        }
        add(w, sum);
    }
    // A flat patch has no volume: thicken by a small share of its extent, so that flat parts still compare.
    const double thin = 1e-3 * (c[0] + c[3] + c[5]);
    c[0] += thin, c[3] += thin, c[5] += thin;
    const double i00 = c[3] * c[5] - c[4] * c[4], i01 = c[2] * c[4] - c[1] * c[5], i02 = c[1] * c[4] - c[2] * c[3];
    const double det = c[0] * i00 + c[1] * i01 + c[2] * i02;
    if (det <= 0) return 0;
    const double i11 = c[0] * c[5] - c[2] * c[2], i12 = c[1] * c[2] - c[0] * c[4], i22 = c[0] * c[3] - c[1] * c[1];
    double farthest = 0;
    for (const auto t : triangles)
        for (const auto v : mesh.triangles[t]) {
            const Vec3d p = mesh.vertices[v] - mean;
            const double m =
                i00 * p.x * p.x + i11 * p.y * p.y + i22 * p.z * p.z + 2 * (i01 * p.x * p.y + i02 * p.x * p.z + i12 * p.y * p.z);
            farthest = std::max(farthest, m);
        }
    return std::sqrt(det) * std::pow(farthest / det, 1.5);
}

std::vector<std::uint32_t> all_triangles(const CutSurface& s)
{
    std::vector<std::uint32_t> all(s.area.size());
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

}  // namespace sqmap::decompose
