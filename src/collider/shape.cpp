#include "sqmap/collider/shape.h"

#include "mesh/convex_hull.h"
#include "sqmap/fit/fit.h"
#include "sqmap/mesh/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::collider {
namespace {

constexpr double k_pi = std::numbers::pi;

/// Dual norm of a nested l_p norm with p = 2 / eps: of the exponent q = p / (p - 1), eps from 0 to 2.
double dual_blend(double u, double v, double eps)
{
    const double big = std::max(std::abs(u), std::abs(v)), small = std::min(std::abs(u), std::abs(v));
    if (!(small > 0)) return big;
    if (eps >= 2) return big;  // p = 1: the greatest component
    const double q = 2 / (2 - eps);
    return big * std::pow(1 + std::pow(small / big, q), 1 / q);
}

double superquadric_support(const shape::Superquadricd& sq, Vec3d local)
{
    return dual_blend(dual_blend(sq.a.x * local.x, sq.a.y * local.y, sq.eps2), sq.a.z * local.z, sq.eps1);
}

}  // namespace

const char* name_of(Kind kind) noexcept
{
    constexpr const char* k_names[] = {"box", "sphere", "ellipsoid", "capsule", "cylinder", "hull", "superquadric"};
    return k_names[static_cast<std::size_t>(kind)];
}

