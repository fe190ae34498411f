// Both figures are greatest values of functions that are Lipschitz, found by branch and bound: a cell whose value at the middle,
// plus the most by which it can rise within the cell, is not above the best value seen is left; others are halved.
#include "sqmap/collider/shape.h"

#include "sqmap/math/box.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/solid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>

namespace sqmap::collider {
namespace {

constexpr double k_support_accuracy = 0.002, k_protrusion_accuracy = 0.01;  ///< of the extent
constexpr std::size_t k_max_cells = 200'000;                                ///< beyond, the bound is what is left

/// A triangle on the sphere of directions.
struct Directions {
    double bound;
    Vec3d corners[3];
    bool operator<(const Directions& other) const { return bound < other.bound; }
};

/// Signed distance from a convex hull, negative within it.
class HullDistance {
public:
    explicit HullDistance(const mesh::Mesh& hull) : surface_(hull)
    {
        for (const mesh::Triangle& t : hull.triangles) {
            const Vec3d a = hull.vertices[t[0]];
            planes_.emplace_back(a, normalized(cross(hull.vertices[t[1]] - a, hull.vertices[t[2]] - a)));
        }
    }
    double operator()(Vec3d p) const
    {
        double above = -std::numeric_limits<double>::infinity();
        for (const auto& [on, normal] : planes_) above = std::max(above, dot(normal, p - on));
        return above <= 0 ? above : surface_.closest_point(p).distance;
    }

private:
    mesh::Bvh surface_;
    std::vector<std::pair<Vec3d, Vec3d>> planes_;
};

/// A shape that is the hull of points, each thickened to a ball of one radius. Its greatest excess is at one of the points,
/// because the signed distance from a convex body is convex: exact, no search.
struct Thickened {
    std::vector<Vec3d> points;
    double radius = 0;
};
std::optional<Thickened> thickened(const Shape& s)
{
    switch (s.kind) {
        case Kind::Hull:
            return Thickened{s.hull.vertices, 0};
        case Kind::Box:
            return Thickened{surface_of(s).vertices, 0};
        case Kind::Sphere:
            return Thickened{{s.xyz}, s.size.x};
        case Kind::Capsule: {
            const Vec3d half = rotation_of_rpy(s.rpy) * Vec3d{0, 0, s.size.z};
            return Thickened{{s.xyz - half, s.xyz + half}, s.size.x};
        }
        default:
            return std::nullopt;
    }
}

double searched_excess(std::span<const Shape> shapes, const mesh::Mesh& hull)
{
    const std::span<const Vec3d> corners = hull.vertices;
    const Box box = box_of(corners);
    const Vec3d middle = centre(box);
    const double extent = norm(size(box));
    std::vector<Support> supports;
    for (const Shape& s : shapes) supports.emplace_back(s);
    double reach = 0;
    for (const Vec3d& p : corners) reach = std::max(reach, norm(p - middle));
    double greatest = 0, shape_reach = 0;
    // h about the middle: turning a direction by an angle changes a support by at most the angle times the body's reach.
    const auto excess = [&](Vec3d u) {
        double outer = -std::numeric_limits<double>::infinity(), inner = outer;
        for (const Support& s : supports) outer = std::max(outer, s(u));
        for (const Vec3d& p : corners) inner = std::max(inner, dot(u, p));
        return outer - inner;
    };
    for (int k = 0; k < 3; ++k)
        for (const double sign : {1., -1.}) {
            Vec3d u{};
            u[k] = sign;
            double h = 0;
            for (const Support& s : supports) h = std::max(h, s(u) - dot(u, middle));
            shape_reach += h * h / 2;
        }
    shape_reach = std::sqrt(2 * shape_reach);
    std::priority_queue<Directions> queue;
    const auto add = [&](Vec3d a, Vec3d b, Vec3d c) {
        const Vec3d u = normalized(a + b + c);
        const double value = excess(u);
        greatest = std::max(greatest, value);
        const double angle = std::max({norm(a - u), norm(b - u), norm(c - u)}) * 1.05;
        queue.push({value + angle * std::max(reach, shape_reach), {a, b, c}});
    };
    for (const double x : {1., -1.})
        for (const double y : {1., -1.})
            for (const double z : {1., -1.}) add({x, 0, 0}, {0, y, 0}, {0, 0, z});
    for (std::size_t cells = 0; cells < k_max_cells / 20; ++cells) {
        const Directions at = queue.top();
        if (at.bound <= greatest + k_support_accuracy * extent) break;
        queue.pop();
        const Vec3d &a = at.corners[0], &b = at.corners[1], &c = at.corners[2];
        const Vec3d ab = normalized(a + b), bc = normalized(b + c), ca = normalized(c + a);
        add(a, ab, ca);
        add(ab, b, bc);
        add(ca, bc, c);
        add(ab, bc, ca);
    }
    return greatest;
}

double support_excess(std::span<const Shape> shapes, std::span<const Vec3d> points)
{
    const mesh::Mesh hull = enclosing(Kind::Hull, points).hull;
    const HullDistance distance(hull);
    double greatest = 0;
    std::vector<Shape> others;
    for (const Shape& s : shapes) {
        const std::optional<Thickened> body = thickened(s);
        if (!body) others.push_back(s);
        if (body)
            for (const Vec3d& p : body->points) greatest = std::max(greatest, body->radius + distance(p));
    }
    return others.empty() ? greatest : std::max(greatest, searched_excess(others, hull));
}

struct Cell {
    double bound;
    Vec3d middle;
    double half;
    bool operator<(const Cell& other) const { return bound < other.bound; }
};

double protrusion(std::span<const Shape> shapes, const Measured& of)
{
    const mesh::Solid solid(*of.solid, of.crossed);
    Box box;
    std::vector<Outside> outside;
    for (const Shape& s : shapes) {
        outside.emplace_back(s);
        const Support support(s);
        for (int k = 0; k < 3; ++k) {
            Vec3d u{};
            u[k] = 1;
            box.hi[k] = std::max(box.hi[k], support(u));
            box.lo[k] = std::min(box.lo[k], -support(-u));
        }
    }
    const Vec3d half = 0.5 * size(box);
    const double largest = std::max({half.x, half.y, half.z});
    const double accuracy = k_protrusion_accuracy * norm(size(box_of(of.points)));
    double greatest = 0;
    std::priority_queue<Cell> queue;
    const auto add = [&](Vec3d middle, double h) {
        const double reach = std::sqrt(3.) * h;
        double beyond = std::numeric_limits<double>::infinity();
        for (const Outside& o : outside) beyond = std::min(beyond, o(middle));
        if (beyond > reach) return;  // no shape reaches the cell
        const double far = solid.inside(middle) ? -solid.closest_boundary(middle, greatest + reach).distance
                                                : solid.closest_boundary(middle).distance;
        if (!(beyond > 0)) greatest = std::max(greatest, far);
        // A point of the shapes in the cell is no farther from the middle than the cell's corners.
        if (far + reach > greatest + accuracy) queue.push({far + reach, middle, h});
    };
    add(centre(box), largest);
    for (std::size_t cells = 0; !queue.empty() && cells < k_max_cells / 8; ++cells) {
        const Cell at = queue.top();
        if (at.bound <= greatest + accuracy) break;
        queue.pop();
        for (int i = 0; i < 8; ++i)
            add(at.middle + 0.5 * at.half * Vec3d{(i & 1) != 0 ? 1. : -1., (i & 2) != 0 ? 1. : -1., (i & 4) != 0 ? 1. : -1.},
                0.5 * at.half);
    }
    return greatest;
}

}  // namespace

Figures figures_of(std::span<const Shape> shapes, const Measured& solid)
{
    Figures out;
    for (const Shape& s : shapes) out.volume += volume(s);
    if (solid.volume > 0) out.volume_ratio = out.volume / solid.volume;
    out.support_excess = support_excess(shapes, solid.points);
    if (solid.solid != nullptr) out.protrusion = protrusion(shapes, solid);
    return out;
}

}  // namespace sqmap::collider
