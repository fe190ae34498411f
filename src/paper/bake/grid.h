// Rays from a superquadric's surface, and the grid of samples that they make.
#pragma once

#include "sqmap/paper/bake.h"
#include "sqmap/shape/superquadric.h"
#include "sqmap/shape/surface.h"

#include <algorithm>
#include <numbers>
#include <vector>

namespace sqmap::paper {

using Kind = MapRays::Kind;
using Surface = MapRays::Surface;
using Angles = shape::SurfaceAngles<double>;

inline constexpr double k_pi = std::numbers::pi;

inline double largest_axis(const shape::Superquadricd& sq) { return std::max({sq.a.x, sq.a.y, sq.a.z}); }

/// Casts rays from points of the superquadric's surface, and says how far beyond it a ray can matter.
struct Caster {
    const MapRays& rays;
    const shape::Superquadricd sq;
    const double reach, lift;

    Caster(const MapRays& r, const shape::Superquadricd& s)
        : rays(r), sq(s), reach(2 * shape::bounding_sphere(s).radius), lift(1e-5 * largest_axis(s))
    {
    }
    shape::SurfacePoint<double> at(Angles a) const { return shape::surface_point(sq, a); }
    Surface cast(Angles a) const
    {
        const shape::SurfacePoint<double> s = at(a);
        return rays.surface_along(s.point, -s.normal, {reach, lift});
    }
};

/// Samples of a map, rows along eta, columns around omega.
struct Grid {
    int rows = 0, columns = 0;
    std::vector<Surface> samples;

    Grid(int r, int c) : rows(r), columns(c), samples(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns)) {}
    explicit Grid(int level) : Grid((1 << level) + 1, 2 << level) {}
    std::size_t index(int i, int j) const { return static_cast<std::size_t>(i) * columns + (j + columns) % columns; }
    const Surface& at(int i, int j) const { return samples[index(i, j)]; }
    Angles angles(double i, double j) const { return {k_pi * (i / (rows - 1) - 0.5), 2 * k_pi * j / columns - k_pi}; }
};

/// Unit, outward.
inline Vec3d face_normal(const mesh::Mesh& m, std::uint32_t triangle)
{
    const mesh::Triangle& t = m.triangles[triangle];
    return normalized(cross(m.vertices[t[1]] - m.vertices[t[0]], m.vertices[t[2]] - m.vertices[t[0]]));
}

/// delta of eq. 12 at each sample of the base grid, which is every stride-th of the finest; model units. At local minima alone,
/// whose own gradient is next to nothing (errata 8): the greatest within options.offset_radius counts.
[[nodiscard]] std::vector<double> offsets(const Caster& caster, const Grid& finest, int stride, const MapOptions& options);

/// The mesh diffused over a length, model units, and the normals of what comes out.
[[nodiscard]] SmoothSurface smooth_surface(const mesh::Mesh& mesh, double length);

/// Smoothing::Distances: the base grid convolved with a kernel (section 6: force fields are smoothed by smoothing the map), and
/// the normals of what comes out, by eq. 26. Samples next to a jump, a cap or a miss, and the poles, stay as they are.
/// Smoothing::Surface: every hit has the smoothed surface's plane. Nothing is added for the radius 0: force then has the map's
/// own samples.
void add_smoothing(const Caster& caster, const Grid& finest, const MapOptions& options, Map& map);

}  // namespace sqmap::paper