Mat3d rotation_of_rpy(Vec3d rpy) noexcept
{
    const double cr = std::cos(rpy.x), sr = std::sin(rpy.x), cp = std::cos(rpy.y), sp = std::sin(rpy.y), cy = std::cos(rpy.z),
                 sy = std::sin(rpy.z);
    return {{{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
             {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
             {-sp, cp * sr, cp * cr}}};
}

Vec3d rpy_of(const Mat3d& r) noexcept
{
    const double sp = std::clamp(-r.row[2].x, -1.0, 1.0);
    if (std::hypot(r.row[2].y, r.row[2].z) < 1e-9) return {0, std::copysign(k_pi / 2, sp), std::atan2(-r.row[0].y, r.row[1].y)};
    return {std::atan2(r.row[2].y, r.row[2].z), std::asin(sp), std::atan2(r.row[1].x, r.row[0].x)};
}

Quaternion quaternion_of_rpy(Vec3d rpy) noexcept
{
    const double cr = std::cos(rpy.x / 2), sr = std::sin(rpy.x / 2), cp = std::cos(rpy.y / 2), sp = std::sin(rpy.y / 2),
                 cy = std::cos(rpy.z / 2), sy = std::sin(rpy.z / 2);
    const Quaternion q{cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
                       cr * cp * sy - sr * sp * cy};
    return q.w < 0 ? Quaternion{-q.w, -q.x, -q.y, -q.z} : q;
}

double volume(const Shape& s)
{
    const double r = s.size.x;
    switch (s.kind) {
        case Kind::Box:
            return 8 * s.size.x * s.size.y * s.size.z;
        case Kind::Sphere:
        case Kind::Ellipsoid:
            return 4 * k_pi / 3 * s.size.x * s.size.y * s.size.z;
        case Kind::Capsule:
            return k_pi * r * r * (2 * s.size.z + 4 * r / 3);
        case Kind::Cylinder:
            return 2 * k_pi * r * r * s.size.z;
        case Kind::Hull:
            return mesh::volume(s.hull);
        case Kind::Superquadric:
            return fit::volume(s.superquadric);
    }
    return 0;
}

Support::Support(const Shape& shape) : shape_(shape), axes_(rotation_of_rpy(shape.rpy))
{
    if (shape.kind == Kind::Hull) corners_ = shape.hull.vertices;
    if (shape.kind == Kind::Superquadric && shape.superquadric.is_deformed()) corners_ = surface_of(shape).vertices;
}

double Support::operator()(Vec3d u) const noexcept
{
    double greatest = -std::numeric_limits<double>::infinity();
    for (const Vec3d& p : corners_) greatest = std::max(greatest, dot(u, p));
    if (!corners_.empty()) return greatest;
    if (shape_.kind == Kind::Superquadric)
        return dot(u, shape_.superquadric.translation) +
               superquadric_support(shape_.superquadric, shape_.superquadric.rotation * u);
    const Vec3d q = transpose_mul(axes_, u), s = shape_.size;
    const double along = dot(u, shape_.xyz), around = std::hypot(q.x, q.y);
    switch (shape_.kind) {
        case Kind::Box:
            return along + s.x * std::abs(q.x) + s.y * std::abs(q.y) + s.z * std::abs(q.z);
        case Kind::Capsule:
            return along + s.x + s.z * std::abs(q.z);
        case Kind::Cylinder:
            return along + s.x * around + s.z * std::abs(q.z);
        default:
            return along + norm(Vec3d{s.x * q.x, s.y * q.y, s.z * q.z});
    }
}

Outside::Outside(const Shape& shape) : shape_(shape), axes_(rotation_of_rpy(shape.rpy))
{
    for (const mesh::Triangle& t : shape.hull.triangles) {
        const Vec3d a = shape.hull.vertices[t[0]];
        planes_.push_back({a, normalized(cross(shape.hull.vertices[t[1]] - a, shape.hull.vertices[t[2]] - a))});
    }
}

double Outside::operator()(Vec3d p) const noexcept
{
    if (shape_.kind == Kind::Hull) {
        double farthest = 0;
        for (const Plane& plane : planes_) farthest = std::max(farthest, dot(plane.normal, p - plane.on));
        return farthest;
    }
    if (shape_.kind == Kind::Superquadric) {
        // f = sqrt(F) is a norm of the undeformed point, at most sqrt(3) / min(a) times its length. Deformed: a guess.
        const shape::Superquadricd& sq = shape_.superquadric;
        const double f = std::sqrt(shape::implicit(sq, p)), least = std::min({sq.a.x, sq.a.y, sq.a.z});
        return std::max(0.0, f - 1) * least / std::numbers::sqrt3;
    }
    const Vec3d q = transpose_mul(axes_, p - shape_.xyz), s = shape_.size;
    const double around = std::hypot(q.x, q.y), above = std::max(0.0, std::abs(q.z) - s.z);
    switch (shape_.kind) {
        case Kind::Box:
            return norm(Vec3d{std::max(0.0, std::abs(q.x) - s.x), std::max(0.0, std::abs(q.y) - s.y), above});
        case Kind::Capsule:
            return std::max(0.0, std::hypot(around, above) - s.x);
        case Kind::Cylinder:
            return std::hypot(std::max(0.0, around - s.x), above);
        case Kind::Sphere:
            return std::max(0.0, norm(q) - s.x);
        default:
            return std::max(0.0, norm(Vec3d{q.x / s.x, q.y / s.y, q.z / s.z}) - 1) * std::min({s.x, s.y, s.z});
    }
}

mesh::Mesh surface_of(const Shape& s)
{
    if (s.kind == Kind::Hull) return s.hull;
    if (s.kind == Kind::Superquadric) return mesh::superquadric_surface(s.superquadric, 12);
    const Mat3d axes = rotation_of_rpy(s.rpy);
    std::vector<Vec3d> points;
    if (s.kind == Kind::Box) {
        for (int i = 0; i < 8; ++i)
            points.push_back(
                {(i & 1) != 0 ? s.size.x : -s.size.x, (i & 2) != 0 ? s.size.y : -s.size.y, (i & 4) != 0 ? s.size.z : -s.size.z});
    } else if (s.kind == Kind::Cylinder) {
        constexpr int k_around = 32;
        for (int i = 0; i < 2 * k_around; ++i) {
            const double angle = k_pi * (i / 2) / (k_around / 2);
            points.push_back({s.size.x * std::cos(angle), s.size.x * std::sin(angle), i % 2 == 0 ? s.size.z : -s.size.z});
        }
    } else {
        for (const Vec3d& v : mesh::sphere(1, 3).vertices) {
            const bool is_capsule = s.kind == Kind::Capsule;
            const double radius = is_capsule ? s.size.x : s.size.z;
            const Vec3d p{s.size.x * v.x, s.size.y * v.y, radius * v.z};
            if (!is_capsule || v.z >= 0) points.push_back(p + Vec3d{0, 0, is_capsule ? s.size.z : 0});
            if (is_capsule && v.z <= 0) points.push_back(p - Vec3d{0, 0, s.size.z});
        }
    }
    for (Vec3d& p : points) p = axes * p + s.xyz;
    return mesh::convex_hull(points);
}

}  // namespace sqmap::collider
