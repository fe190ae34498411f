// Solids most of whose surface hides behind other surface: hard for maps that see a part from one point.
#pragma once

#include "sqmap/mesh/mesh.h"
#include "sqmap/mesh/shapes.h"
#include "support/baked_shapes.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>

namespace sqmap::test {

/// A cube with so many times so many square holes along each axis, which cross inside: of unit cells, two triangles a face.
inline mesh::Mesh drilled_block(int holes)
{
    using Cell = std::array<int, 3>;
    const int n = 2 * holes + 1;
    const auto is_solid = [&](const Cell& c) {
        int odd = 0;
        for (const int x : c) {
            if (x < 0 || x >= n) return false;
            odd += x % 2;
        }
        return odd <= 1;
    };
    mesh::Mesh mesh;
    std::map<Cell, std::uint32_t> known;
    const auto vertex = [&](const Cell& p) {
        const auto [at, is_new] = known.emplace(p, static_cast<std::uint32_t>(mesh.vertices.size()));
        if (is_new) mesh.vertices.push_back({double(p[0]), double(p[1]), double(p[2])});
        return at->second;
    };
    for (int i = 0; i < n * n * n; ++i)
        for (std::size_t side = 0; side < 6; ++side) {
            const Cell cell{i % n, i / n % n, i / n / n};
            const std::size_t axis = side / 2;
            Cell beside = cell;
            beside[axis] += side % 2 == 0 ? -1 : 1;
            if (!is_solid(cell) || is_solid(beside)) continue;
            std::array<std::uint32_t, 4> quad{};
            for (std::size_t k = 0; k < 4; ++k) {
                Cell p = cell;
                p[axis] += static_cast<int>(side % 2);
                p[(axis + 1) % 3] += k == 1 || k == 2 ? 1 : 0;
                p[(axis + 2) % 3] += k >= 2 ? 1 : 0;
                quad[side % 2 == 0 ? 3 - k : k] = vertex(p);
            }
            mesh.triangles.push_back({quad[0], quad[1], quad[2]});
            mesh.triangles.push_back({quad[0], quad[2], quad[3]});
        }
    return mesh;
}

/// A cup one unit high whose wall and floor have that thickness, of 4 segments * (steps + steps / 4) triangles or so.
inline mesh::Mesh cup(double wall, std::uint32_t segments, int steps)
{
    std::vector<std::array<double, 2>> profile;  // radius and height, from the middle of the foot to that of the floor
    const auto line = [&](std::array<double, 2> from, std::array<double, 2> to, int count) {
        for (int i = 0; i < count; ++i) {
            const double t = double(i) / count;
            profile.push_back({from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])});
        }
    };
    line({0, 0}, {0.4, 0}, steps / 4);
    line({0.4, 0}, {0.5, 1}, steps);
    line({0.5, 1}, {0.5 - wall, 1}, 1);
    line({0.5 - wall, 1}, {0.4 - wall, wall}, steps);
    line({0.4 - wall, wall}, {0, wall}, steps / 4);
    mesh::Mesh mesh;
    for (std::size_t i = 1; i < profile.size(); ++i)
        for (std::uint32_t k = 0; k < segments; ++k) {
            const double a = 2 * std::numbers::pi * k / segments;
            mesh.vertices.push_back({profile[i][0] * std::cos(a), profile[i][0] * std::sin(a), profile[i][1]});
        }
    const auto foot = static_cast<std::uint32_t>(mesh.vertices.size()), floor = foot + 1, last = foot - segments;
    mesh.vertices.insert(mesh.vertices.end(), {{0, 0, 0}, {0, 0, wall}});
    for (std::uint32_t k = 0; k < segments; ++k) {
        const std::uint32_t l = (k + 1) % segments;
        mesh.triangles.insert(mesh.triangles.end(), {{foot, l, k}, {last + k, last + l, floor}});
        for (std::uint32_t ring = 0; ring < last; ring += segments)
            mesh.triangles.insert(mesh.triangles.end(), {{ring + k, ring + l, ring + segments + l},
                                                         {ring + k, ring + segments + l, ring + segments + k}});
    }
    return mesh;
}

/// A chain of rings, every second one upright.
inline mesh::Mesh chain(int rings)
{
    mesh::Mesh mesh;
    for (int i = 0; i < rings; ++i) {
        const mesh::Mesh ring =
            mesh::torus({.major_radius = 0.5, .minor_radius = 0.08, .major_segments = 24, .minor_segments = 10});
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        for (const Vec3d& p : ring.vertices)
            mesh.vertices.push_back((i % 2 == 0 ? p : Vec3d{p.x, -p.z, p.y}) + Vec3d{0.7 * i, 0, 0});
        for (const mesh::Triangle& t : ring.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    }
    return mesh;
}

}  // namespace sqmap::test
