// Closed meshes of superquadric surfaces, by their parametric form and the forward deformations of superquadric.h.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/shape/superquadric.h"

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

namespace sqmap::fit::test {

/// Model point of a point of the plain superellipsoid: taper, then bend, as documented.
inline Vec3d deform(const shape::Superquadricd& sq, Vec3d q)
{
    q.x *= sq.taper_x * q.z / sq.a.z + 1;
    q.y *= sq.taper_y * q.z / sq.a.z + 1;
    if (sq.is_bent()) {
        const double ca = std::cos(sq.bend_angle), sa = std::sin(sq.bend_angle), c = 1 / sq.bend;
        const double r = std::cos(sq.bend_angle - std::atan2(q.y, q.x)) * std::hypot(q.x, q.y);
        const double gamma = q.z * sq.bend, big_r = c - (c - r) * std::cos(gamma);
        q = {q.x + ca * (big_r - r), q.y + sa * (big_r - r), (c - r) * std::sin(gamma)};
    }
    return to_model(sq, q);
}

/// Surface point at the direction (eta, omega), exactly on F = 1: a ray scaled by the homogeneity of F.
inline Vec3d surface_point(const shape::Superquadricd& sq, double eta, double omega)
{
    const Vec3d d{sq.a.x * std::cos(eta) * std::cos(omega), sq.a.y * std::cos(eta) * std::sin(omega), sq.a.z * std::sin(eta)};
    return deform(sq, d / std::sqrt(shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, d)));
}

inline mesh::Mesh tessellate(const shape::Superquadricd& sq, int n)
{
    mesh::Mesh m;
    const auto id = [&](int i, int j) -> std::uint32_t {
        return static_cast<std::uint32_t>(1 + (i - 1) * 2 * n + (j % (2 * n)));
    };
    m.vertices.push_back(surface_point(sq, -std::numbers::pi / 2, 0));
    for (int i = 1; i < n; ++i)
        for (int j = 0; j < 2 * n; ++j)
            m.vertices.push_back(surface_point(sq, std::numbers::pi * (double(i) / n - 0.5), std::numbers::pi * j / n));
    m.vertices.push_back(surface_point(sq, std::numbers::pi / 2, 0));
    const auto last = static_cast<std::uint32_t>(m.vertices.size() - 1);
    for (int j = 0; j < 2 * n; ++j) {
        m.triangles.push_back({0, id(1, j + 1), id(1, j)});
        m.triangles.push_back({last, id(n - 1, j), id(n - 1, j + 1)});
        for (int i = 1; i + 1 < n; ++i) {
            m.triangles.push_back({id(i, j), id(i, j + 1), id(i + 1, j)});
            m.triangles.push_back({id(i, j + 1), id(i + 1, j + 1), id(i + 1, j)});
        }
    }
    return m;
}

inline std::vector<std::uint32_t> all_triangles(const mesh::Mesh& m)
{
    std::vector<std::uint32_t> t(m.triangles.size());
    std::iota(t.begin(), t.end(), 0u);
    return t;
}

inline std::vector<std::array<Vec3d, 3>> corners_of(const mesh::Mesh& m)
{
    std::vector<std::array<Vec3d, 3>> t;
    for (const auto& i : m.triangles) t.push_back({m.vertices[i[0]], m.vertices[i[1]], m.vertices[i[2]]});
    return t;
}

/// Same on every standard library: no distributions.
inline double uniform(std::mt19937& random, double low, double high)
{
    return low + (high - low) * static_cast<double>(random()) * 0x1p-32;
}

inline Mat3d random_rotation(std::mt19937& random)
{
    const Vec3d x = normalized(Vec3d{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
    const Vec3d r{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
    const Vec3d y = normalized(r - dot(r, x) * x);
    return {{x, y, cross(x, y)}};
}

/// Largest F over a dense barycentric grid of each triangle.
inline double dense_largest_f(const shape::Superquadricd& sq, const std::vector<std::array<Vec3d, 3>>& triangles, int n)
{
    double f = 0;
    for (const auto& t : triangles)
        for (int i = 0; i <= n; ++i)
            for (int j = 0; i + j <= n; ++j)
                f = std::max(f, implicit(sq, t[0] + (double(i) / n) * (t[1] - t[0]) + (double(j) / n) * (t[2] - t[0])));
    return f;
}

}  // namespace sqmap::fit::test
