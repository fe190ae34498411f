// C. Ericson, Real-Time Collision Detection, 2005: closest points. Signed ray crossings: the degree of the surface.
#include "sqmap/mesh/bvh.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sqmap::mesh {

namespace {
constexpr std::uint32_t k_leaf_size = 4;
}

Vec3d closest_point_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c)
{
    const Vec3d ab = b - a, ac = c - a, ap = p - a;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap);
    if (d1 <= 0 && d2 <= 0) return a;
    const Vec3d bp = p - b;
    const double d3 = dot(ab, bp), d4 = dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + (d1 / (d1 - d3)) * ab;
    const Vec3d cp = p - c;
    const double d5 = dot(ab, cp), d6 = dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + (d2 / (d2 - d6)) * ac;
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return b + ((d4 - d3) / ((d4 - d3) + (d5 - d6))) * (c - b);
    const double sum = va + vb + vc;
    return a + (vb / sum) * ab + (vc / sum) * ac;
}

Bvh::Bvh(const Mesh& mesh) : mesh_(mesh), order_(mesh.triangles.size())
{
    std::iota(order_.begin(), order_.end(), 0u);
    std::vector<Vec3d> centroids(order_.size());
    for (std::uint32_t t = 0; t < order_.size(); ++t) centroids[t] = triangle_centroid(mesh, t);
    nodes_.reserve(order_.size());
    build(0, static_cast<std::uint32_t>(order_.size()), centroids);
}

std::uint32_t Bvh::build(std::uint32_t first, std::uint32_t last, std::vector<Vec3d>& centroids)
{
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    Node node;
    node.lo = node.hi = mesh_.vertices[mesh_.triangles[order_[first]][0]];
    Vec3d clo = centroids[order_[first]], chi = clo;
    for (std::uint32_t i = first; i < last; ++i) {
        for (const std::uint32_t v : mesh_.triangles[order_[i]])
            for (int k = 0; k < 3; ++k) {
                node.lo[k] = std::min(node.lo[k], mesh_.vertices[v][k]);
                node.hi[k] = std::max(node.hi[k], mesh_.vertices[v][k]);
            }
        for (int k = 0; k < 3; ++k) {
            clo[k] = std::min(clo[k], centroids[order_[i]][k]);
            chi[k] = std::max(chi[k], centroids[order_[i]][k]);
        }
    }
    nodes_.push_back(node);
    if (last - first <= k_leaf_size) {
        nodes_[index].first = first;
        nodes_[index].count = last - first;
        return index;
    }
    const Vec3d extent = chi - clo;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
    const std::uint32_t middle = first + (last - first) / 2;
    std::nth_element(
        order_.begin() + first, order_.begin() + middle, order_.begin() + last,
        [&](std::uint32_t u, std::uint32_t v) { return std::pair(centroids[u][axis], u) < std::pair(centroids[v][axis], v); });
    build(first, middle, centroids);
    const std::uint32_t right = build(middle, last, centroids);
    nodes_[index].first = right;
    return index;
}

double Bvh::box_distance_sq(const Node& node, Vec3d p)
{
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double gap = std::max({node.lo[k] - p[k], 0.0, p[k] - node.hi[k]});
        sum += gap * gap;
    }
    return sum;
}

ClosestPoint Bvh::closest_point(Vec3d p, double within) const
{
    ClosestPoint best;
    best.distance = within;
    visit_nearest(p, within * within, [&](std::uint32_t t, double radius_sq) {
        const Triangle& tri = mesh_.triangles[t];
        const Vec3d q = closest_point_on_triangle(p, mesh_.vertices[tri[0]], mesh_.vertices[tri[1]], mesh_.vertices[tri[2]]);
        const double distance_sq = norm_sq(q - p);
        if (distance_sq >= radius_sq) return radius_sq;
        best = {q, t, std::sqrt(distance_sq)};
        return distance_sq;
    });
    return best;
}

bool Bvh::ray_crossings(Vec3d p, Vec3d direction, std::vector<Crossing>& out) const
{
    out.clear();
    const Vec3d inverse{1 / direction.x, 1 / direction.y, 1 / direction.z};
    std::uint32_t stack[k_max_depth];
    int depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const std::uint32_t index = stack[--depth];
        const Node& node = nodes_[index];
        double t_in = 0, t_out = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 3; ++k) {
            const double t0 = (node.lo[k] - p[k]) * inverse[k], t1 = (node.hi[k] - p[k]) * inverse[k];
            t_in = std::max(t_in, std::min(t0, t1));
            t_out = std::min(t_out, std::max(t0, t1));
        }
        if (t_in > t_out * (1 + 1e-12) + 1e-300) continue;
        if (node.count == 0) {
            stack[depth++] = node.first;
            stack[depth++] = index + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const Triangle& tri = mesh_.triangles[order_[i]];
            const Vec3d a = mesh_.vertices[tri[0]] - p, b = mesh_.vertices[tri[1]] - p, c = mesh_.vertices[tri[2]] - p;
            const double u = dot(direction, cross(b, c)), v = dot(direction, cross(c, a)), w = dot(direction, cross(a, b));
            const double size = std::sqrt(std::max({norm_sq(a), norm_sq(b), norm_sq(c)}));
            const double tiny = 1e-13 * size * size;
            if ((u > tiny || v > tiny || w > tiny) && (u < -tiny || v < -tiny || w < -tiny)) continue;
            const double volume = dot(a, cross(b, c)), along = u + v + w;
            if (std::abs(u) <= tiny || std::abs(v) <= tiny || std::abs(w) <= tiny) {
                if (along == 0 || volume / along > -1e-9 * size) return false;
                continue;
            }
            if ((volume > 0) == (along > 0)) out.push_back({volume / along, along > 0 ? 1 : -1, order_[i]});
        }
    }
    std::sort(out.begin(), out.end(),
              [](const Crossing& l, const Crossing& r) { return std::pair(l.t, l.triangle) < std::pair(r.t, r.triangle); });
    return true;
}

int Bvh::winding_number(Vec3d p) const
{
    // Directions without any relation to axes or diagonals; the eighth failing means p lies on the surface itself.
    static constexpr Vec3d k_directions[] = {{0.5773, 0.6211, 0.5301},   {-0.7071, 0.4512, 0.5447},   {0.3137, -0.8911, 0.3279},
                                             {0.1327, 0.3119, -0.9408},  {-0.6417, -0.3511, -0.6819}, {0.8823, 0.2241, -0.4139},
                                             {-0.2729, 0.9241, -0.2673}, {0.4219, -0.4937, -0.7604}};
    std::vector<Crossing> crossings;
    for (const Vec3d& direction : k_directions)
        if (ray_crossings(p, direction, crossings)) break;
    int winding = 0;
    for (const Crossing& c : crossings) winding += c.sign;
    return winding;
}

}  // namespace sqmap::mesh
