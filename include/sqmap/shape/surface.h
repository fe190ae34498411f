// Points, unit outward normals and their derivatives on the surface of a superquadric (eqs. 8 to 10, 20 to 31), and the foot
// point P_M of a point: where its line to the superquadric is a surface normal (section 4.2.2, Fig. 6).
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/shape/superellipse.h"
#include "sqmap/shape/superquadric.h"

namespace sqmap::shape {

/// Equal-spaced surface parameters: the (eta, omega) that are sampled uniformly, before eq. 9 turns them into the
/// parameters of eq. 8. Geometrically the latitude and longitude of the undeformed point divided by the semi-axes.
/// eta in [-pi/2, pi/2], omega in [-pi, pi], radians. At the poles omega has no meaning.
template <class Real>
struct SurfaceAngles {
    Real eta{0}, omega{0};
};
/// In float.
using SurfaceAnglesf = SurfaceAngles<float>;

/// A position on the surface as its two arcs: latitude (c >= 0) and longitude. Holds every power a formula needs.
template <class Real>
struct SurfacePosition {
    Arc<Real> latitude, longitude;
};

/// A point of the surface and its normal.
template <class Real>
struct SurfacePoint {
    Vec3<Real> point;   ///< model frame
    Vec3<Real> normal;  ///< unit, outward, model frame
};

/// First derivatives by the spaced angles, model frame. At the poles the omega derivatives vanish. Derivatives of the
/// normal are taken no closer than k_octant_margin to an octant plane (they are unbounded there for exponents > 1).
template <class Real>
struct SurfaceJet {
    Vec3<Real> point, normal;
    Vec3<Real> point_eta, point_omega;
    Vec3<Real> normal_eta, normal_omega;  ///< of the unit normal (errata 2)
};

/// Surface position at these angles.
template <class Real>
[[nodiscard]] SurfacePosition<Real> position_at(const Superquadric<Real>& sq, SurfaceAngles<Real> angles) noexcept;
/// Position at which the undeformed ray from the centre through the model point p leaves the surface, and F(p)^(1/2) as *gauge:
/// below 1 inside. The centre itself gives the position at angles (0, 0).
template <class Real>
[[nodiscard]] SurfacePosition<Real> position_through(const Superquadric<Real>& sq, Vec3<Real> p, Real* gauge = nullptr) noexcept;
/// Inverse of position_at; with position_through it gives eta and omega of a surface point.
template <class Real>
[[nodiscard]] SurfaceAngles<Real> angles_of(const SurfacePosition<Real>& position) noexcept;

/// Eq. 8 (tapered and bent) with the unit outward normal of the deformed surface: n_d of eq. 24 computed directly and
/// carried through the deformations, never multiplied by s (errata 2 and 4). Where the body is bent so far that it folds
/// over (bend * r >= 1), the normal of the least stretch 0.001 along the axis.
template <class Real>
[[nodiscard]] SurfacePoint<Real> surface_point(const Superquadric<Real>& sq, const SurfacePosition<Real>& position) noexcept;
/// Point of the surface at two angles.
template <class Real>
[[nodiscard]] SurfacePoint<Real> surface_point(const Superquadric<Real>& sq, SurfaceAngles<Real> angles) noexcept
{
    return surface_point(sq, position_at(sq, angles));
}
/// The surface point with its first derivatives.
template <class Real>
[[nodiscard]] SurfaceJet<Real> surface_jet(const Superquadric<Real>& sq, const SurfacePosition<Real>& position) noexcept;

/// A surface given by eq. 22, S = r - D n, from the jet of r and D with its derivatives by the same angles; the
/// unnormalised outward normal of eq. 26 (eta and omega derivatives crossed so that it points out, errata 2).
template <class Real>
[[nodiscard]] Vec3<Real> mapped_normal(const SurfaceJet<Real>& jet, Real distance, Real distance_eta,
                                       Real distance_omega) noexcept;

/// Gradient of F (eq. 1) at a model point, model frame; zero at the centre.
template <class Real>
[[nodiscard]] Vec3<Real> implicit_gradient(const Superquadric<Real>& sq, Vec3<Real> p) noexcept;

/// The undeformed superquadric in the paper's own angles, before spacing: eqs. 8, 24, 25, 28, 30 (with the missing factor
/// of errata 1) and 31, as printed otherwise. For comparison and proof; singular on octant planes, where they must not
/// be used: everything above is their regular form.
namespace printed {
template <class Real>
[[nodiscard]] Vec3<Real> point(const Superquadric<Real>& sq, Real eta, Real omega) noexcept;  ///< eq. 8 = eq. 23
template <class Real>
[[nodiscard]] Vec3<Real> normal_direction(const Superquadric<Real>& sq, Real eta, Real omega) noexcept;  ///< n_d, eq. 24
template <class Real>
[[nodiscard]] Real normal_scale(const Superquadric<Real>& sq, Real eta, Real omega) noexcept;  ///< s, eq. 25, negative
template <class Real>
[[nodiscard]] Vec3<Real> point_eta(const Superquadric<Real>& sq, Real eta, Real omega) noexcept;  ///< eq. 28
template <class Real>
[[nodiscard]] Vec3<Real> point_omega(const Superquadric<Real>& sq, Real eta, Real omega) noexcept;  ///< of eq. 8
template <class Real>
[[nodiscard]] Real normal_scale_eta(const Superquadric<Real>& sq, Real eta, Real omega) noexcept;  ///< eq. 30, corrected
template <class Real>
[[nodiscard]] Vec3<Real> normal_direction_eta(const Superquadric<Real>& sq, Real eta, Real omega) noexcept;  ///< eq. 31
template <class Real>
[[nodiscard]] Vec3<Real> normal_direction_omega(const Superquadric<Real>& sq, Real eta, Real omega) noexcept;  ///< of eq. 24
}  // namespace printed

/// When the search for a foot point ends.
struct FootOptions {
    int max_iterations = 12;
    double tolerance = 2e-6;  ///< of the largest semi-axis: the tangential miss at which the search stops
};

/// The foot point of p: the nearest point of the surface.
template <class Real>
struct Foot {
    SurfacePosition<Real> position;
    Vec3<Real> point, normal;  ///< model frame; normal unit, outward
    Real depth{0};             ///< (point - p) . normal: positive for p inside
    Real miss{0};              ///< length of the part of p - point that is not along the normal
    int iterations{0};
    bool converged{false};
};

/// Newton's method on p = r(eta, omega) - depth n(eta, omega), started at a position near the foot. Steps are taken in the
/// tangent plane and drawn back along undeformed rays, so poles need no care; a step that would not shorten |p - r| is
/// halved. Finds the local minimum of the distance whose basin holds the start; quadratic unless p is at a focal point.
/// Cost: 4 pow an iteration, 2 to 4 iterations from a neighbouring sample. Fails (converged false, best position kept) on
/// the focal surface and beyond it.
template <class Real>
[[nodiscard]] Foot<Real> polish_foot(const Superquadric<Real>& sq, Vec3<Real> p, const SurfacePosition<Real>& start,
                                     const FootOptions& options = {}) noexcept;

}  // namespace sqmap::shape
