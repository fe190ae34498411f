// Vectors of as many points as the machine takes at once, at most k_max_lanes: compiled for each instruction set by Highway
// (J. Wassenberg et al.), without fused multiply-add, so that all give the same bits.
#if defined(SQMAP_MATH_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_MATH_LANES_INL_H
#undef SQMAP_MATH_LANES_INL_H
#else
#define SQMAP_MATH_LANES_INL_H
#endif

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace sqmap::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t k_max_lanes = 16;
using DF = hn::CappedTag<float, k_max_lanes>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using F = hn::Vec<DF>;
using I = hn::Vec<DI>;
using M = hn::Mask<DF>;
constexpr DF df{};
constexpr DI di{};
constexpr DU du{};
constexpr std::size_t k_lanes = hn::MaxLanes(DF());

HWY_INLINE F set(float v) { return hn::Set(df, v); }
HWY_INLINE I set_int(std::int32_t v) { return hn::Set(di, v); }
HWY_INLINE I set_word(std::uint32_t v) { return hn::Set(di, static_cast<std::int32_t>(v)); }
#if HWY_TARGET == HWY_WASM
// In plain operators: the compiler simplifies these where it knows an operand, as it does not with the intrinsic.
template <class V>
HWY_INLINE V blend(M m, V yes, V no)
{
    const auto mask = static_cast<v128_t>(m.raw);
    return V{static_cast<decltype(V::raw)>((mask & static_cast<v128_t>(yes.raw)) | (~mask & static_cast<v128_t>(no.raw)))};
}
#else
HWY_INLINE F blend(M m, F yes, F no) { return hn::IfThenElse(m, yes, no); }
HWY_INLINE I blend(M m, I yes, I no) { return hn::IfThenElse(hn::RebindMask(di, m), yes, no); }
#endif
HWY_INLINE M equal(I a, I b) { return hn::RebindMask(df, hn::Eq(a, b)); }
HWY_INLINE M not_negative(I a) { return hn::RebindMask(df, hn::Gt(a, set_int(-1))); }
HWY_INLINE M none() { return hn::Ne(hn::Zero(df), hn::Zero(df)); }
#if HWY_TARGET == HWY_WASM  // Highway 1.0.3 takes lanes out one by one for these
HWY_INLINE bool any(M m) { return wasm_v128_any_true(static_cast<v128_t>(m.raw)); }
#else
HWY_INLINE bool any(M m) { return !hn::AllFalse(df, m); }
#endif
HWY_INLINE F mul_add(F a, F b, F c) { return hn::Add(hn::Mul(a, b), c); }
HWY_INLINE I truncate(F v) { return hn::ConvertTo(di, v); }
HWY_INLINE F to_float(I v) { return hn::ConvertTo(df, v); }
template <int k>
HWY_INLINE I shift_right(I v)
{
    return hn::BitCast(di, hn::ShiftRight<k>(hn::BitCast(du, v)));
}

/// Two neighbouring 16-bit values from an index on, the first in the low half. Reading past an array's last value is safe:
/// something always follows it in a parsed model's blob.
HWY_INLINE I gather_pair(const std::uint16_t* base, I index)
{
    return hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(base), hn::Add(index, index));
}
HWY_INLINE I gather_word(const std::uint32_t* base, I index)
{
    return hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(base), index);
}
/// A byte of an array that is padded to whole words.
HWY_INLINE I gather_byte(const std::uint8_t* base, I index)
{
    const I word = hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(base), shift_right<2>(index));
    return hn::And(hn::Shr(word, hn::ShiftLeft<3>(hn::And(index, set_int(3)))), set_int(0xff));
}
/// The bits of a mask, lane 0 lowest.
HWY_INLINE std::uint64_t bits_of(M mask)
{
#if HWY_TARGET == HWY_WASM
    return wasm_i32x4_bitmask(static_cast<v128_t>(mask.raw));
#else
    HWY_ALIGN std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(df, mask, bytes);
    std::uint64_t bits;
    std::memcpy(&bits, bytes, sizeof(bits));
    return bits;
#endif
}
HWY_INLINE std::size_t count_of(M mask)
{
#if HWY_TARGET == HWY_WASM
    return static_cast<std::size_t>(std::popcount(bits_of(mask)));
#else
    return hn::CountTrue(df, mask);
#endif
}

