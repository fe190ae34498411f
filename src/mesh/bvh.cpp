// Signed ray crossings: the degree of the surface.
#include "sqmap/mesh/bvh.h"

#include "math/triangle.h"
#include "sqmap/math/box.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sqmap::mesh {

namespace {
constexpr std::uint32_t k_leaf_size = 2;
}

Bvh::Bvh(const Mesh& mesh) : mesh_(mesh), order_(mesh.triangles.size())
{
    std::iota(order_.begin(), order_.end(), 0u);
    std::vector<Vec3d> centroids(order_.size());
    for (std::uint32_t t = 0; t < order_.size(); ++t) centroids[t] = triangle_centroid(mesh, t);
    build(0, static_cast<std::uint32_t>(order_.size()), centroids);
}

/// Puts the lesser half, along the longest side of the box, first; returns the start of the other half.
std::uint32_t Bvh::halve(std::uint32_t first, std::uint32_t last, const std::vector<Vec3d>& centroids)
{
    Box box;
    for (std::uint32_t i = first; i < last; ++i) extend(box, centroids[order_[i]]);
    const int axis = longest_axis(box);
    const std::uint32_t middle = first + (last - first) / 2;
    std::nth_element(
        order_.begin() + first, order_.begin() + middle, order_.begin() + last,
        [&](std::uint32_t u, std::uint32_t v) { return std::pair(centroids[u][axis], u) < std::pair(centroids[v][axis], v); });
    return middle;
}

