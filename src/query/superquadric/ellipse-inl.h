// The superellipse of eqs. 13 and 14, many at a time: as shape/superellipse.h has it.
#if defined(SQMAP_QUERY_SUPERQUADRIC_ELLIPSE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_SUPERQUADRIC_ELLIPSE_INL_H
#undef SQMAP_QUERY_SUPERQUADRIC_ELLIPSE_INL_H
#else
#define SQMAP_QUERY_SUPERQUADRIC_ELLIPSE_INL_H
#endif

#include "query/superquadric/power-inl.h"
#include "sqmap/shape/superellipse.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// See shape::Arc.
struct ArcLanes {
    F c, s, nc, ns;
};
HWY_INLINE ArcLanes blend(M m, const ArcLanes& yes, const ArcLanes& no)
{
    return {blend(m, yes.c, no.c), blend(m, yes.s, no.s), blend(m, yes.nc, no.nc), blend(m, yes.ns, no.ns)};
}
/// A point in polar form: gauge times the point of the superellipse at the arc on the point's ray.
struct ArcAndGauge {
    ArcLanes arc;
    F gauge;
};

/// A superellipse of one exponent.
class EllipseLanes {
public:
    explicit EllipseLanes(float eps)
        : power_(set(2.f / eps)),
          root_(set(-0.5f * eps)),
          slope_(set(2.f / eps - 1.f)),
          least_size_(set(shape::k_octant_margin<float>))
    {
        octant_slope_ = hn::Mul(slope_, power(least_size_, hn::Sub(slope_, set(1.f))));
    }

    HWY_INLINE ArcAndGauge through(F x, F y) const
    {
        const Ratio r(*this, hn::Abs(x), hn::Abs(y));
        const F scale = power(r.sum, root_);
        const F n_big = hn::Div(set(1.f), hn::Mul(r.sum, scale)), c_small = hn::Mul(r.ratio, scale);
        const F n_small =
            hn::IfThenElseZero(r.has_ratio, hn::Mul(hn::Div(r.power, blend(r.has_ratio, r.ratio, set(1.f))), n_big));
        const auto sign = [](F v, F like) { return blend(hn::Lt(like, hn::Zero(df)), hn::Neg(v), v); };
        return {{sign(blend(r.x_is_big, scale, c_small), x), sign(blend(r.x_is_big, c_small, scale), y),
                 sign(blend(r.x_is_big, n_big, n_small), x), sign(blend(r.x_is_big, n_small, n_big), y)},
                hn::Div(r.big, scale)};
    }
    /// The gauge alone, of coordinates that are not negative.
    HWY_INLINE F gauge(F x, F y) const
    {
        const Ratio r(*this, x, y);
        return hn::Mul(r.big, power(r.sum, hn::Neg(root_)));
    }

    /// Derivatives of an arc by its spaced angle; see shape::derivative.
    HWY_INLINE ArcLanes derivative(const ArcLanes& arc) const
    {
        const F radius_sq = mul_add(arc.c, arc.c, hn::Mul(arc.s, arc.s));
        const F dc = hn::Neg(hn::Mul(radius_sq, arc.ns)), ds = hn::Mul(radius_sq, arc.nc);
        const auto slope = [&](F c, F n) {
            const F size = hn::Abs(c);
            const M regular = hn::Ge(size, least_size_);
            return blend(regular, hn::Div(hn::Mul(slope_, hn::Abs(n)), larger(size, least_size_)), octant_slope_);
        };
        return {dc, ds, hn::Mul(slope(arc.c, arc.nc), dc), hn::Mul(slope(arc.s, arc.ns), ds)};
    }

private:
    /// The smaller coordinate over the larger, and its power.
    struct Ratio {
        M x_is_big, has_ratio;
        F big, ratio, power, sum;

        HWY_INLINE Ratio(const EllipseLanes& e, F ax, F ay)
        {
            x_is_big = hn::Ge(ax, ay);
            big = blend(x_is_big, ax, ay);
            ratio = hn::Div(blend(x_is_big, ay, ax), larger(big, set(1e-18f)));
            has_ratio = hn::Gt(ratio, set(1e-30f));
            power = hn::IfThenElseZero(has_ratio, HWY_NAMESPACE::power(ratio, e.power_));
            sum = hn::Add(set(1.f), power);
        }
    };

    F power_, root_, slope_, least_size_, octant_slope_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