#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
/// For each mask, the order of lanes that puts the lanes of the mask first; half of it serves half as many lanes.
alignas(64) constexpr auto k_first_lanes = [] {
    std::array<std::array<std::uint8_t, 8>, 256> order{};
    for (std::size_t bits = 0; bits < order.size(); ++bits) {
        std::size_t count = 0;
        for (const std::size_t chosen : {1u, 0u})
            for (std::uint8_t i = 0; i < 8; ++i)
                if ((bits >> i & 1u) == chosen) order[bits][count++] = i;
    }
    return order;
}();
/// The lanes of a mask side by side. hn::Compress copies such a table to the stack for each vector there.
template <class V>
HWY_INLINE V compress(V values, M which)
{
    static_assert(k_lanes <= 8);
    const I order = hn::PromoteTo(di, hn::LoadU(hn::Rebind<std::uint8_t, DI>(), k_first_lanes[bits_of(which)].data()));
    return hn::TableLookupLanes(values, hn::IndicesFromVec(hn::DFromV<V>(), order));
}
#elif HWY_TARGET == HWY_WASM
alignas(16) constexpr auto k_first_bytes = [] {
    std::array<std::array<std::uint8_t, 16>, 16> order{};
    for (std::size_t bits = 0; bits < order.size(); ++bits) {
        std::size_t count = 0;
        for (const std::size_t chosen : {1u, 0u})
            for (std::size_t i = 0; i < 16; ++i)
                if ((bits >> (i / 4) & 1u) == chosen) order[bits][count++] = static_cast<std::uint8_t>(i);
    }
    return order;
}();
/// The lanes of a mask side by side.
template <class V>
HWY_INLINE V compress(V values, M which)
{
    const v128_t order = wasm_v128_load(k_first_bytes[bits_of(which)].data());
    return hn::BitCast(hn::DFromV<V>(),
                       I{static_cast<decltype(I::raw)>(wasm_i8x16_swizzle(static_cast<v128_t>(values.raw), order))});
}
#else
/// The lanes of a mask side by side.
template <class V>
HWY_INLINE V compress(V values, M which)
{
    return hn::Compress(values, hn::RebindMask(hn::DFromV<V>(), which));
}
#endif
/// The same in memory; the rest of a vector behind them is overwritten. Not by storing and compressing in one, which some
/// processors do lane by lane.
HWY_INLINE void pack(F values, M which, float* to) { hn::StoreU(compress(values, which), df, to); }
HWY_INLINE void pack(I values, M which, std::int32_t* to) { hn::StoreU(compress(values, which), di, to); }
HWY_INLINE I low(I pair) { return hn::And(pair, set_int(0xffff)); }
HWY_INLINE I high(I pair) { return shift_right<16>(pair); }

struct V3 {
    F x, y, z;
};
HWY_INLINE V3 blend(M m, const V3& yes, const V3& no)
{
    return {blend(m, yes.x, no.x), blend(m, yes.y, no.y), blend(m, yes.z, no.z)};
}
HWY_INLINE F dot(const V3& a, const V3& b) { return mul_add(a.x, b.x, mul_add(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE F row_dot(const float* r, const V3& v)
{
    return mul_add(set(r[0]), v.x, mul_add(set(r[1]), v.y, hn::Mul(set(r[2]), v.z)));
}

HWY_INLINE V3 scaled(F k, const V3& v) { return {hn::Mul(k, v.x), hn::Mul(k, v.y), hn::Mul(k, v.z)}; }
HWY_INLINE V3 times(const V3& a, const V3& b) { return {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)}; }
HWY_INLINE V3 minus(const V3& a, const V3& b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }
HWY_INLINE V3 cross(const V3& a, const V3& b)
{
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

/// The lanes of a mask one by one.
template <class Do>
HWY_INLINE void each_lane(M mask, Do&& action)
{
    for (std::uint64_t bits = bits_of(mask); bits != 0; bits &= bits - 1)
        action(static_cast<std::size_t>(std::countr_zero(bits)));
}

}  // namespace
}  // namespace sqmap::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
