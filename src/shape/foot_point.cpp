// Newton's method for eq. 20 with unknown y and distance. The paper rejects a multidimensional Newton iteration as
// unstable (section 4.2.2); what makes it stable here is the start (a neighbouring sample), the step in the tangent plane
// instead of in (eta, omega), and the fall back to the plain tangential step where the quadratic model has no minimum.
#include "sqmap/shape/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::shape {
namespace {

// Near a pole the omega tangent is too short to span the tangent plane: derivatives are taken at this latitude instead.
template <class Real>
constexpr Real k_pole_margin = Real(2e-3);

template <class Real>
SurfacePosition<Real> off_pole(const SurfacePosition<Real>& position, Real eps1)
{
    if (position.latitude.c >= k_pole_margin<Real>) return position;
    return {arc_through(k_pole_margin<Real>, position.latitude.s, eps1), position.longitude};
}

}  // namespace

template <class Real>
Foot<Real> polish_foot(const Superquadric<Real>& sq, Vec3<Real> p, const SurfacePosition<Real>& start,
                       const FootOptions& options) noexcept
{
    // In the local frame: turning six derivative vectors a step buys nothing.
    Superquadric<Real> local = sq;
    local.rotation = {};
    local.translation = {};
    const Vec3<Real> q = to_local(sq, p);
    const Real size = std::max({sq.a.x, sq.a.y, sq.a.z});
    const Real tolerance = static_cast<Real>(options.tolerance) * size;

    Foot<Real> foot;
    foot.position = start;
    SurfacePoint<Real> at = surface_point(local, start);
    Real distance_sq = norm_sq(q - at.point);
    for (;;) {
        const Vec3<Real> d = q - at.point;
        foot.depth = -dot(d, at.normal);
        const Vec3<Real> across = d + foot.depth * at.normal;
        foot.miss = norm(across);
        foot.converged = foot.miss <= tolerance;
        if (foot.converged || foot.iterations == options.max_iterations) break;
        ++foot.iterations;

        const SurfaceJet<Real> jet = surface_jet(local, off_pole(foot.position, sq.eps1));
        const Vec3<Real> eu = jet.point_eta - foot.depth * jet.normal_eta;
        const Vec3<Real> ev = jet.point_omega - foot.depth * jet.normal_omega;
        const Real huu = dot(jet.point_eta, eu), hvv = dot(jet.point_omega, ev);
        const Real huv = Real(0.5) * (dot(jet.point_eta, ev) + dot(jet.point_omega, eu));
        const Real bu = dot(jet.point_eta, across), bv = dot(jet.point_omega, across);
        const Real determinant = huu * hvv - huv * huv;
        Vec3<Real> step = across;
        if (huu > Real(0) && determinant > Real(1e-6) * std::abs(huu * hvv)) {
            step =
                ((hvv * bu - huv * bv) / determinant) * jet.point_eta + ((huu * bv - huv * bu) / determinant) * jet.point_omega;
            const Real length = norm(step);
            if (length > size) step = (size / length) * step;
        }
        // The distance is flat at its minimum: there the miss decides, up to what rounding of positions leaves of the distance.
        const Real rounded_twice = 8 * std::numeric_limits<Real>::epsilon() * size;
        const Real max_sq = distance_sq * (Real(1) + Real(1e-6)) + rounded_twice * (std::abs(foot.depth) + foot.miss);
        bool moved = false;
        for (int halving = 0; halving < 4 && !moved; ++halving, step = Real(0.5) * step) {
            const SurfacePosition<Real> position = position_through(local, at.point + step);
            const SurfacePoint<Real> next = surface_point(local, position);
            const Real next_sq = norm_sq(q - next.point);
            if (next_sq <= max_sq) {
                foot.position = position;
                at = next;
                distance_sq = next_sq;
                moved = true;
            }
        }
        if (!moved) break;
    }
    foot.point = to_model(sq, at.point);
    foot.normal = transpose_mul(sq.rotation, at.normal);
    return foot;
}

template Foot<float> polish_foot(const Superquadric<float>&, Vec3<float>, const SurfacePosition<float>&,
                                 const FootOptions&) noexcept;
template Foot<double> polish_foot(const Superquadric<double>&, Vec3<double>, const SurfacePosition<double>&,
                                  const FootOptions&) noexcept;

}  // namespace sqmap::shape
