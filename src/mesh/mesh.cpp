#include "sqmap/mesh/mesh.h"
#include "sqmap/math/box.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <tuple>

namespace sqmap::mesh {

Mesh canonicalized(const Mesh& mesh)
{
    const auto key = [&](std::uint32_t v) { return std::tuple(mesh.vertices[v].x, mesh.vertices[v].y, mesh.vertices[v].z, v); };
    std::vector<std::uint32_t> order(mesh.vertices.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](auto u, auto v) { return key(u) < key(v); });

    Mesh out;
    out.vertices.reserve(order.size());
    std::vector<std::uint32_t> rank(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) {
        rank[order[i]] = i;
        out.vertices.push_back(mesh.vertices[order[i]]);
    }
    out.triangles.reserve(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles) {
        Triangle r{rank[t[0]], rank[t[1]], rank[t[2]]};
        std::rotate(r.begin(), std::min_element(r.begin(), r.end()), r.end());
        out.triangles.push_back(r);
    }
    std::sort(out.triangles.begin(), out.triangles.end());
    return out;
}

std::uint64_t content_hash(const Mesh& mesh)
{
    std::uint64_t hash = 0xcbf29ce484222325ull;
    const auto add = [&](std::uint64_t word) {
        hash = (hash ^ word) * 0x100000001b3ull;
        hash ^= hash >> 29;
    };
    add(mesh.vertices.size());
    for (const Vec3d& p : mesh.vertices)
        for (int k = 0; k < 3; ++k) {
            const double value = p[k];
            std::uint64_t bits = 0;
            std::memcpy(&bits, &value, sizeof(bits));
            add(bits);
        }
    add(mesh.triangles.size());
    for (const Triangle& t : mesh.triangles)
        for (const std::uint32_t v : t) add(v);
    return hash == 0 ? 1 : hash;
}

Normalization normalization_of(const Mesh& mesh)
{
    // Relative to the first vertex: coordinates may sit far from zero, where squares would lose every digit.
    const Vec3d base = mesh.vertices.front();
    double area = 0;
    Vec3d sum{};
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const double w = triangle_area(mesh, t);
        area += w;
        sum += w * (triangle_centroid(mesh, t) - base);
    }
    const Vec3d mean = sum / area;
    double second = 0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a = mesh.vertices[t[0]] - base - mean, b = mesh.vertices[t[1]] - base - mean,
                    c = mesh.vertices[t[2]] - base - mean;
        // Integral of |x|^2 over a triangle: area/12 (|a|^2 + |b|^2 + |c|^2 + |a + b + c|^2).
        const double w = 0.5 * norm(cross(b - a, c - a));
        second += w / 12.0 * (norm_sq(a) + norm_sq(b) + norm_sq(c) + norm_sq(a + b + c));
    }
    return {base + mean, std::sqrt(second / area)};
}

Mesh normalized(const Mesh& mesh, const Normalization& n)
{
    Mesh out = mesh;
    for (Vec3d& v : out.vertices) v = (v - n.origin) / n.unit;
    return out;
}

Mat3d principal_frame(const Mesh& mesh)
{
    // Each triangle by its centroid: enough to tell directions apart.
    const Vec3d origin = normalization_of(mesh).origin;
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    const auto each = [&](auto&& visit) {
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const Vec3d c = triangle_centroid(mesh, t) - origin;
            visit(triangle_area(mesh, t), Eigen::Vector3d(c.x, c.y, c.z));
        }
    };
    each([&](double area, const Eigen::Vector3d& c) { second += area * c * c.transpose(); });
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(second);
    Eigen::Vector3d axes[3] = {solver.eigenvectors().col(2), solver.eigenvectors().col(1), Eigen::Vector3d::Zero()};
    for (int k = 0; k < 2; ++k) {
        double third = 0;
        each([&](double area, const Eigen::Vector3d& c) { third += area * std::pow(c.dot(axes[k]), 3); });
        if (third < 0) axes[k] = -axes[k];
    }
    axes[2] = axes[0].cross(axes[1]);
    Mat3d frame;
    for (int k = 0; k < 3; ++k) frame.row[k] = {axes[k].x(), axes[k].y(), axes[k].z()};
    return frame;
}

double triangle_area(const Mesh& mesh, std::uint32_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    const Vec3d a = mesh.vertices[t[0]];
    return 0.5 * norm(cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a));
}

Vec3d triangle_centroid(const Mesh& mesh, std::uint32_t triangle)
{
    const Triangle& t = mesh.triangles[triangle];
    const Vec3d a = mesh.vertices[t[0]];
    return a + ((mesh.vertices[t[1]] - a) + (mesh.vertices[t[2]] - a)) / 3.0;
}

double largest_vertex_distance(const Mesh& mesh)
{
    // Sort by distance from the box centre; a pair can only be longer than the best if the sum of both distances is.
    const Box box = box_of(mesh.vertices);
    const Vec3d centre = box.lo + size(box) / 2.0;
    std::vector<std::pair<double, Vec3d>> far;
    for (const Vec3d& v : mesh.vertices) far.emplace_back(norm(v - centre), v);
    std::sort(far.begin(), far.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    double best = 0;
    for (std::size_t i = 0; i < far.size() && 2 * far[i].first > best; ++i)
        for (std::size_t j = i + 1; j < far.size() && far[i].first + far[j].first > best; ++j)
            best = std::max(best, norm(far[i].second - far[j].second));
    return best;
}

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
