// The central chart: a cube of directions about a part's centre, in the part's frame divided by the superquadric's axes.
//
// A point x' of that frame lies on face m (its largest coordinate) at s, t (the other two over it) and w = 1/|largest|. Every
// plane is w = alpha + beta s + gamma t there: triangles project to straight-edged triangles, flat surfaces are stored without
// error, and the tangent plane of a stored surface is read off without trigonometry.
#pragma once

#include "sqmap/math/vec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sqmap::model {

inline constexpr int k_faces = 6;              ///< +x -x +y -y +z -z of the part frame
inline constexpr int k_domain_directions = 9;  ///< x, y, z, x+y, x-y, x+z, x-z, y+z, y-z bound where a chart answers

struct ChartPoint {
    int face;
    float s, t, w;
};

/// Axis of a face; s and t lie along the two others in cyclic order.
constexpr int face_axis(int face) { return face >> 1; }
template <class Real = float>
constexpr Real face_sign(int face)
{
    return (face & 1) != 0 ? Real(-1) : Real(1);
}

inline ChartPoint to_chart(Vec3f x)
{
    const float ax = std::abs(x.x), ay = std::abs(x.y), az = std::abs(x.z);
    const int m = ax >= ay && ax >= az ? 0 : (ay >= az ? 1 : 2);
    const float major = x[m];
    // The centre itself has no direction: any will do, with a w nearer than every surface.
    const float w = 1.f / std::max(std::abs(major), 1e-18f);
    return {2 * m + (major < 0.f ? 1 : 0), x[(m + 1) % 3] * w, x[(m + 2) % 3] * w, w};
}

/// Direction of (s, t) on a face, largest coordinate 1.
template <class Real>
constexpr Vec3<Real> face_direction(int face, Real s, Real t)
{
    const int m = face_axis(face);
    Vec3<Real> q{};
    q[m] = face_sign<Real>(face);
    q[(m + 1) % 3] = s;
    q[(m + 2) % 3] = t;
    return q;
}

/// w of a surface at some (s, t), and its derivatives by s and t.
template <class Real>
struct ChartPlane {
    Real w, ws, wt;
};

/// n of the tangent plane n x' = 1 of a surface at (s, t).
template <class Real>
constexpr Vec3<Real> plane_vector(int face, Real s, Real t, const ChartPlane<Real>& at)
{
    const int m = face_axis(face);
    Vec3<Real> n{};
    n[m] = face_sign<Real>(face) * (at.w - at.ws * s - at.wt * t);
    n[(m + 1) % 3] = at.ws;
    n[(m + 2) % 3] = at.wt;
    return n;
}

/// In the k_domain_directions.
template <class Real>
constexpr std::array<Real, k_domain_directions> domain_coordinates(Vec3<Real> x)
{
    return {x.x, x.y, x.z, x.x + x.y, x.x - x.y, x.x + x.z, x.x - x.z, x.y + x.z, x.y - x.z};
}
template <class Real>
constexpr Real domain_coordinate(Vec3<Real> x, std::size_t k)
{
    return domain_coordinates(x)[k];
}

}  // namespace sqmap::model
