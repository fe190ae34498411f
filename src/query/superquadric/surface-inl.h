// A part's superquadric, many points at a time: as shape/superquadric.h and shape/surface.h have it (eqs. 1, 2, 8, 24).
#if defined(SQMAP_QUERY_SUPERQUADRIC_SURFACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_SUPERQUADRIC_SURFACE_INL_H
#undef SQMAP_QUERY_SUPERQUADRIC_SURFACE_INL_H
#else
#define SQMAP_QUERY_SUPERQUADRIC_SURFACE_INL_H
#endif

#include "query/superquadric/ellipse-inl.h"
#include "sqmap/shape/superquadric.h"

#include <algorithm>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// A position on the surface as its two arcs.
struct PositionLanes {
    ArcLanes latitude, longitude;
};
HWY_INLINE PositionLanes blend(M m, const PositionLanes& yes, const PositionLanes& no)
{
    return {blend(m, yes.latitude, no.latitude), blend(m, yes.longitude, no.longitude)};
}

/// A surface point with its unit outward normal; the superquadric's own frame.
struct SurfaceLanes {
    V3 point, normal;
};

/// A point with its normal direction, or a derivative of both.
struct PointNormalLanes {
    V3 x, n;
};

/// First derivatives by the spaced angles of a surface point and of its unit normal.
struct JetLanes {
    V3 point_eta, point_omega, normal_eta, normal_omega;
};

/// The same direction by an angle that sine_cosine takes: searches for a bend may turn round many times.
HWY_INLINE float within_turns(float angle)
{
    constexpr double k_turn = 6.283185307179586;
    if (std::abs(angle) <= 9.42f) return angle;
    const double turns = static_cast<double>(angle) / k_turn;
    return static_cast<float>(k_turn * (turns - std::floor(turns + 0.5)));
}

class SuperquadricLanes {
public:
    explicit SuperquadricLanes(const shape::Superquadricf& sq)
        : sq_(sq), latitude_(sq.eps1), longitude_(sq.eps2), inverse_{1 / sq.a.x, 1 / sq.a.y, 1 / sq.a.z}
    {
        const SineCosine turn = sine_cosine(set(within_turns(sq.bend_angle)));
        bend_x_ = turn.cosine;
        bend_y_ = turn.sine;
    }

    /// Largest semi-axis.
    float size() const { return std::max({sq_.a.x, sq_.a.y, sq_.a.z}); }
    const shape::Superquadricf& shape() const { return sq_; }
    const EllipseLanes& latitude() const { return latitude_; }
    const EllipseLanes& longitude() const { return longitude_; }

    HWY_INLINE V3 to_local(const V3& p) const
    {
        const V3 d{hn::Sub(p.x, set(sq_.translation.x)), hn::Sub(p.y, set(sq_.translation.y)),
                   hn::Sub(p.z, set(sq_.translation.z))};
        return {row_dot(&sq_.rotation.row[0].x, d), row_dot(&sq_.rotation.row[1].x, d), row_dot(&sq_.rotation.row[2].x, d)};
    }
    HWY_INLINE V3 direction_to_model(const V3& v) const
    {
        const auto along = [&](int k) {
            return mul_add(set(sq_.rotation.row[0][k]), v.x,
                           mul_add(set(sq_.rotation.row[1][k]), v.y, hn::Mul(set(sq_.rotation.row[2][k]), v.z)));
        };
        return {along(0), along(1), along(2)};
    }
    HWY_INLINE V3 to_model(const V3& q) const
    {
        const V3 v = direction_to_model(q);
        return {hn::Add(v.x, set(sq_.translation.x)), hn::Add(v.y, set(sq_.translation.y)), hn::Add(v.z, set(sq_.translation.z))};
    }

    /// The undeformed source of a local point, in units of the semi-axes.
    HWY_INLINE V3 to_unit(V3 q) const
    {
        const F one = set(1.f);
        if (sq_.is_bent()) {
            const F k = set(sq_.bend), across = mul_add(bend_x_, q.x, hn::Mul(bend_y_, q.y));
            const F left = hn::Sub(one, hn::Mul(k, across)), kz = hn::Mul(k, q.z);
            const F radius = hn::Sqrt(mul_add(kz, kz, hn::Mul(left, left)));
            const F square = mul_add(across, across, hn::Mul(q.z, q.z));
            const F inner = hn::Sub(hn::Add(across, across), hn::Mul(k, square));
            const F shift = hn::Sub(across, hn::Div(inner, hn::Add(one, radius)));
            q = {hn::Sub(q.x, hn::Mul(bend_x_, shift)), hn::Sub(q.y, hn::Mul(bend_y_, shift)),
                 hn::Mul(angle_of(kz, left), set(1.f / sq_.bend))};
        }
        V3 unit{hn::Mul(q.x, set(inverse_.x)), hn::Mul(q.y, set(inverse_.y)), hn::Mul(q.z, set(inverse_.z))};
        if (sq_.is_tapered()) {
            unit.x = hn::Div(unit.x, larger(mul_add(set(sq_.taper_x), unit.z, one), set(1e-6f)));
            unit.y = hn::Div(unit.y, larger(mul_add(set(sq_.taper_y), unit.z, one), set(1e-6f)));
        }
        return unit;
    }

