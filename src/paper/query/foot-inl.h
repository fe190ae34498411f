// The foot point of eq. 20 by Newton's method, many points at a time: as shape/foot_point.h has it, in the superquadric's own
// frame.
#if defined(SQMAP_PAPER_FOOT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_PAPER_FOOT_INL_H
#undef SQMAP_PAPER_FOOT_INL_H
#else
#define SQMAP_PAPER_FOOT_INL_H
#endif

#include "paper/query/foot_record.h"
#include "query/superquadric/surface-inl.h"

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

struct FootLanes {
    PositionLanes position;
    SurfaceLanes at;
    F miss;  // length of the part of p - point that is not along the normal
};

/// Steps, and the tangential miss at which the search stops, of the largest semi-axis: well below a cell, above float rounding.
struct NewtonLimits {
    int max_iterations = 10;
    float tolerance = 1e-5f;
};
constexpr float k_proven_miss = 1e-3f;
/// Twice the rounding of a position, of the largest semi-axis.
constexpr float k_rounded_twice = 8 * std::numeric_limits<float>::epsilon();

/// p - point, split into its components along and across the normal.
struct LineToFoot {
    V3 across;
    F depth, miss;

    HWY_INLINE LineToFoot(const V3& q, const SurfaceLanes& at)
    {
        const V3 d = minus(q, at.point);
        depth = hn::Neg(dot(d, at.normal));
        across = plus(d, scaled(depth, at.normal));
        miss = length(across);
    }
};

/// The step in the tangent plane to where the quadratic model of the distance is least; the tangential miss itself where the
/// model has no minimum.
HWY_INLINE V3 newton_step(const SuperquadricLanes& sq, const PositionLanes& position, const LineToFoot& line)
{
    const JetLanes jet = sq.jet(position);
    const F zero = hn::Zero(df);
    const V3 eu = minus(jet.point_eta, scaled(line.depth, jet.normal_eta)),
             ev = minus(jet.point_omega, scaled(line.depth, jet.normal_omega));
    const F huu = dot(jet.point_eta, eu), hvv = dot(jet.point_omega, ev);
    const F huv = hn::Mul(set(0.5f), hn::Add(dot(jet.point_eta, ev), dot(jet.point_omega, eu)));
    const F bu = dot(jet.point_eta, line.across), bv = dot(jet.point_omega, line.across);
    const F product = hn::Mul(huu, hvv), determinant = hn::Sub(product, hn::Mul(huv, huv));
    const M regular = hn::And(hn::Gt(huu, zero), hn::Gt(determinant, hn::Mul(set(1e-6f), hn::Abs(product))));
    const F inverse = hn::Div(set(1.f), blend(regular, determinant, set(1.f)));
    const F u = hn::Mul(inverse, hn::Sub(hn::Mul(hvv, bu), hn::Mul(huv, bv))),
            v = hn::Mul(inverse, hn::Sub(hn::Mul(huu, bv), hn::Mul(huv, bu)));
    V3 step = plus(scaled(u, jet.point_eta), scaled(v, jet.point_omega));
    const F size = set(sq.size()), long_step = length(step);
    step = blend(hn::Gt(long_step, size), scaled(hn::Div(size, larger(long_step, size)), step), step);
    return blend(regular, step, line.across);
}

/// From a position near the foot of q on, for the lanes of a mask. record: told of every position.
template <class Record = NoRecord>
HWY_NOINLINE FootLanes polished_foot(const SuperquadricLanes& sq, const V3& q, FootLanes foot, M active,
                                     const NewtonLimits& limits, Record record = {})
{
    record.position(foot.position);
    const F tolerance = set(limits.tolerance * sq.size());
    LineToFoot line(q, foot.at);
    const V3 first = minus(q, foot.at.point);
    F distance_sq = dot(first, first);
    for (int iteration = 0; iteration < limits.max_iterations; ++iteration) {
        active = hn::And(active, hn::Gt(line.miss, tolerance));
        if (!any(active)) break;
        V3 step = newton_step(sq, foot.position, line);
        M left = active;
        // The distance is flat at its minimum: there the miss decides, up to what rounding of positions leaves of the distance.
        const F max_sq = mul_add(set(k_rounded_twice * sq.size()), hn::Add(hn::Abs(line.depth), line.miss),
                                 hn::Mul(distance_sq, set(1.f + 1e-6f)));
        // A step that would not shorten the line is halved.
        for (int halving = 0; halving < 4 && any(left); ++halving) {
            F gauge;
            const PositionLanes position = sq.through(sq.to_unit(plus(foot.at.point, step)), gauge);
            const SurfaceLanes next = sq.surface(position);
            const V3 d = minus(q, next.point);
            const F next_sq = dot(d, d);
            const M moved = hn::And(left, hn::Le(next_sq, max_sq));
            foot.position = blend(moved, position, foot.position);
            foot.at = {blend(moved, next.point, foot.at.point), blend(moved, next.normal, foot.at.normal)};
            distance_sq = blend(moved, next_sq, distance_sq);
            left = hn::AndNot(moved, left);
            step = scaled(set(0.5f), step);
        }
        active = hn::AndNot(left, active);
        line = LineToFoot(q, foot.at);
        record.position(foot.position);
    }
    foot.miss = line.miss;
    return foot;
}

HWY_NOINLINE FootLanes foot_at(const SuperquadricLanes& sq, const PositionLanes& position)
{
    return {position, sq.surface(position), set(0.f)};
}

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
