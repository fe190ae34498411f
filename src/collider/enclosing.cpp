// Shapes that hold points, as written. Positions and angles are rounded first; lengths are then measured about the rounded pose,
// and rounded up.
#include "collider/numbers.h"
#include "collider/searches.h"
#include "math/predicates.h"
#include "mesh/convex_hull.h"
#include "sqmap/collider/shape.h"
#include "sqmap/math/box.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace sqmap::collider {
namespace {

constexpr double k_rounding = 1e-12;         ///< of the greatest coordinate: what a reader's arithmetic may be off by
constexpr double k_thin = 1e-6;              ///< half the thickness of flat points, of their extent
constexpr std::size_t k_max_searched = 400;  ///< corners of a hull that a search looks at first
constexpr std::size_t k_joining = 64;        ///< corners that join the next search
constexpr int k_max_searches = 8;            ///< searches at most
constexpr double k_excess = 2e-3;            ///< of the volume, that may lie between the shape of few corners and that of all

/// The hull of points; of points in one plane, of six about each.
mesh::Mesh solid_hull(std::span<const Vec3d> points)
{
    mesh::Mesh hull = mesh::convex_hull(points);
    if (!hull.triangles.empty()) return hull;
    const Box box = box_of(points);
    double reach = norm(size(box));
    if (!(reach > 0)) reach = std::max(1e-3, norm(centre(box)));
    std::vector<Vec3d> thick;
    for (const Vec3d& p : points)
        for (int k = 0; k < 3; ++k)
            for (const double sign : {1., -1.}) {
                Vec3d q = p;
                q[k] += sign * k_thin * reach;
                thick.push_back(q);
            }
    return mesh::convex_hull(thick);
}

/// A hull of at most so many corners: those that are extreme in evenly spread directions.
mesh::Mesh fewer_corners(const mesh::Mesh& hull, std::size_t count)
{
    if (hull.vertices.size() <= count) return hull;
    std::vector<char> is_kept(hull.vertices.size(), 0);
    for (const Vec3d& d : half_sphere(static_cast<int>(count) / 2))
        for (const double sign : {1., -1.}) {
            const auto extreme = std::max_element(hull.vertices.begin(), hull.vertices.end(),
                                                  [&](Vec3d l, Vec3d r) { return sign * dot(l, d) < sign * dot(r, d); });
            is_kept[static_cast<std::size_t>(extreme - hull.vertices.begin())] = 1;
        }
    std::vector<Vec3d> kept;
    for (std::size_t i = 0; i < is_kept.size(); ++i)
        if (is_kept[i] != 0) kept.push_back(hull.vertices[i]);
    return mesh::convex_hull(kept);
}

/// The hull of its corners and of those of all that lie farthest outside a shape.
mesh::Mesh with_farthest(const mesh::Mesh& hull, std::span<const Vec3d> all, const Shape& shape)
{
    const Outside outside(shape);
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (const double d = outside(all[i]); d > 0) order.emplace_back(-d, i);
    std::sort(order.begin(), order.end());
    std::vector<Vec3d> points = hull.vertices;
    for (std::size_t i = 0; i < std::min(order.size(), k_joining); ++i) points.push_back(all[order[i].second]);
    return mesh::convex_hull(points);
}

Candidate search(Kind kind, const mesh::Mesh& hull)
{
    switch (kind) {
        case Kind::Box:
            return least_box(hull);
        case Kind::Ellipsoid:
            return least_ellipsoid(hull.vertices);
        case Kind::Capsule:
            return least_capsule(hull);
        case Kind::Cylinder:
            return least_cylinder(hull);
        default: {
            const Sphere ball = least_ball(hull.vertices);
            return {{}, ball.centre, {ball.radius, ball.radius, ball.radius}, 0};
        }
    }
}

/// Sets the lengths of a shape whose pose is final, so that it holds the points with room for `margin`.
void measure_about(Shape& shape, std::span<const Vec3d> points, double margin)
{
    const Mat3d axes = rotation_of_rpy(shape.rpy);
    std::vector<Vec3d> local;
    for (const Vec3d& p : points) local.push_back(transpose_mul(axes, p - shape.xyz));
    Vec3d& s = shape.size;
    const auto greatest = [&](auto&& of) {
        double value = 0;
        for (const Vec3d& q : local) value = std::max(value, of(q));
        return value;
    };
    const auto up = [&](double length) { return rounded_up(length + margin); };
    switch (shape.kind) {
        case Kind::Box:
            for (int k = 0; k < 3; ++k) s[k] = up(greatest([&](Vec3d q) { return std::abs(q[k]); }));
            break;
        case Kind::Ellipsoid: {
            const double f = greatest([&](Vec3d q) { return norm(Vec3d{q.x / s.x, q.y / s.y, q.z / s.z}); });
            const double least = std::min({s.x, s.y, s.z});
            for (int k = 0; k < 3; ++k) s[k] = rounded_up(s[k] * f * (1 + margin / least) * (1 + k_rounding));
            break;
        }
        case Kind::Capsule: {
            const double radius = up(std::max(s.x, greatest([](Vec3d q) { return std::hypot(q.x, q.y); })));
            const double inner = radius - margin;
            const double half = greatest([&](Vec3d q) {
                const double around = std::hypot(q.x, q.y);
                return std::abs(q.z) - std::sqrt(std::max(0.0, inner * inner - around * around));
            });
            s = {radius, radius, std::max(up(half), rounded_up(k_thin * radius))};  // readers want an axis with a length
            break;
        }
        case Kind::Cylinder: {
            const double radius = up(greatest([](Vec3d q) { return std::hypot(q.x, q.y); }));
            s = {radius, radius, up(greatest([](Vec3d q) { return std::abs(q.z); }))};
            break;
        }
        default: {
            const double radius = up(greatest([](Vec3d q) { return norm(q); }));
            s = {radius, radius, radius};
        }
    }
}

}  // namespace

