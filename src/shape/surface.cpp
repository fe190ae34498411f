// Moustakas, Tzovaras, Strintzis, "SQ-Map", eqs. 8 to 10 and 20 to 31, corrected; deformations and their normals after
// Barr 1984 and Solina and Bajcsy 1990. A deformation with Jacobian J carries tangents by J and normals by J^-T.
#include "sqmap/shape/surface.h"

#include <cmath>

namespace sqmap::shape {
namespace {

// The tangent map of a bend folds over where bend * r reaches 1; normals keep this least stretch beyond it.
template <class Real>
constexpr Real k_min_stretch = Real(1e-3);

template <class Real>
Real at_least(Real v, Real least)
{
    return v > least ? v : least;
}

// A point with its normal direction, or a derivative of both.
template <class Real>
struct PointNormal {
    Vec3<Real> x, n;
};

// Carries a point, its normal and any number of derivatives of both through taper and bend, in the local frame.
template <class Real, int N>
void deform_jet(const Superquadric<Real>& sq, PointNormal<Real>& value, PointNormal<Real> (&derivatives)[N], int count)
{
    if (sq.is_tapered()) {
        const Real kx = sq.taper_x / sq.a.z, ky = sq.taper_y / sq.a.z;
        const Vec3<Real> x = value.x, n = value.n;
        const Real fx = Real(1) + kx * x.z, fy = Real(1) + ky * x.z;
        const Real mx = n.x / fx, my = n.y / fy;
        for (int i = 0; i < count; ++i) {
            const Vec3<Real> dx = derivatives[i].x, dn = derivatives[i].n;
            const Real dfx = kx * dx.z, dfy = ky * dx.z;
            const Real dmx = (dn.x - mx * dfx) / fx, dmy = (dn.y - my * dfy) / fy;
            derivatives[i].x = {dfx * x.x + fx * dx.x, dfy * x.y + fy * dx.y, dx.z};
            derivatives[i].n = {dmx, dmy, dn.z - kx * (dx.x * mx + x.x * dmx) - ky * (dx.y * my + x.y * dmy)};
        }
        value = {{fx * x.x, fy * x.y, x.z}, {mx, my, n.z - kx * x.x * mx - ky * x.y * my}};
    }
    if (sq.is_bent()) {
        // In the plane of the bend: (r, z) -> a rotation by gamma of the stretch diag(1, 1 - bend r).
        const Real k = sq.bend, ca = std::cos(sq.bend_angle), sa = std::sin(sq.bend_angle);
        const Vec3<Real> x = value.x, n = value.n;
        const Real r = ca * x.x + sa * x.y, nr = ca * n.x + sa * n.y;
        const Real stretch = at_least(Real(1) - k * r, k_min_stretch<Real>);
        const Real cg = std::cos(k * x.z), sg = std::sin(k * x.z);
        const Real nz = n.z / stretch;
        for (int i = 0; i < count; ++i) {
            const Vec3<Real> dx = derivatives[i].x, dn = derivatives[i].n;
            const Real dr = ca * dx.x + sa * dx.y, dg = k * dx.z;
            const Real dnr = ca * dn.x + sa * dn.y, dnz = (dn.z + nz * k * dr) / stretch;
            const Real along = (cg * dr + sg * stretch * dx.z) - dr;  // change of the in-plane component only
            const Real along_n = (cg * (dnr + dg * nz) + sg * (dnz - dg * nr)) - dnr;
            derivatives[i].x = {dx.x + ca * along, dx.y + sa * along, -sg * dr + cg * stretch * dx.z};
            derivatives[i].n = {dn.x + ca * along_n, dn.y + sa * along_n, -sg * (dnr + dg * nz) + cg * (dnz - dg * nr)};
        }
        const Real along_n = cg * nr + sg * nz - nr;
        value.x = deform(sq, x, Deformation::BendOnly);
        value.n = {n.x + ca * along_n, n.y + sa * along_n, -sg * nr + cg * nz};
    }
}

template <class Real>
PointNormal<Real> undeformed(const Superquadric<Real>& sq, const SurfacePosition<Real>& at)
{
    const Arc<Real>&u = at.latitude, &v = at.longitude;
    return {{sq.a.x * u.c * v.c, sq.a.y * u.c * v.s, sq.a.z * u.s}, {u.nc * v.nc / sq.a.x, u.nc * v.ns / sq.a.y, u.ns / sq.a.z}};
}

}  // namespace

template <class Real>
SurfacePosition<Real> position_at(const Superquadric<Real>& sq, SurfaceAngles<Real> angles) noexcept
{
    const Real c = std::cos(angles.eta);
    return {arc_through(c > Real(0) ? c : Real(0), std::sin(angles.eta), sq.eps1),
            arc_through(std::cos(angles.omega), std::sin(angles.omega), sq.eps2)};
}

template <class Real>
SurfacePosition<Real> position_through(const Superquadric<Real>& sq, Vec3<Real> p, Real* gauge) noexcept
{
    const Vec3<Real> q = undeform(sq, to_local(sq, p));
    const Arc<Real> longitude = arc_through(q.x / sq.a.x, q.y / sq.a.y, sq.eps2);
    const Arc<Real> latitude = arc_through(longitude.gauge, q.z / sq.a.z, sq.eps1);
    if (gauge) *gauge = latitude.gauge;
    return {latitude, longitude};
}

template <class Real>
SurfaceAngles<Real> angles_of(const SurfacePosition<Real>& position) noexcept
{
    return {std::atan2(position.latitude.s, position.latitude.c), std::atan2(position.longitude.s, position.longitude.c)};
}

template <class Real>
SurfacePoint<Real> surface_point(const Superquadric<Real>& sq, const SurfacePosition<Real>& position) noexcept
{
    PointNormal<Real> value = undeformed(sq, position);
    PointNormal<Real> none[1];
    deform_jet(sq, value, none, 0);
    return {to_model(sq, value.x), transpose_mul(sq.rotation, normalized(value.n))};
}

template <class Real>
SurfaceJet<Real> surface_jet(const Superquadric<Real>& sq, const SurfacePosition<Real>& position) noexcept
{
    const Arc<Real>&u = position.latitude, &v = position.longitude;
    const ArcDerivative<Real> du = derivative(u, sq.eps1), dv = derivative(v, sq.eps2);
    PointNormal<Real> value = undeformed(sq, position);
    PointNormal<Real> d[2] = {
        {{sq.a.x * du.c * v.c, sq.a.y * du.c * v.s, sq.a.z * du.s},
         {du.nc * v.nc / sq.a.x, du.nc * v.ns / sq.a.y, du.ns / sq.a.z}},
        {{sq.a.x * u.c * dv.c, sq.a.y * u.c * dv.s, Real(0)}, {u.nc * dv.nc / sq.a.x, u.nc * dv.ns / sq.a.y, Real(0)}}};
    deform_jet(sq, value, d, 2);
    // Derivative of the unit normal: the part of dn across n, divided by |n|.
    const Real length = norm(value.n);
    const Vec3<Real> n = value.n / length;
    const auto unit_derivative = [&](Vec3<Real> dn) { return (dn - dot(dn, n) * n) / length; };
    const auto turned = [&](Vec3<Real> w) { return transpose_mul(sq.rotation, w); };
    return {to_model(sq, value.x),          turned(n), turned(d[0].x), turned(d[1].x), turned(unit_derivative(d[0].n)),
            turned(unit_derivative(d[1].n))};
}

template <class Real>
Vec3<Real> mapped_normal(const SurfaceJet<Real>& jet, Real distance, Real distance_eta, Real distance_omega) noexcept
{
    const Vec3<Real> s_eta = jet.point_eta - distance_eta * jet.normal - distance * jet.normal_eta;
    const Vec3<Real> s_omega = jet.point_omega - distance_omega * jet.normal - distance * jet.normal_omega;
    return cross(s_omega, s_eta);  // omega runs east, eta north: east x north is up
}

template <class Real>
Vec3<Real> implicit_gradient(const Superquadric<Real>& sq, Vec3<Real> p) noexcept
{
    const Vec3<Real> q = undeform(sq, to_local(sq, p));
    const Arc<Real> longitude = arc_through(q.x / sq.a.x, q.y / sq.a.y, sq.eps2);
    const Arc<Real> latitude = arc_through(longitude.gauge, q.z / sq.a.z, sq.eps1);
    // F = gauge^2 and the gauge's gradient is n_d at the position the ray through q leaves the surface.
    PointNormal<Real> value{q, Real(2) * latitude.gauge * undeformed(sq, SurfacePosition<Real>{latitude, longitude}).n};
    PointNormal<Real> none[1];
    deform_jet(sq, value, none, 0);
    return transpose_mul(sq.rotation, value.n);
}

namespace printed {

template <class Real>
Vec3<Real> point(const Superquadric<Real>& sq, Real eta, Real omega) noexcept
{
    const Real ce = signed_power(std::cos(eta), sq.eps1);
    return {sq.a.x * ce * signed_power(std::cos(omega), sq.eps2), sq.a.y * ce * signed_power(std::sin(omega), sq.eps2),
            sq.a.z * signed_power(std::sin(eta), sq.eps1)};
}
template <class Real>
Vec3<Real> normal_direction(const Superquadric<Real>& sq, Real eta, Real omega) noexcept
{
    const Real ce = signed_power(std::cos(eta), Real(2) - sq.eps1);
    return {ce * signed_power(std::cos(omega), Real(2) - sq.eps2) / sq.a.x,
            ce * signed_power(std::sin(omega), Real(2) - sq.eps2) / sq.a.y,
            signed_power(std::sin(eta), Real(2) - sq.eps1) / sq.a.z};
}
// Powers of |sin| and |cos| below: both factors of a product change sign together, so only magnitudes matter.
template <class Real>
Real normal_scale(const Superquadric<Real>& sq, Real eta, Real omega) noexcept
{
    return -sq.a.x * sq.a.y * sq.a.z * sq.eps1 * sq.eps2 * std::pow(std::abs(std::sin(eta)), sq.eps1 - 1) *
           std::pow(std::cos(eta), 2 * sq.eps1 - 1) * std::pow(std::abs(std::sin(omega)), sq.eps2 - 1) *
           std::pow(std::abs(std::cos(omega)), sq.eps2 - 1);
}
template <class Real>
Vec3<Real> point_eta(const Superquadric<Real>& sq, Real eta, Real omega) noexcept
{
    const Real ce = std::pow(std::cos(eta), sq.eps1 - 2);
    const Real common = sq.eps1 / 2 * std::sin(2 * eta);
    return {-common * sq.a.x * ce * signed_power(std::cos(omega), sq.eps2),
            -common * sq.a.y * ce * signed_power(std::sin(omega), sq.eps2),
            common * sq.a.z * signed_power(std::sin(eta), sq.eps1 - 2)};
}
template <class Real>
Vec3<Real> point_omega(const Superquadric<Real>& sq, Real eta, Real omega) noexcept
{
    const Real ce = std::pow(std::cos(eta), sq.eps1);
    const Real common = sq.eps2 / 2 * std::sin(2 * omega) * ce;
    return {-common * sq.a.x * signed_power(std::cos(omega), sq.eps2 - 2),
            common * sq.a.y * signed_power(std::sin(omega), sq.eps2 - 2), Real(0)};
}
template <class Real>
Real normal_scale_eta(const Superquadric<Real>& sq, Real eta, Real omega) noexcept
{
    const Real a = -sq.a.x * sq.a.y * sq.a.z * sq.eps1 * sq.eps2 * std::pow(std::abs(std::sin(omega)), sq.eps2 - 1) *
                   std::pow(std::abs(std::cos(omega)), sq.eps2 - 1);
    const Real t = std::tan(eta);
    return a * std::pow(std::cos(eta), 2 * sq.eps1) * signed_power(std::sin(eta), sq.eps1 - 2) *
           ((sq.eps1 - 1) - (2 * sq.eps1 - 1) * t * t);
}
template <class Real>
Vec3<Real> normal_direction_eta(const Superquadric<Real>& sq, Real eta, Real omega) noexcept
{
    const Real common = (1 - sq.eps1 / 2) * std::sin(2 * eta), ce = std::pow(std::cos(eta), -sq.eps1);
    return {-common * ce * signed_power(std::cos(omega), 2 - sq.eps2) / sq.a.x,
            -common * ce * signed_power(std::sin(omega), 2 - sq.eps2) / sq.a.y,
            common * signed_power(std::sin(eta), -sq.eps1) / sq.a.z};
}
template <class Real>
Vec3<Real> normal_direction_omega(const Superquadric<Real>& sq, Real eta, Real omega) noexcept
{
    const Real common = (1 - sq.eps2 / 2) * std::sin(2 * omega) * std::pow(std::cos(eta), 2 - sq.eps1);
    return {-common * signed_power(std::cos(omega), -sq.eps2) / sq.a.x, common * signed_power(std::sin(omega), -sq.eps2) / sq.a.y,
            Real(0)};
}

}  // namespace printed

#define SQMAP_INSTANTIATE(Real)                                                                                  \
    template SurfacePosition<Real> position_at(const Superquadric<Real>&, SurfaceAngles<Real>) noexcept;         \
    template SurfacePosition<Real> position_through(const Superquadric<Real>&, Vec3<Real>, Real*) noexcept;      \
    template SurfaceAngles<Real> angles_of(const SurfacePosition<Real>&) noexcept;                               \
    template SurfacePoint<Real> surface_point(const Superquadric<Real>&, const SurfacePosition<Real>&) noexcept; \
    template SurfaceJet<Real> surface_jet(const Superquadric<Real>&, const SurfacePosition<Real>&) noexcept;     \
    template Vec3<Real> mapped_normal(const SurfaceJet<Real>&, Real, Real, Real) noexcept;                       \
    template Vec3<Real> implicit_gradient(const Superquadric<Real>&, Vec3<Real>) noexcept;                       \
    namespace printed {                                                                                          \
    template Vec3<Real> point(const Superquadric<Real>&, Real, Real) noexcept;                                   \
    template Vec3<Real> normal_direction(const Superquadric<Real>&, Real, Real) noexcept;                        \
    template Real normal_scale(const Superquadric<Real>&, Real, Real) noexcept;                                  \
    template Vec3<Real> point_eta(const Superquadric<Real>&, Real, Real) noexcept;                               \
    template Vec3<Real> point_omega(const Superquadric<Real>&, Real, Real) noexcept;                             \
    template Real normal_scale_eta(const Superquadric<Real>&, Real, Real) noexcept;                              \
    template Vec3<Real> normal_direction_eta(const Superquadric<Real>&, Real, Real) noexcept;                    \
    template Vec3<Real> normal_direction_omega(const Superquadric<Real>&, Real, Real) noexcept;                  \
    }
SQMAP_INSTANTIATE(float)
SQMAP_INSTANTIATE(double)
#undef SQMAP_INSTANTIATE

}  // namespace sqmap::shape
