// The nearest point of a triangle by the region of its plane that a point projects to (C. Ericson, Real-Time Collision Detection,
// 2005, 5.1.5), as foot_on_triangle computes it, without a branch.
#include "math/double_targets.h"  // before Highway

#include "query/distance/double_feet.h"

#include "math/triangle.h"

#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/distance/double_feet.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "math/double_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

/// A vector of pairs from one on.
class FeetOfPairs {
public:
    HWY_INLINE FeetOfPairs(DoubleFeet& feet, std::size_t first) : feet_(feet), first_(first)
    {
        a_ = load(feet.corner[0]);
        p_ = load(feet.point);
        const D3 b = load(feet.corner[1]), c = load(feet.corner[2]);
        ab_ = minus(b, a_);
        ac_ = minus(c, a_);
        const D3 ap = minus(p_, a_), bp = minus(p_, b), cp = minus(p_, c), bc = minus(c, b);
        const D d1 = dot(ab_, ap), d2 = dot(ac_, ap), d3 = dot(ab_, bp), d4 = dot(ac_, bp), d5 = dot(ab_, cp), d6 = dot(ac_, cp);
        const D va = product_difference(d3, d6, d5, d4), vb = product_difference(d5, d2, d1, d6),
                vc = product_difference(d1, d4, d3, d2);
        const D zero = hn::Zero(dd), beyond_b = hn::Sub(d4, d3), beyond_c = hn::Sub(d5, d6);
        const auto is_up = [&](D v) HWY_ATTR { return hn::Ge(v, zero); };
        const auto is_down = [&](D v) HWY_ATTR { return hn::Le(v, zero); };
        // The first region that holds the point counts. Far points see corners alone: nothing is divided for the others.
        const Mask at_a = hn::And(is_down(d1), is_down(d2)), at_b = hn::And(is_up(d3), hn::Le(d4, d3)),
                   on_ab = hn::And(is_down(vc), hn::And(is_up(d1), is_down(d3))), at_c = hn::And(is_up(d6), hn::Le(d5, d6)),
                   on_ac = hn::And(is_down(vb), hn::And(is_up(d2), is_down(d6))),
                   on_bc = hn::And(is_down(va), hn::And(is_up(beyond_b), is_up(beyond_c)));
        const Mask before_ab = hn::Or(at_a, at_b), after_c = hn::AndNot(at_c, hn::Or(on_ac, on_bc));
        const Mask on_side = hn::AndNot(before_ab, hn::Or(on_ab, after_c));
        const Mask on_face = hn::Not(hn::Or(hn::Or(before_ab, at_c), on_side));
        point_ = c;
        corners_ = hn::Set(dd, 4);
        if (!hn::AllFalse(dd, on_face)) offer_face(on_face, {va, vb, vc});
        if (!hn::AllFalse(dd, on_side)) {
            Side side{b, bc, beyond_b, hn::Add(beyond_b, beyond_c), hn::Set(dd, 6)};
            put(on_ac, {a_, ac_, d2, hn::Sub(d2, d6), hn::Set(dd, 5)}, side);
            put(on_ab, {a_, ab_, d1, hn::Sub(d1, d3), hn::Set(dd, 3)}, side);
            offer_side(on_side, side);
        }
        offer(at_b, b, hn::Set(dd, 2));
        offer(at_a, a_, hn::Set(dd, 1));
    }

    HWY_INLINE void store() const
    {
        const D3 offset = minus(point_, p_), across = cross(ab_, ac_);
        const D area = hn::Sqrt(dot(across, across)), zero = hn::Zero(dd);
        const D3 normal{hn::Div(across.x, area), hn::Div(across.y, area), hn::Div(across.z, area)};
        hn::Store(offset.x, dd, feet_.offset[0] + first_);
        hn::Store(offset.y, dd, feet_.offset[1] + first_);
        hn::Store(offset.z, dd, feet_.offset[2] + first_);
        const D distance_sq = dot(offset, offset), distance = hn::Sqrt(distance_sq);
        const D height = hn::IfThenElseZero(hn::Gt(area, zero), hn::Neg(dot(offset, normal)));
        hn::Store(distance_sq, dd, feet_.distance_sq + first_);
        hn::Store(distance, dd, feet_.distance + first_);
        hn::Store(height, dd, feet_.height + first_);
        hn::Store(hn::IfThenElseZero(hn::Gt(distance, zero), hn::Div(hn::Abs(height), distance)), dd, feet_.facing + first_);
        hn::Store(corners_, dd, feet_.corners + first_);
    }

private:
    using Mask = hn::Mask<DD>;
    struct Side {
        D3 from, along;
        D part, all;
        D corners;
    };

