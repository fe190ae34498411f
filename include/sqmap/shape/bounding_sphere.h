// The sphere around a superquadric (section 4.1, step 1).
// Pure functions and plain data: any number of threads.
#pragma once

#include "sqmap/math/pose.h"
#include "sqmap/shape/superquadric.h"

namespace sqmap::shape {

/// A sphere that holds the whole superquadric, in its frame. Undeformed: centred and exact, in closed form. Tapered or bent:
/// centred on the samples of the surface, the radius proven by a Lipschitz bound between them (a few per cent above the least).
/// Cost: about 8,000 surface points when deformed; meant for bake time.
template <class Real>
[[nodiscard]] Sphere3<Real> bounding_sphere(const Superquadric<Real>& sq) noexcept;

}  // namespace sqmap::shape
