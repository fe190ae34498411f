// Distances to triangles, each in a frame of its own: two axes in its plane, one along its longest side, and its normal.
// Triangles for one point, or points for one triangle, side by side: the same bits.
#if defined(SQMAP_QUERY_TRIANGLE_FRAMES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_TRIANGLE_FRAMES_INL_H
#undef SQMAP_QUERY_TRIANGLE_FRAMES_INL_H
#else
#define SQMAP_QUERY_TRIANGLE_FRAMES_INL_H
#endif

#include "math/lanes-inl.h"

#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

constexpr float k_flat = 0.0025f;  // squared height over squared distance of what is seen too much from the side

HWY_INLINE V3 minus_scaled(const V3& from, F k, const V3& v)
{
    return {hn::Sub(from.x, hn::Mul(k, v.x)), hn::Sub(from.y, hn::Mul(k, v.y)), hn::Sub(from.z, hn::Mul(k, v.z))};
}

/// Up to 16 triangles in columns: a at the origin, b on the first axis, c beside it.
class TriangleFrames {
public:
    static constexpr std::size_t k_size = 16;

    /// Lanes of corners into columns from at on.
    HWY_INLINE void put(std::size_t at, const V3& p, const V3& q, const V3& r)
    {
        // Turned so that ab is the longest side: whatever the triangle, the foot of c is on it.
        const V3 pq = minus(q, p), qr = minus(r, q), rp = minus(p, r);
        const F pq_sq = dot(pq, pq), qr_sq = dot(qr, qr), rp_sq = dot(rp, rp);
        const M from_q = hn::And(hn::Gt(qr_sq, pq_sq), hn::Ge(qr_sq, rp_sq)), from_r = hn::AndNot(from_q, hn::Gt(rp_sq, pq_sq));
        const V3 a = blend(from_q, q, blend(from_r, r, p)), ab = blend(from_q, qr, blend(from_r, rp, pq)),
                 ca = blend(from_q, pq, blend(from_r, qr, rp)), ac{hn::Neg(ca.x), hn::Neg(ca.y), hn::Neg(ca.z)};
        const F zero = hn::Zero(df), one = set(1.f), tiny = set(k_tiny);
        const F length = hn::Sqrt(hn::Max(hn::Max(pq_sq, qr_sq), rp_sq));
        const V3 along = blend(hn::Gt(length, tiny), unit(ab, length), {one, zero, zero});
        const V3 rise = beside(ac, along);
        const M has_area = hn::Gt(dot(rise, rise), hn::Max(hn::Mul(dot(ac, ac), set(1e-11f)), tiny));
        // Any direction beside a triangle without area.
        const M steep = hn::Gt(hn::Abs(along.x), set(0.6f));
        const V3 side = blend(has_area, rise, beside({blend(steep, zero, one), blend(steep, one, zero), zero}, along));
        // Twice, as digits cancel in a narrow triangle.
        const V3 again = beside(unit(side, norm(side)), along), across = unit(again, norm(again));
        const F c_u = dot(ac, along), c_v = hn::IfThenElseZero(has_area, dot(ac, across)), bc_u = hn::Sub(c_u, length);
        const F ac_length = norm(c_u, c_v), bc_length = norm(bc_u, c_v);
        // For a side without length any direction serves.
        const auto over = [&](F v, F size, float otherwise)
                              HWY_ATTR { return blend(hn::Gt(size, tiny), hn::Div(v, hn::Max(size, tiny)), set(otherwise)); };
        const V3 normal = cross(along, across);
        const F values[k_fields] = {a.x,
                                    a.y,
                                    a.z,
                                    along.x,
                                    along.y,
                                    along.z,
                                    across.x,
                                    across.y,
                                    across.z,
                                    normal.x,
                                    normal.y,
                                    normal.z,
                                    length,
                                    over(c_u, ac_length, 1),
                                    over(c_v, ac_length, 0),
                                    ac_length,
                                    over(bc_u, bc_length, -1),
                                    over(c_v, bc_length, 0),
                                    bc_length,
                                    blend(has_area, set(k_flat), set(2.f))};
        for (std::size_t k = 0; k < k_fields; ++k) hn::Store(values[k], df, columns_[k] + at);
    }

    /// The coordinates of a point in a triangle's frame.
    struct Foot {
        F u, v, height;
        F within_ac, within_bc;  // distance of the foot from these sides' lines, positive on the triangle's side
        F within;                // from the nearest of the three
        F height_sq;
    };
    /// A foot's distance, and the side from which it is seen.
    struct Seen {
        F distance_sq;
        M above;  // or below: the foot is in the triangle
        M flat;   // too near to the plane, or the triangle without area, to say on which side
    };

    /// Many points, triangle i.
    HWY_INLINE Foot foot_one(std::size_t i, const V3& p) const { return foot(One{columns_, i}, p); }
    HWY_INLINE Seen see_one(std::size_t i, const Foot& f) const { return see(One{columns_, i}, f); }
    /// Point k and triangle first + k, for every lane.
    HWY_INLINE Foot foot_each(std::size_t first, const V3& p) const { return foot(Each{columns_, first}, p); }
    HWY_INLINE Seen see_each(std::size_t first, const Foot& f) const { return see(Each{columns_, first}, f); }