    HWY_INLINE D3 load(const double (&columns)[3][DoubleFeet::k_capacity]) const
    {
        return {hn::Load(dd, columns[0] + first_), hn::Load(dd, columns[1] + first_), hn::Load(dd, columns[2] + first_)};
    }
    static HWY_INLINE D product_difference(D a, D b, D c, D d) { return hn::Sub(hn::Mul(a, b), hn::Mul(c, d)); }
    static HWY_INLINE D3 plus_scaled(const D3& from, D k, const D3& v)
    {
        return {hn::Add(from.x, hn::Mul(k, v.x)), hn::Add(from.y, hn::Mul(k, v.y)), hn::Add(from.z, hn::Mul(k, v.z))};
    }
    static HWY_INLINE D3 choose(Mask where, const D3& yes, const D3& no)
    {
        return {hn::IfThenElse(where, yes.x, no.x), hn::IfThenElse(where, yes.y, no.y), hn::IfThenElse(where, yes.z, no.z)};
    }
    static HWY_INLINE void put(Mask where, const Side& side, Side& to)
    {
        to = {choose(where, side.from, to.from), choose(where, side.along, to.along), hn::IfThenElse(where, side.part, to.part),
              hn::IfThenElse(where, side.all, to.all), hn::IfThenElse(where, side.corners, to.corners)};
    }
    HWY_INLINE void offer(Mask where, const D3& point, D corners)
    {
        point_ = choose(where, point, point_);
        corners_ = hn::IfThenElse(where, corners, corners_);
    }
    HWY_INLINE void offer_face(Mask where, const D3& v)
    {
        constexpr double k_thin = 1e-12;
        const D sum = hn::Add(hn::Add(v.x, v.y), v.z);
        const D least = hn::Mul(hn::Mul(hn::Set(dd, k_thin), dot(ab_, ab_)), dot(ac_, ac_));
        offer(where, plus_scaled(plus_scaled(a_, hn::Div(v.y, sum), ab_), hn::Div(v.z, sum), ac_),
              hn::IfThenElseZero(hn::And(hn::Gt(sum, hn::Zero(dd)), hn::Gt(sum, least)), hn::Set(dd, 7)));
    }
    HWY_INLINE void offer_side(Mask where, const Side& side)
    {
        const D tiny = hn::Set(dd, std::numeric_limits<double>::min());
        const D all = hn::IfThenElse(hn::Lt(side.all, tiny), tiny, side.all);
        offer(where, plus_scaled(side.from, hn::Div(side.part, all), side.along), side.corners);
    }

    DoubleFeet& feet_;
    std::size_t first_;
    D3 p_, a_, ab_, ac_, point_;
    D corners_;
};

}  // namespace

/// All columns of whole vectors, but where triangles are as good as without area their corners are 0.
/// @pre first and count are multiples of eight
void find_feet(DoubleFeet& feet, std::size_t first, std::size_t count)
{
    for (std::size_t i = first; i < first + count; i += hn::Lanes(dd)) FeetOfPairs(feet, i).store();
}

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(find_feet);

void DoubleFeet::measure(std::size_t first, std::size_t count)
{
    constexpr std::size_t k_lanes = 8;
    const std::size_t begin = first / k_lanes * k_lanes, end = first + count;
    std::size_t filled = end;
    for (; filled % k_lanes != 0; ++filled) put(filled, vector(point, end - 1), triangle_of(end - 1));
    HWY_DYNAMIC_DISPATCH(find_feet)(*this, begin, filled - begin);
    for (std::size_t i = begin; i < end; ++i) {
        if (corners[i] != 0) continue;
        const std::array<Vec3d, 3> t = triangle_of(i);
        const Vec3d p = vector(point, i);
        const TriangleFoot foot = foot_on_triangle(p, t[0], t[1], t[2]);
        const Vec3d from_point = foot.point - p;
        put_vector(offset, i, from_point);
        distance_sq[i] = norm_sq(from_point);
        distance[i] = std::sqrt(distance_sq[i]);
        height[i] = -dot(from_point, normal_of_triangle(t[0], t[1], t[2]));
        facing[i] = distance[i] > 0 ? std::abs(height[i]) / distance[i] : 0;
        corners[i] = foot.corners;
    }
}

}  // namespace sqmap::query
#endif
