// Closed meshes of a few triangles, for contacts that are known by hand or by an exact oracle.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/query/probe.h"
#include "support/baked_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::test {

/// The convex solid between two polygons of as many corners, the lower one first; both counter-clockwise seen from above.
inline mesh::Mesh prism(const std::vector<Vec3d>& lower, const std::vector<Vec3d>& upper)
{
    const auto n = static_cast<std::uint32_t>(lower.size());
    mesh::Mesh m;
    m.vertices = lower;
    m.vertices.insert(m.vertices.end(), upper.begin(), upper.end());
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t j = (i + 1) % n;
        m.triangles.push_back({i, j, n + i});
        m.triangles.push_back({j, n + j, n + i});
        if (i > 0 && i + 1 < n) {
            m.triangles.push_back({0, i + 1, i});
            m.triangles.push_back({n, n + i, n + i + 1});
        }
    }
    return m;
}

inline mesh::Mesh box(Vec3d lo, Vec3d hi)
{
    const auto at = [&](double z) {
        return std::vector<Vec3d>{{lo.x, lo.y, z}, {hi.x, lo.y, z}, {hi.x, hi.y, z}, {lo.x, hi.y, z}};
    };
    return prism(at(lo.z), at(hi.z));
}

/// A bar of square section that lies on an edge: along x or y, its ridges at z above and below the middle.
inline mesh::Mesh diamond_bar(bool along_x, double half_length, double half_height, double middle)
{
    const auto ring = [&](double s) {
        const std::array<std::array<double, 2>, 4> section{{{0, -1}, {1, 0}, {0, 1}, {-1, 0}}};
        std::vector<Vec3d> points;
        for (const auto& [across, up] : section)
            points.push_back(along_x ? Vec3d{s, half_height * across, middle + half_height * up}
                                     : Vec3d{-half_height * across, s, middle + half_height * up});
        return points;
    };
    mesh::Mesh m = prism(ring(-half_length), ring(half_length));
    double volume = 0;
    for (const mesh::Triangle& t : m.triangles) volume += dot(m.vertices[t[0]], cross(m.vertices[t[1]], m.vertices[t[2]]));
    if (volume < 0)
        for (mesh::Triangle& t : m.triangles) std::swap(t[1], t[2]);
    return m;
}

inline mesh::Mesh moved(mesh::Mesh m, Vec3d by)
{
    for (Vec3d& v : m.vertices) v += by;
    return m;
}

/// Several solids as one mesh.
inline mesh::Mesh joined(const std::vector<mesh::Mesh>& solids)
{
    mesh::Mesh all;
    for (const mesh::Mesh& m : solids) {
        const auto first = static_cast<std::uint32_t>(all.vertices.size());
        all.vertices.insert(all.vertices.end(), m.vertices.begin(), m.vertices.end());
        for (const mesh::Triangle& t : m.triangles) all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    return all;
}

/// A tetrahedron, octahedron, box or prism. On a lattice, corners are whole numbers, so that two of them often touch, overlap or
/// share what they have.
inline mesh::Mesh random_solid(Random& random, bool on_lattice)
{
    const auto number = [&](int from, int to) {
        return on_lattice ? static_cast<double>(from + static_cast<int>(random.below(static_cast<std::size_t>(to - from + 1))))
                          : random.between(from, to);
    };
    for (;;) {
        mesh::Mesh m;
        switch (random.below(4)) {
            case 0: {
                m.vertices = {{number(-2, 2), number(-2, 2), number(-2, 2)},
                              {number(-2, 2), number(-2, 2), number(-2, 2)},
                              {number(-2, 2), number(-2, 2), number(-2, 2)},
                              {number(-2, 2), number(-2, 2), number(-2, 2)}};
                m.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
                break;
            }
            case 1: {
                const double r = number(1, 2);
                m.vertices = {{r, 0, 0}, {-r, 0, 0}, {0, r, 0}, {0, -r, 0}, {0, 0, r}, {0, 0, -r}};
                for (std::uint32_t x : {0u, 1u})
                    for (std::uint32_t y : {2u, 3u})
                        for (std::uint32_t z : {4u, 5u})
                            m.triangles.push_back((x + y + z) % 2 == 0 ? mesh::Triangle{x, y, z} : mesh::Triangle{x, z, y});
                break;
            }
            case 2:
                m = box({0, 0, 0}, {number(1, 2), number(1, 2), number(1, 2)});
                break;
            default: {
                const double h = number(1, 2), x = number(-1, 1), y = number(-1, 1);
                const std::vector<Vec3d> lower{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
                std::vector<Vec3d> upper;
                for (const Vec3d& p : lower) upper.push_back(p + Vec3d{x, y, h});
                m = prism(lower, upper);
            }
        }
        double volume = 0;
        for (const mesh::Triangle& t : m.triangles)
            volume +=
                dot(m.vertices[t[0]] - m.vertices[0], cross(m.vertices[t[1]] - m.vertices[0], m.vertices[t[2]] - m.vertices[0]));
        if (volume == 0) continue;
        if (volume < 0)
            for (mesh::Triangle& t : m.triangles) std::swap(t[1], t[2]);
        return moved(std::move(m), {number(-1, 1), number(-1, 1), number(-1, 1)});
    }
}

}  // namespace sqmap::test