    /// From point k to the nearest point of triangle first + k.
    HWY_INLINE V3 offset_each(std::size_t first, const Foot& f, const Seen& s) const
    {
        const Each field{columns_, first};
        const Planar ab = to_ab(field, f), ac = to_ac(field, f), bc = to_bc(field, f);
        const F ac_u = hn::Mul(ac.at, field(k_ac_u)), ac_v = hn::Mul(ac.at, field(k_ac_v));
        const F bc_u = mul_add(bc.at, field(k_bc_u), field(k_length)), bc_v = hn::Mul(bc.at, field(k_bc_v));
        const M by_ac = hn::Lt(ac.distance_sq, ab.distance_sq);
        const M by_bc = hn::Lt(bc.distance_sq, hn::Min(ab.distance_sq, ac.distance_sq));
        const F u = blend(by_bc, bc_u, blend(by_ac, ac_u, ab.at)), v = blend(by_bc, bc_v, blend(by_ac, ac_v, hn::Zero(df)));
        const F du = hn::IfThenZeroElse(s.above, hn::Sub(u, f.u)), dv = hn::IfThenZeroElse(s.above, hn::Sub(v, f.v));
        const auto component = [&](std::size_t k) HWY_ATTR {
            return hn::Sub(mul_add(du, field(k_along + k), hn::Mul(dv, field(k_across + k))),
                           hn::Mul(f.height, field(k_normal + k)));
        };
        return {component(0), component(1), component(2)};
    }

private:
    enum Field : std::size_t {
        k_a = 0,
        k_along = 3,
        k_across = 6,
        k_normal = 9,
        k_length = 12,
        k_ac_u,
        k_ac_v,
        k_ac_length,
        k_bc_u,
        k_bc_v,
        k_bc_length,
        k_flat_share,
        k_fields
    };
    static constexpr float k_tiny = 1e-18f;

    static HWY_INLINE F norm(const V3& v) { return hn::Sqrt(dot(v, v)); }
    static HWY_INLINE F norm(F u, F v) { return hn::Sqrt(mul_add(u, u, hn::Mul(v, v))); }
    static HWY_INLINE V3 unit(const V3& v, F size) { return scaled(hn::Div(set(1.f), hn::Max(size, set(k_tiny))), v); }
    static HWY_INLINE V3 beside(const V3& v, const V3& along) { return minus_scaled(v, dot(v, along), along); }

    /// A field of one triangle for all lanes, or of a triangle for each.
    struct One {
        const float (&columns)[k_fields][k_size];
        std::size_t i;
        HWY_INLINE F operator()(std::size_t k) const { return set(columns[k][i]); }
    };
    struct Each {
        const float (&columns)[k_fields][k_size];
        std::size_t first;
        HWY_INLINE F operator()(std::size_t k) const { return hn::Load(df, columns[k] + first); }
    };
    template <class Get>
    static HWY_INLINE V3 vector(const Get& field, std::size_t k)
    {
        return {field(k), field(k + 1), field(k + 2)};
    }

    template <class Get>
    static HWY_INLINE Foot foot(const Get& field, const V3& p)
    {
        Foot f;
        const V3 ap = minus(p, vector(field, k_a));
        f.u = dot(ap, vector(field, k_along));
        f.v = dot(ap, vector(field, k_across));
        f.height = dot(ap, vector(field, k_normal));
        const F from_b = hn::Sub(f.u, field(k_length));
        f.within_ac = hn::Sub(hn::Mul(f.u, field(k_ac_v)), hn::Mul(f.v, field(k_ac_u)));
        f.within_bc = hn::Sub(hn::Mul(f.v, field(k_bc_u)), hn::Mul(from_b, field(k_bc_v)));
        f.within = hn::Min(hn::Min(f.v, f.within_ac), f.within_bc);
        f.height_sq = hn::Mul(f.height, f.height);
        return f;
    }

    /// To a side, in the plane.
    struct Planar {
        F distance_sq, at;  // at: along the side
    };
    static HWY_INLINE Planar to_side(F t, F s, F length)
    {
        const F at = hn::Min(hn::Max(t, hn::Zero(df)), length), beyond = hn::Sub(t, at);
        return {mul_add(beyond, beyond, hn::Mul(s, s)), at};
    }
    template <class Get>
    static HWY_INLINE Planar to_ab(const Get& field, const Foot& f)
    {
        return to_side(f.u, f.v, field(k_length));
    }
    template <class Get>
    static HWY_INLINE Planar to_ac(const Get& field, const Foot& f)
    {
        return to_side(mul_add(f.u, field(k_ac_u), hn::Mul(f.v, field(k_ac_v))), f.within_ac, field(k_ac_length));
    }
    template <class Get>
    static HWY_INLINE Planar to_bc(const Get& field, const Foot& f)
    {
        const F from_b = hn::Sub(f.u, field(k_length));
        return to_side(mul_add(from_b, field(k_bc_u), hn::Mul(f.v, field(k_bc_v))), f.within_bc, field(k_bc_length));
    }

    template <class Get>
    static HWY_INLINE Seen see(const Get& field, const Foot& f)
    {
        Seen s;
        const F beside_sq =
            hn::Min(hn::Min(to_ab(field, f).distance_sq, to_ac(field, f).distance_sq), to_bc(field, f).distance_sq);
        s.above = hn::Gt(f.within, hn::Zero(df));
        s.distance_sq = hn::Add(hn::IfThenZeroElse(s.above, beside_sq), f.height_sq);
        s.flat = hn::Le(f.height_sq, hn::Mul(field(k_flat_share), s.distance_sq));
        return s;
    }

    HWY_ALIGN float columns_[k_fields][k_size];
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
