// Superquadrics, many points at a time: which points one may hold, before each of these is computed by itself.
#if defined(SQMAP_QUERY_POINT_SUPERQUADRIC_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_POINT_SUPERQUADRIC_INL_H
#undef SQMAP_QUERY_POINT_SUPERQUADRIC_INL_H
#else
#define SQMAP_QUERY_POINT_SUPERQUADRIC_INL_H
#endif

#include "math/lanes-inl.h"
#include "sqmap/shape/superquadric.h"

#include <hwy/contrib/math/math-inl.h>

#include <cmath>

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

/// The lanes of a mask that a superquadric may hold: none that it holds is left out. Model space.
HWY_NOINLINE M may_hold(const shape::Superquadricf& sq, const V3& p, M which)
{
    constexpr float k_slack = 1.002f;  // what rounding and powers lose; of the square root of F
    const V3 d{hn::Sub(p.x, set(sq.translation.x)), hn::Sub(p.y, set(sq.translation.y)), hn::Sub(p.z, set(sq.translation.z))};
    const auto along = [&](int k) { return row_dot(&sq.rotation.row[k].x, d); };
    V3 q{along(0), along(1), along(2)};
    const F one = set(1.f);
    M folded = none();
    if (sq.is_bent()) {
        // As shape::undeform.
        const float ca = std::cos(sq.bend_angle), sa = std::sin(sq.bend_angle), k = sq.bend;
        const F big_r = mul_add(set(ca), q.x, hn::Mul(set(sa), q.y)), left = hn::Sub(one, hn::Mul(set(k), big_r)),
                kz = hn::Mul(set(k), q.z);
        folded = hn::Not(hn::Gt(left, set(1e-3f)));  // beyond the centre of curvature: not ruled out here
        const F gamma = hn::Atan(df, hn::Div(kz, blend(folded, one, left)));
        const F radius = hn::Sqrt(mul_add(kz, kz, hn::Mul(left, left)));
        const F square = mul_add(big_r, big_r, hn::Mul(q.z, q.z));
        const F inner = hn::Sub(hn::Add(big_r, big_r), hn::Mul(set(k), square));
        const F shift = hn::Sub(big_r, hn::Div(inner, hn::Add(one, radius)));
        q = {hn::Sub(q.x, hn::Mul(set(ca), shift)), hn::Sub(q.y, hn::Mul(set(sa), shift)), hn::Mul(gamma, set(1.f / k))};
    }
    q = {hn::Mul(q.x, set(1.f / sq.a.x)), hn::Mul(q.y, set(1.f / sq.a.y)), hn::Mul(q.z, set(1.f / sq.a.z))};
    if (sq.is_tapered()) {
        const auto widened = [&](float taper) { return hn::Max(mul_add(set(taper), q.z, set(1.f)), set(1e-6f)); };
        q = {hn::Div(q.x, widened(sq.taper_x)), hn::Div(q.y, widened(sq.taper_y)), q.z};
    }
    q = {hn::Abs(q.x), hn::Abs(q.y), hn::Abs(q.z)};
    const M kept = hn::And(which, folded);
    which = hn::And(which, hn::Le(hn::Max(hn::Max(q.x, q.y), q.z), set(k_slack)));
    if (any(which)) which = hn::And(which, hn::Le(blended(blended(q.x, q.y, sq.eps2), q.z, sq.eps1), set(k_slack)));
    return hn::Or(kept, which);
}

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
