// Powers, angles and their inverses by polynomials, many at a time: no library's, so that every instruction set and every machine
// has the same bits. How far each is from its function in double is a constant here and a test.
#if defined(SQMAP_QUERY_SUPERQUADRIC_POWER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_SUPERQUADRIC_POWER_INL_H
#undef SQMAP_QUERY_SUPERQUADRIC_POWER_INL_H
#else
#define SQMAP_QUERY_SUPERQUADRIC_POWER_INL_H
#endif

#include "math/lanes-inl.h"
#include "query/superquadric/power_error.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;
using sqmap::HWY_NAMESPACE::blend;  // beside those of this namespace

constexpr float k_pi = 3.14159265358979324f;

// hn::Max and hn::Min return either zero of two of different sign.
HWY_INLINE F larger(F a, F b) { return blend(hn::Gt(a, b), a, b); }
HWY_INLINE F smaller(F a, F b) { return blend(hn::Lt(a, b), a, b); }
HWY_INLINE I flag(M which, std::int32_t bit) { return hn::IfThenElseZero(hn::RebindMask(di, which), set_int(bit)); }

/// c[0] + c[1] t + c[2] t^2 ...
template <std::size_t n>
HWY_INLINE F polynomial(const float (&c)[n], F t)
{
    F sum = set(c[n - 1]);
    for (std::size_t i = n - 1; i-- > 0;) sum = mul_add(sum, t, set(c[i]));
    return sum;
}

/// log2 of x, a normal number above zero. Of zero: about -127.
HWY_INLINE F binary_log(F x)
{
    // x = 2^k m, m from the root of a half to that of two; log2 m is odd in s = (m - 1)/(m + 1), below 0.172.
    constexpr float k_series[] = {2.8853900798f, 0.96179883881f, 0.57671518602f, 0.43171769746f};
    const I bits = hn::BitCast(di, x), k = hn::ShiftRight<23>(hn::Sub(bits, set_int(0x3f3504f3)));
    const F m = hn::BitCast(df, hn::Sub(bits, hn::ShiftLeft<23>(k))), one = set(1.f);
    const F s = hn::Div(hn::Sub(m, one), hn::Add(m, one));
    return mul_add(s, polynomial(k_series, hn::Mul(s, s)), to_float(k));
}

/// 2^y; y below -126 counts as that, above 126 too.
HWY_INLINE F binary_power(F y)
{
    constexpr float k_series[] = {1.f, 0.693147188f, 0.240226508f, 0.0555035711f, 0.0096180826f, 0.00133908634f, 0.000154531629f};
    const F within = smaller(larger(y, set(-126.f)), set(126.f));
    // Rounding by truncation alone, which is the same everywhere.
    const I k = hn::Sub(truncate(hn::Add(within, set(128.5f))), set_int(128));
    const F power = polynomial(k_series, hn::Sub(within, to_float(k)));
    return hn::BitCast(df, hn::Add(hn::BitCast(di, power), hn::ShiftLeft<23>(k)));
}

/// x^e, x not negative.
HWY_INLINE F power(F x, F e) { return binary_power(hn::Mul(e, binary_log(x))); }

struct SineCosine {
    F sine, cosine;
};
/// Sine and cosine of angles from -3 pi to 3 pi.
HWY_INLINE SineCosine sine_cosine(F angle)
{
    constexpr float k_sine[] = {-0.166666646f, 0.00833273656f, -0.000195853732f},
                    k_cosine[] = {-0.49999999968f, 0.04166665016f, -0.00138875631f, 2.44604322e-5f};
    // Less whole right angles, in two parts.
    const I right = hn::Sub(truncate(mul_add(angle, set(0.636619772f), set(8.5f))), set_int(8));
    const F count = to_float(right);
    const F r = hn::Sub(hn::Sub(angle, hn::Mul(count, set(1.5703125f))), hn::Mul(count, set(4.83826794897e-4f))),
            t = hn::Mul(r, r);
    const F sine = mul_add(hn::Mul(r, t), polynomial(k_sine, t), r), cosine = mul_add(t, polynomial(k_cosine, t), set(1.f));
    const auto bit = [&](I v, int k) { return equal(hn::And(v, set_int(k)), set_int(k)); };
    const M odd = bit(right, 1);
    const F s = blend(odd, cosine, sine), c = blend(odd, sine, cosine);
    return {blend(bit(right, 2), hn::Neg(s), s), blend(bit(hn::Add(right, set_int(1)), 2), hn::Neg(c), c)};
}

/// The angle of (x, y), from -pi to pi; of (0, 0) zero.
HWY_INLINE F angle_of(F y, F x)
{
    constexpr float k_series[] = {0.99999998f,    -0.33333037f,  0.19991872f,    -0.14197798f,  0.10618371f,
                                  -0.0745685483f, 0.0421376236f, -0.0157312491f, 0.00276628350f};
    const F ax = hn::Abs(x), ay = hn::Abs(y);
    const M steep = hn::Gt(ay, ax);
    const F ratio = hn::Div(smaller(ax, ay), larger(larger(ax, ay), set(1e-30f)));
    F angle = hn::Mul(ratio, polynomial(k_series, hn::Mul(ratio, ratio)));
    angle = blend(steep, hn::Sub(set(0.5f * k_pi), angle), angle);
    angle = blend(hn::Lt(x, hn::Zero(df)), hn::Sub(set(k_pi), angle), angle);
    return blend(hn::Lt(y, hn::Zero(df)), hn::Neg(angle), angle);
}

HWY_INLINE F length(const V3& v) { return hn::Sqrt(dot(v, v)); }
HWY_INLINE V3 plus(const V3& a, const V3& b) { return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)}; }
/// v scaled to unit length; a zero vector stays finite.
HWY_INLINE V3 unit_of(const V3& v) { return scaled(hn::Div(set(1.f), larger(length(v), set(1e-18f))), v); }

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