    /// The surface point on the ray through an undeformed point, and F^(1/2) there.
    HWY_INLINE PositionLanes through(const V3& unit, F& gauge) const
    {
        const ArcAndGauge longitude = longitude_.through(unit.x, unit.y);
        const ArcAndGauge latitude = latitude_.through(longitude.gauge, unit.z);
        gauge = latitude.gauge;
        return {latitude.arc, longitude.arc};
    }

    HWY_INLINE SurfaceLanes surface(const PositionLanes& at) const
    {
        PointNormalLanes value = undeformed(at);
        PointNormalLanes none[1];
        if (sq_.is_deformed()) deform<0>(value, none);
        return {value.x, unit_of(value.n)};
    }
    /// The point alone.
    HWY_INLINE V3 point(const PositionLanes& at) const
    {
        const ArcLanes &u = at.latitude, &v = at.longitude;
        const F across = u.c;
        V3 x{hn::Mul(hn::Mul(set(sq_.a.x), across), v.c), hn::Mul(hn::Mul(set(sq_.a.y), across), v.s),
             hn::Mul(set(sq_.a.z), u.s)};
        if (sq_.is_tapered()) x = {hn::Mul(x.x, widening(sq_.taper_x, x.z)), hn::Mul(x.y, widening(sq_.taper_y, x.z)), x.z};
        if (sq_.is_bent()) x = bent(x, half_turn(x));
        return x;
    }

    /// Derivatives near a pole: the omega tangent is too short there to span the tangent plane, so a latitude beside the pole
    /// serves.
    HWY_INLINE JetLanes jet(PositionLanes at) const
    {
        constexpr float k_pole_margin = 2e-3f;
        const M pole = hn::Lt(at.latitude.c, set(k_pole_margin));
        if (any(pole)) at.latitude = blend(pole, latitude_.through(set(k_pole_margin), at.latitude.s).arc, at.latitude);
        const ArcLanes &u = at.latitude, &v = at.longitude, du = latitude_.derivative(u), dv = longitude_.derivative(v);
        PointNormalLanes value = undeformed(at);
        PointNormalLanes d[2] = {undeformed({du, v}), undeformed({u, dv})};
        d[1].x.z = d[1].n.z = hn::Zero(df);
        if (sq_.is_deformed()) deform<2>(value, d);
        const F inverse = hn::Div(set(1.f), larger(length(value.n), set(1e-18f)));
        const V3 n = scaled(inverse, value.n);
        const auto unit_derivative = [&](const V3& dn) { return scaled(inverse, minus(dn, scaled(dot(dn, n), n))); };
        return {d[0].x, d[1].x, unit_derivative(d[0].n), unit_derivative(d[1].n)};
    }

private:
    /// Eq. 8 with n_d of eq. 24; the derivative of either arc in its stead gives that of both.
    HWY_INLINE PointNormalLanes undeformed(const PositionLanes& at) const
    {
        const ArcLanes &u = at.latitude, &v = at.longitude;
        return {{hn::Mul(hn::Mul(set(sq_.a.x), u.c), v.c), hn::Mul(hn::Mul(set(sq_.a.y), u.c), v.s), hn::Mul(set(sq_.a.z), u.s)},
                {hn::Mul(hn::Mul(u.nc, v.nc), set(inverse_.x)), hn::Mul(hn::Mul(u.nc, v.ns), set(inverse_.y)),
                 hn::Mul(u.ns, set(inverse_.z))}};
    }

    HWY_INLINE F widening(float taper, F z) const { return mul_add(set(taper * inverse_.z), z, set(1.f)); }
    HWY_INLINE SineCosine half_turn(const V3& x) const { return sine_cosine(hn::Mul(set(0.5f * sq_.bend), x.z)); }
    /// half: of half the angle that the bend turns there.
    HWY_INLINE V3 bent(const V3& x, const SineCosine& half) const
    {
        const F arm = hn::Sub(set(1.f / sq_.bend), mul_add(bend_x_, x.x, hn::Mul(bend_y_, x.y)));
        const F two_sine = hn::Add(half.sine, half.sine), shift = hn::Mul(hn::Mul(two_sine, half.sine), arm);
        return {mul_add(bend_x_, shift, x.x), mul_add(bend_y_, shift, x.y), hn::Mul(arm, hn::Mul(two_sine, half.cosine))};
    }