Shape enclosing(Kind kind, std::span<const Vec3d> points)
{
    if (points.empty()) throw std::invalid_argument("there is nothing to enclose");
    if (kind == Kind::Superquadric) throw std::invalid_argument("a superquadric is fitted to a part, not to points");
    const mesh::Mesh hull = solid_hull(points);
    Shape shape{.kind = kind};
    if (kind == Kind::Hull) {
        shape.hull = hull;
        shape.xyz = centre(box_of(hull.vertices));
        return shape;
    }
    // Lengths about one, so that tolerances of the searches have a scale.
    const Box box = box_of(hull.vertices);
    const Vec3d middle = centre(box);
    const double scale = norm(size(box));
    double reach = 0;
    for (const Vec3d& p : hull.vertices) reach = std::max(reach, norm(p));
    mesh::Mesh searched = fewer_corners(hull, k_max_searched);
    double least = std::numeric_limits<double>::infinity();
    // A search over few corners leaves others outside. Where holding them too costs volume, the farthest join the search.
    for (int round = 0; round < k_max_searches; ++round) {
        mesh::Mesh about_one = searched;
        for (Vec3d& p : about_one.vertices) p = (p - middle) / scale;
        const Candidate found = search(kind, about_one);
        Shape held{.kind = kind, .xyz = rounded(middle + scale * found.centre), .size = scale * found.size};
        if (kind != Kind::Sphere) held.rpy = rounded(rpy_of(found.axes));
        const Shape few = held;
        measure_about(held, hull.vertices, k_rounding * std::max(reach, norm(held.xyz)));
        if (const double v = volume(held); v < least) {
            least = v;
            shape = held;
        }
        if (searched.vertices.size() == hull.vertices.size() || volume(held) <= (1 + k_excess) * volume(few)) break;
        searched = with_farthest(searched, hull.vertices, few);
    }
    return shape;
}

Shape as_hull(const Shape& shape, std::span<const Vec3d> points, Precision precision)
{
    if (shape.kind == Kind::Hull && precision == Precision::Double) return shape;
    // A ball without points is held itself: by a hull whose facets are all beyond it.
    const mesh::Mesh held = points.empty() ? mesh::Mesh{} : solid_hull(points);
    mesh::Mesh hull = mesh::convex_hull(surface_of(shape).vertices);
    const Vec3d middle = shape.kind == Kind::Superquadric ? shape.superquadric.translation : shape.xyz;
    const std::vector<Vec3d> before = hull.vertices;
    double scale = 1;
    for (const mesh::Triangle& t : hull.triangles) {
        const Vec3d a = hull.vertices[t[0]], n = cross(hull.vertices[t[1]] - a, hull.vertices[t[2]] - a);
        for (const Vec3d& p : held.vertices) scale = std::max(scale, dot(n, p - middle) / dot(n, a - middle));
        if (points.empty()) scale = std::max(scale, (1 + 1e-9) * shape.size.x * norm(n) / dot(n, a - middle));
    }
    const auto holds_all = [&] {
        for (const mesh::Triangle& t : hull.triangles)
            for (const Vec3d& p : held.vertices)
                if (orient3d(hull.vertices[t[0]], hull.vertices[t[1]], hull.vertices[t[2]], p) < 0) return false;
        return true;
    };
    for (double more = precision == Precision::Float ? 1e-7 : 1e-12; more < 1e-2; more *= 4) {
        std::vector<Vec3d> corners;
        for (const Vec3d& v : before) {
            const Vec3d p = middle + scale * (1 + more) * (v - middle);
            corners.push_back(precision == Precision::Float ? cast<double>(cast<float>(p)) : p);
        }
        hull = mesh::convex_hull(corners);
        if (!hull.triangles.empty() && holds_all()) return {.kind = Kind::Hull, .xyz = shape.xyz, .hull = hull};
    }
    return enclosing(Kind::Hull, points);  // a shape so flat that its facets vanish in rounding
}

}  // namespace sqmap::collider
