// The farthest point of |x/a|^(2/e) + |y/b|^(2/e) = 1 from its centre: for e >= 1 the longer axis, else by Hoelder's
// inequality (a^q + b^q)^(1/q) with q = 2 / (1 - e). Superellipsoids nest two of these.
#include "sqmap/shape/superquadric.h"

#include "sqmap/math/box.h"
#include "sqmap/shape/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap::shape {
namespace {

template <class Real>
Real reach(Real a, Real b, Real eps)
{
    const Real big = std::max(a, b), small = std::min(a, b);
    if (eps >= Real(1)) return big;
    const Real q = Real(2) / (Real(1) - eps);
    return big * std::pow(Real(1) + std::pow(small / big, q), Real(1) / q);
}

// Largest speed |d(c, s)/dt| of an arc in the spaced angle.
template <class Real>
Real arc_speed(Real eps)
{
    return eps < Real(1) ? std::pow(Real(2), Real(1) - eps) : std::numbers::sqrt2_v<Real>;
}

}  // namespace

template <class Real>
Sphere3<Real> bounding_sphere(const Superquadric<Real>& sq) noexcept
{
    const Real slack = Real(1) + Real(16) * std::numeric_limits<Real>::epsilon();  // rounding of the formulas below
    const Real across = reach(sq.a.x, sq.a.y, sq.eps2);
    if (!sq.is_deformed()) return {sq.translation, reach(across, sq.a.z, sq.eps1) * slack};

    constexpr int k_rows = 64, k_columns = 128;
    constexpr Real k_pi = std::numbers::pi_v<Real>;
    const auto sample = [&](int i, int j) {
        return surface_point(sq,
                             SurfaceAngles<Real>{k_pi * (Real(i) / k_rows - Real(0.5)), 2 * k_pi * Real(j) / k_columns - k_pi})
            .point;
    };
    // Centre of the box of the samples along the local axes: good enough, as only the radius must be proven.
    Box3<Real> box;
    for (int i = 0; i <= k_rows; ++i)
        for (int j = 0; j < k_columns; ++j) extend(box, to_local(sq, sample(i, j)));
    const Vec3<Real> middle = to_model(sq, centre(box));
    Real farthest = 0;
    for (int i = 0; i <= k_rows; ++i)
        for (int j = 0; j < k_columns; ++j) farthest = std::max(farthest, norm(sample(i, j) - middle));

    // Every surface point is within half a step in each angle of a sample; tangents grow at most by these norms.
    const Real taper = Real(1) + std::max(std::abs(sq.taper_x), std::abs(sq.taper_y)) +
                       norm(Vec3<Real>{sq.taper_x * (sq.a.x / sq.a.z), sq.taper_y * (sq.a.y / sq.a.z), 0});
    const Real widest = across * (Real(1) + std::max(std::abs(sq.taper_x), std::abs(sq.taper_y)));
    const Real bend = Real(1) + sq.bend * widest;
    const Real eta_speed = arc_speed(sq.eps1) * std::max(across, sq.a.z);
    const Real omega_speed = arc_speed(sq.eps2) * std::max(sq.a.x, sq.a.y);
    const Real gap = taper * bend * (eta_speed * k_pi / k_rows / 2 + omega_speed * k_pi / k_columns);
    return {middle, (farthest + gap) * slack};
}

template Sphere3<float> bounding_sphere(const Superquadric<float>&) noexcept;
template Sphere3<double> bounding_sphere(const Superquadric<double>&) noexcept;

}  // namespace sqmap::shape
