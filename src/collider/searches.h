// Searches for the enclosing shape of least volume of each kind. Points: few, those of a convex hull; scaled so that lengths are
// about one. Attitudes are matrices whose columns are the shape's axes.
#pragma once

#include "sqmap/collider/shape.h"
#include "sqmap/math/pose.h"
#include "sqmap/mesh/mesh.h"

#include <array>
#include <functional>
#include <span>
#include <vector>

namespace sqmap::collider {

/// A shape's position and attitude; for a capsule also the radius on which its length depends.
struct Candidate {
    Mat3d axes{};  ///< columns: the shape's axes
    Vec3d centre{};
    Vec3d size{};
    double volume = 0;
};

/// The smallest ball, Welzl's algorithm.
[[nodiscard]] Sphere least_ball(std::span<const Vec3d> points);
[[nodiscard]] Candidate least_ellipsoid(std::span<const Vec3d> points);
[[nodiscard]] Candidate least_box(const mesh::Mesh& hull);
[[nodiscard]] Candidate least_capsule(const mesh::Mesh& hull);
[[nodiscard]] Candidate least_cylinder(const mesh::Mesh& hull);

/// Axes whose third is along a direction: columns, right-handed.
[[nodiscard]] Mat3d axes_along(Vec3d direction);
/// A rotation by the vector's length about its direction, after a rotation.
[[nodiscard]] Mat3d turned(const Mat3d& axes, Vec3d by);
/// Evenly spread directions of a half sphere.
[[nodiscard]] std::vector<Vec3d> half_sphere(int count);
/// Normals of the largest facets of a hull, none within 3 degrees of another, at most `count`.
[[nodiscard]] std::vector<Vec3d> facet_normals(const mesh::Mesh& hull, std::size_t count);

/// Lowers a function of N numbers by steps along and between its axes, halved where none lowers it. step: the first, last: the
/// smallest.
template <std::size_t N, class Function>
std::array<double, N> pattern_search(std::array<double, N> x, std::array<double, N> step, double last, Function&& f)
{
    double best = f(x);
    double scale = 1;
    while (scale >= last) {
        bool is_lower = false;
        const auto attempt = [&](std::size_t i, double by_i, std::size_t j, double by_j) {
            std::array<double, N> y = x;
            y[i] += scale * by_i * step[i];
            if (j != i) y[j] += scale * by_j * step[j];
            const double value = f(y);
            if (!(value < best)) return;
            best = value;
            x = y;
            is_lower = true;
        };
        for (std::size_t i = 0; i < N; ++i)
            for (const double by : {1., -1.}) attempt(i, by, i, 0);
        for (std::size_t i = 0; i < N && !is_lower; ++i)
            for (std::size_t j = i + 1; j < N && !is_lower; ++j)
                for (const double by_i : {1., -1.})
                    for (const double by_j : {1., -1.}) attempt(i, by_i, j, by_j);
        if (!is_lower) scale *= 0.5;
    }
    return x;
}

}  // namespace sqmap::collider
