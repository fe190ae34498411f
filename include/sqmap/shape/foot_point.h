// The foot point P_M of a point: where its line to the superquadric is a surface normal (section 4.2.2, Fig. 6).
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/shape/surface.h"

namespace sqmap::shape {

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
