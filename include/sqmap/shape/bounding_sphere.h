// The sphere around a superquadric (section 4.1, step 1).
#pragma once

#include "sqmap/shape/superquadric.h"

namespace sqmap::shape {

template <class Real>
struct Sphere {
    Vec3<Real> centre;  ///< model frame
    Real radius{0};
};

/// A sphere that holds the whole superquadric. Undeformed: centred and exact, in closed form. Tapered or bent: centred
/// on the samples of the surface, the radius proven by a Lipschitz bound between them (a few per cent above the least).
/// Cost: about 8,000 surface points when deformed; meant for bake time.
template <class Real>
[[nodiscard]] Sphere<Real> bounding_sphere(const Superquadric<Real>& sq) noexcept;

}  // namespace sqmap::shape
