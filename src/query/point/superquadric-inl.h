// Superquadrics, many points at a time: which points one may hold, before each of these is computed by itself.
#if defined(SQMAP_QUERY_POINT_SUPERQUADRIC_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_POINT_SUPERQUADRIC_INL_H
#undef SQMAP_QUERY_POINT_SUPERQUADRIC_INL_H
#else
#define SQMAP_QUERY_POINT_SUPERQUADRIC_INL_H
#endif

#include "math/lanes-inl.h"
#include "sqmap/model/model.h"

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

/// x^e for x >= 0, to within 1e-5 of it.
HWY_INLINE F power(F x, float e) { return hn::Exp(df, hn::Mul(set(e), hn::Log(df, hn::Max(x, set(1e-30f))))); }

/// (u^(2/eps) + v^(2/eps))^(eps/2), as shape::implicit_undeformed has it.
HWY_INLINE F blended(F u, F v, float eps)
{
    const F big = hn::Max(u, v), ratio = hn::Div(hn::Min(u, v), hn::Max(big, set(1e-20f)));
    return hn::Mul(big, power(hn::Add(set(1.f), power(ratio, 2.f / eps)), 0.5f * eps));
}

/// The lanes of a mask that a part's superquadric may hold: none that it holds is left out. Model space.
HWY_NOINLINE M may_hold(const model::Part& part, const V3& p, M which)
{
    constexpr float k_slack = 1.002f;  // what rounding and powers lose; of the square root of F
    const shape::Superquadricf sq = model::superquadric_of(part);
    if (sq.is_bent()) return which;
    const V3 d{hn::Sub(p.x, set(sq.translation.x)), hn::Sub(p.y, set(sq.translation.y)), hn::Sub(p.z, set(sq.translation.z))};
    const auto along = [&](int k) {
        const Vec3f& r = sq.rotation.row[k];
        return hn::Mul(mul_add(set(r.x), d.x, mul_add(set(r.y), d.y, hn::Mul(set(r.z), d.z))), set(1.f / sq.a[k]));
    };
    V3 q{along(0), along(1), along(2)};
    if (sq.is_tapered()) {
        const auto widened = [&](float taper) { return hn::Max(mul_add(set(taper), q.z, set(1.f)), set(1e-6f)); };
        q = {hn::Div(q.x, widened(sq.taper_x)), hn::Div(q.y, widened(sq.taper_y)), q.z};
    }
    q = {hn::Abs(q.x), hn::Abs(q.y), hn::Abs(q.z)};
    which = hn::And(which, hn::Le(hn::Max(hn::Max(q.x, q.y), q.z), set(k_slack)));
    if (!any(which)) return which;
    return hn::And(which, hn::Le(blended(blended(q.x, q.y, sq.eps2), q.z, sq.eps1), set(k_slack)));
}

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
