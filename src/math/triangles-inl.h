// Many points against one triangle after another: what every point needs of a triangle is worked out once, a vector of triangles
// at a time.
#if defined(SQMAP_MATH_TRIANGLES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_MATH_TRIANGLES_INL_H
#undef SQMAP_MATH_TRIANGLES_INL_H
#else
#define SQMAP_MATH_TRIANGLES_INL_H
#endif

#include "math/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::HWY_NAMESPACE {
namespace {

HWY_INLINE V3 plus_scaled(F k, const V3& v, const V3& to)
{
    return {mul_add(k, v.x, to.x), mul_add(k, v.y, to.y), mul_add(k, v.z, to.z)};
}

/// Triangles a, b, c in columns.
class TriangleBlock {
public:
    static constexpr std::size_t k_max = 64;

    /// Lanes of corners into columns from at on.
    HWY_INLINE void put(std::size_t at, const V3& p, const V3& q, const V3& r)
    {
        // Turned so that ab is the shortest side: between two long ones a sliver's digits cancel.
        const V3 pq = minus(q, p), qr = minus(r, q), rp = minus(p, r);
        const F pq_sq = dot(pq, pq), qr_sq = dot(qr, qr), rp_sq = dot(rp, rp);
        const M from_q = hn::And(hn::Lt(qr_sq, pq_sq), hn::Le(qr_sq, rp_sq)), from_r = hn::AndNot(from_q, hn::Lt(rp_sq, pq_sq));
        const V3 a = blend(from_q, q, blend(from_r, r, p)), b = blend(from_q, r, blend(from_r, p, q)),
                 c = blend(from_q, p, blend(from_r, q, r));
        const F one = set(1.f), tiny = set(1e-30f);
        const V3 ab = minus(b, a), ac = minus(c, a), bc = minus(c, b), n = cross(ab, ac);
        const F bb = dot(ab, ab), cc = dot(ac, ac), bc_sq = dot(bc, bc), b_dot_c = dot(ab, ac), n_sq = dot(n, n);
        const M has_area = hn::Gt(n_sq, hn::Max(hn::Mul(hn::Mul(bb, cc), set(1e-11f)), tiny));
        const auto inverse_root = [&](F value) {
            return hn::IfThenElseZero(hn::Gt(value, tiny), hn::Div(one, hn::Sqrt(hn::Max(value, tiny))));
        };
        const F over_b = inverse_root(bb), over_c = inverse_root(cc), over_bc = inverse_root(bc_sq),
                over_n = hn::IfThenElseZero(has_area, inverse_root(n_sq));
        // In the plane, at right angles to ac and to ab; v and w of a point a + v ab + w ac are its distances along them times
        // sizes.
        const V3 v_unit = scaled(hn::Mul(over_n, over_c), minus(scaled(cc, ab), scaled(b_dot_c, ac))),
                 w_unit = scaled(hn::Mul(over_n, over_b), minus(scaled(bb, ac), scaled(b_dot_c, ab)));
        const F v_size = hn::Mul(hn::Mul(cc, over_c), over_n), w_size = hn::Mul(hn::Mul(bb, over_b), over_n),
                over_u = hn::Mul(hn::Mul(n_sq, over_n), over_bc);
        const V3 normal = scaled(over_n, n);
        const F values[k_fields] = {a.x,
                                    a.y,
                                    a.z,
                                    ab.x,
                                    ab.y,
                                    ab.z,
                                    ac.x,
                                    ac.y,
                                    ac.z,
                                    normal.x,
                                    normal.y,
                                    normal.z,
                                    v_unit.x,
                                    v_unit.y,
                                    v_unit.z,
                                    w_unit.x,
                                    w_unit.y,
                                    w_unit.z,
                                    bc.x,
                                    bc.y,
                                    bc.z,
                                    hn::Mul(over_b, over_b),
                                    hn::Mul(over_c, over_c),
                                    hn::Mul(over_bc, over_bc),
                                    dot(ab, bc),
                                    v_size,
                                    w_size,
                                    over_u,
                                    hn::IfThenElse(has_area, one, hn::Neg(one))};
        for (std::size_t k = 0; k < k_fields; ++k) hn::StoreU(values[k], df, columns_[k] + at);
    }