    /// Carries a point, its normal and n derivatives of both through taper and bend.
    template <int n>
    HWY_INLINE void deform(PointNormalLanes& value, PointNormalLanes* derivatives) const
    {
        if (sq_.is_tapered()) taper<n>(value, derivatives);
        if (sq_.is_bent()) bend<n>(value, derivatives);
    }
    template <int count>
    HWY_INLINE void taper(PointNormalLanes& value, PointNormalLanes* derivatives) const
    {
        const F kx = set(sq_.taper_x * inverse_.z), ky = set(sq_.taper_y * inverse_.z);
        const V3 x = value.x, n = value.n;
        const F fx = widening(sq_.taper_x, x.z), fy = widening(sq_.taper_y, x.z);
        const F mx = hn::Div(n.x, fx), my = hn::Div(n.y, fy);
        for (int i = 0; i < count; ++i) {
            const V3 dx = derivatives[i].x, dn = derivatives[i].n;
            const F dfx = hn::Mul(kx, dx.z), dfy = hn::Mul(ky, dx.z);
            const F dmx = hn::Div(hn::Sub(dn.x, hn::Mul(mx, dfx)), fx), dmy = hn::Div(hn::Sub(dn.y, hn::Mul(my, dfy)), fy);
            derivatives[i].x = {mul_add(dfx, x.x, hn::Mul(fx, dx.x)), mul_add(dfy, x.y, hn::Mul(fy, dx.y)), dx.z};
            const F along_x = hn::Mul(kx, mul_add(dx.x, mx, hn::Mul(x.x, dmx))),
                    along_y = hn::Mul(ky, mul_add(dx.y, my, hn::Mul(x.y, dmy)));
            derivatives[i].n = {dmx, dmy, hn::Sub(hn::Sub(dn.z, along_x), along_y)};
        }
        const F along = mul_add(hn::Mul(kx, x.x), mx, hn::Mul(hn::Mul(ky, x.y), my));
        value = {{hn::Mul(fx, x.x), hn::Mul(fy, x.y), x.z}, {mx, my, hn::Sub(n.z, along)}};
    }
    template <int count>
    HWY_INLINE void bend(PointNormalLanes& value, PointNormalLanes* derivatives) const
    {
        // In the plane of the bend: a rotation of the stretch diag(1, 1 - bend r).
        const F k = set(sq_.bend);
        const V3 x = value.x, n = value.n;
        const F r = mul_add(bend_x_, x.x, hn::Mul(bend_y_, x.y)), nr = mul_add(bend_x_, n.x, hn::Mul(bend_y_, n.y));
        const F stretch = larger(hn::Sub(set(1.f), hn::Mul(k, r)), set(1e-3f));
        const SineCosine half = half_turn(x);
        const F two_sine = hn::Add(half.sine, half.sine), sg = hn::Mul(two_sine, half.cosine),
                cg = hn::Sub(set(1.f), hn::Mul(two_sine, half.sine));
        const F nz = hn::Div(n.z, stretch);
        for (int i = 0; i < count; ++i) {
            const V3 dx = derivatives[i].x, dn = derivatives[i].n;
            const F dr = mul_add(bend_x_, dx.x, hn::Mul(bend_y_, dx.y)), dg = hn::Mul(k, dx.z);
            const F dnr = mul_add(bend_x_, dn.x, hn::Mul(bend_y_, dn.y));
            const F dnz = hn::Div(mul_add(nz, hn::Mul(k, dr), dn.z), stretch), stretched = hn::Mul(stretch, dx.z);
            const F along = hn::Sub(mul_add(cg, dr, hn::Mul(sg, stretched)), dr);
            const F across = mul_add(dg, nz, dnr), down = hn::Sub(dnz, hn::Mul(dg, nr));
            const F along_n = hn::Sub(mul_add(cg, across, hn::Mul(sg, down)), dnr);
            derivatives[i].x = {mul_add(bend_x_, along, dx.x), mul_add(bend_y_, along, dx.y),
                                hn::Sub(hn::Mul(cg, stretched), hn::Mul(sg, dr))};
            derivatives[i].n = {mul_add(bend_x_, along_n, dn.x), mul_add(bend_y_, along_n, dn.y),
                                hn::Sub(hn::Mul(cg, down), hn::Mul(sg, across))};
        }
        const F along_n = hn::Sub(mul_add(cg, nr, hn::Mul(sg, nz)), nr);
        value = {bent(x, half),
                 {mul_add(bend_x_, along_n, n.x), mul_add(bend_y_, along_n, n.y), hn::Sub(hn::Mul(cg, nz), hn::Mul(sg, nr))}};
    }

    const shape::Superquadricf sq_;
    const EllipseLanes latitude_, longitude_;
    const Vec3f inverse_;
    F bend_x_, bend_y_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