std::uint32_t Bvh::build(std::uint32_t first, std::uint32_t last, const std::vector<Vec3d>& centroids)
{
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    std::uint32_t ends[k_width + 1] = {first, last, last, last, last};
    if (last - first > k_leaf_size) {
        const std::uint32_t middle = halve(first, last, centroids);
        ends[2] = middle;
        ends[1] = middle - first > k_leaf_size ? halve(first, middle, centroids) : middle;
        ends[3] = last - middle > k_leaf_size ? halve(middle, last, centroids) : last;
    }
    for (int c = 0; c < k_width; ++c) {
        Box box;
        for (std::uint32_t i = ends[c]; i < ends[c + 1]; ++i)
            for (const std::uint32_t v : mesh_.triangles[order_[i]]) extend(box, mesh_.vertices[v]);
        const std::uint32_t size = ends[c + 1] - ends[c];
        const std::uint32_t child = size > k_leaf_size ? build(ends[c], ends[c + 1], centroids) : (size > 0 ? ends[c] : 0);
        Node& node = nodes_[index];
        for (int k = 0; k < 3; ++k) {
            node.lo[k][c] = box.lo[k];
            node.hi[k][c] = box.hi[k];
        }
        node.first[c] = child;
        node.count[c] = size > k_leaf_size ? 0 : size;
    }
    return index;
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

/// Calls meet(first, count, to) for leaves whose box the ray meets before `to`, which meet may shorten; nearest boxes first where
/// IsOrdered. False as soon as meet is.
template <bool IsOrdered, class Meet>
bool Bvh::walk(const Ray& ray, Meet&& meet) const
{
    const Vec3d inverse{1 / ray.direction.x, 1 / ray.direction.y, 1 / ray.direction.z};
    struct Entry {
        double t_in;
        std::uint32_t first, count;
    };
    Entry stack[k_stack];
    int size = 0;
    double to = ray.to;
    stack[size++] = {ray.from, 0, 0};
    while (size > 0) {
        const Entry at = stack[--size];
        if (at.t_in > to) continue;
        if (at.count > 0) {
            if (!meet(at.first, at.count, to)) return false;
            continue;
        }
        const Node& node = nodes_[at.first];
        double t_in[k_width], t_out[k_width];
        std::fill_n(t_in, k_width, ray.from);
        std::fill_n(t_out, k_width, to);
        for (int k = 0; k < 3; ++k) {
            const double from = ray.origin[k], over = inverse[k];
            for (int i = 0; i < k_width; ++i) {
                const double t0 = (node.lo[k][i] - from) * over, t1 = (node.hi[k][i] - from) * over;
                const double near = t1 < t0 ? t1 : t0, far = t0 < t1 ? t1 : t0;  // 0 times infinity rules nothing out
                t_in[i] = near > t_in[i] ? near : t_in[i];
                t_out[i] = far < t_out[i] ? far : t_out[i];
            }
        }
        const int bottom = size;
        for (int i = k_width; i-- > 0;) {
            const bool is_empty = node.count[i] == 0 && node.first[i] == 0;
            if (is_empty || t_in[i] > t_out[i] * (1 + 1e-12) + 1e-300) continue;
            int slot = size++;
            if constexpr (IsOrdered)  // farthest first onto the stack
                for (; slot > bottom && stack[slot - 1].t_in < t_in[i]; --slot) stack[slot] = stack[slot - 1];
            stack[slot] = {t_in[i], node.first[i], node.count[i]};
        }
    }
    return true;
}

/// Signs are those of volumes over edges, which two triangles at an edge compute alike but for the sign: no ray passes between.
std::optional<Bvh::Hit> Bvh::meet(const Ray& ray, std::uint32_t triangle) const
{
    const Triangle& tri = mesh_.triangles[triangle];
    const Vec3d a = mesh_.vertices[tri[0]] - ray.origin, b = mesh_.vertices[tri[1]] - ray.origin,
                c = mesh_.vertices[tri[2]] - ray.origin;
    const double u = dot(ray.direction, cross(b, c)), v = dot(ray.direction, cross(c, a)), w = dot(ray.direction, cross(a, b));
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return std::nullopt;
    const Vec3d normal = cross(b - a, c - a);
    const double along = dot(ray.direction, normal), sum = u + v + w;
    if (along == 0 || sum == 0) return std::nullopt;  // in its plane
    const double t = dot(a, normal) / along;
    if (!(t > ray.from && t < ray.to)) return std::nullopt;
    return Hit{t, v / sum, w / sum, triangle, along < 0};
}

std::optional<Bvh::Hit> Bvh::first_hit(const Ray& ray) const
{
    std::optional<Hit> best;
    walk<true>(ray, [&](std::uint32_t first, std::uint32_t count, double& to) {
        for (std::uint32_t i = first; i < first + count; ++i)
            if (const std::optional<Hit> hit = meet(ray, order_[i]);
                hit && (!best || std::pair(hit->t, hit->triangle) < std::pair(best->t, best->triangle))) {
                best = hit;
                to = hit->t;
            }
        return true;
    });
    return best;
}

bool Bvh::meets_any(const Ray& ray) const
{
    return !walk<false>(ray, [&](std::uint32_t first, std::uint32_t count, double&) {
        for (std::uint32_t i = first; i < first + count; ++i)
            if (meet(ray, order_[i])) return false;
        return true;
    });
}

void Bvh::all_hits(const Ray& ray, std::vector<Hit>& out) const
{
    out.clear();
    walk<false>(ray, [&](std::uint32_t first, std::uint32_t count, double&) {
        for (std::uint32_t i = first; i < first + count; ++i)
            if (const std::optional<Hit> hit = meet(ray, order_[i])) out.push_back(*hit);
        return true;
    });
    std::sort(out.begin(), out.end(),
              [](const Hit& l, const Hit& r) { return std::pair(l.t, l.triangle) < std::pair(r.t, r.triangle); });
}

/// Calls add(crossing) for the triangles that a ray crosses beyond its origin. False if the ray grazes one of them.
template <class Add>
bool Bvh::cross_triangles(const Ray& ray, Add&& add) const
{
    const Vec3d p = ray.origin, direction = ray.direction;
    return walk<false>(ray, [&](std::uint32_t first, std::uint32_t count, double&) {
        for (std::uint32_t i = first; i < first + count; ++i) {
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
            if ((volume > 0) == (along > 0)) add(Crossing{volume / along, along > 0 ? 1 : -1, order_[i]});
        }
        return true;
    });
}

bool Bvh::ray_crossings(Vec3d p, Vec3d direction, std::vector<Crossing>& out) const
{
    out.clear();
    if (!cross_triangles({p, direction}, [&](const Crossing& c) { out.push_back(c); })) return false;
    std::sort(out.begin(), out.end(),
              [](const Crossing& l, const Crossing& r) { return std::pair(l.t, l.triangle) < std::pair(r.t, r.triangle); });
    return true;
}

std::optional<int> Bvh::winding_change(Vec3d from, Vec3d to) const
{
    constexpr double k_rounding = 1e-14;
    const double length = norm(to - from), slack = k_rounding * (norm(from) + norm(to));
    if (!(length > 0)) return 0;
    int change = 0;
    bool at_end = false;
    const auto add = [&](const Crossing& c) {
        at_end = at_end || c.t <= slack || std::abs(c.t - length) <= slack;
        if (c.t < length) change -= c.sign;
    };
    if (!cross_triangles({from, (to - from) / length, 0, length}, add) || at_end) return std::nullopt;
    return change;
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