    /// Position of points relative to triangle i.
    struct Position {
        V3 ap;             // from a
        F height;          // above the plane
        F v_side, w_side;  // distance from the edges ac and ab, positive within
        F lower_sq;        // no point of the triangle is nearer than its square root
        M above;           // or below: the foot on the plane is in the triangle
    };
    HWY_INLINE Position position(std::size_t i, const V3& p) const
    {
        Position q;
        q.ap = minus(p, vector(k_a, i));
        q.height = dot(q.ap, vector(k_normal, i));
        q.v_side = dot(q.ap, vector(k_v, i));
        q.w_side = dot(q.ap, vector(k_w, i));
        const F rest = hn::Sub(field(k_area, i), mul_add(field(k_v_size, i), q.v_side, hn::Mul(field(k_w_size, i), q.w_side)));
        const F least = hn::Min(hn::Min(q.v_side, q.w_side), hn::Mul(rest, field(k_over_u, i)));
        q.above = hn::And(hn::Ge(least, hn::Zero(df)), hn::Ge(rest, hn::Zero(df)));
        const F beyond = hn::Min(least, hn::Zero(df));
        q.lower_sq = mul_add(q.height, q.height, hn::Mul(beyond, beyond));
        return q;
    }

    /// To the nearest point of the triangle, from the point.
    HWY_INLINE V3 to_face(std::size_t i, const Position& q) const
    {
        const F v = hn::Mul(field(k_v_size, i), q.v_side), w = hn::Mul(field(k_w_size, i), q.w_side);
        return minus(plus_scaled(v, vector(k_ab, i), scaled(w, vector(k_ac, i))), q.ap);
    }
    HWY_INLINE V3 to_edges(std::size_t i, const Position& q, F& distance_sq) const
    {
        const F zero = hn::Zero(df), one = set(1.f);
        const auto clamped = [&](F t) { return hn::Min(hn::Max(t, zero), one); };
        const V3 ab = vector(k_ab, i), ac = vector(k_ac, i), bc = vector(k_bc, i);
        V3 best = minus(scaled(clamped(hn::Mul(dot(q.ap, ab), field(k_over_bb, i))), ab), q.ap);
        distance_sq = dot(best, best);
        const auto offer = [&](const V3& offset) {
            const F d = dot(offset, offset);
            const M nearer = hn::Lt(d, distance_sq);
            distance_sq = blend(nearer, d, distance_sq);
            best = blend(nearer, offset, best);
        };
        offer(minus(scaled(clamped(hn::Mul(dot(q.ap, ac), field(k_over_cc, i))), ac), q.ap));
        const F along = clamped(hn::Mul(hn::Sub(dot(q.ap, bc), field(k_ab_bc, i)), field(k_over_bc, i)));
        offer(minus(plus_scaled(along, bc, ab), q.ap));
        return best;
    }

    Vec3f normal(std::size_t i) const { return {columns_[k_normal][i], columns_[k_normal + 1][i], columns_[k_normal + 2][i]}; }

private:
    enum Field : std::size_t {
        k_a = 0,
        k_ab = 3,
        k_ac = 6,
        k_normal = 9,
        k_v = 12,
        k_w = 15,
        k_bc = 18,
        k_over_bb = 21,
        k_over_cc,
        k_over_bc,
        k_ab_bc,
        k_v_size,
        k_w_size,
        k_over_u,
        k_area,  // 1, without area -1
        k_fields
    };

    HWY_INLINE F field(std::size_t k, std::size_t i) const { return set(columns_[k][i]); }
    HWY_INLINE V3 vector(std::size_t k, std::size_t i) const { return {field(k, i), field(k + 1, i), field(k + 2, i)}; }

    HWY_ALIGN float columns_[k_fields][k_max + k_lanes];
};

}  // namespace
}  // namespace sqmap::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
