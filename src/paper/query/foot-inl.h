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

HWY_BEFORE_NAMESPACE();
namespace sqmap::paper::HWY_NAMESPACE {
using namespace query::HWY_NAMESPACE;
namespace {

struct FootLanes {
    PositionLanes position;
    SurfaceLanes at;
    F miss;  // length of the part of p - point that is not along the normal
};

/// Steps and trials of them, and the tangential miss at which the search stops, of the largest semi-axis: well below a cell,
/// above float rounding.
struct NewtonLimits {
    float max_steps = 10;
    float tolerance = 1e-5f;
    int max_trials = 40;
};
constexpr float k_proven_miss = 1e-3f;

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

/// How far Newton's method has come, whole numbers.
struct NewtonProgress {
    F steps;     // taken
    F halvings;  // of the next one
};

/// From a position near the foot of q on, for the lanes of a mask; left of it are those that could go on after so many trials. A
/// step that would not shorten the line is tried again by half, beside the next steps of other lanes. record: told of every
/// position.
template <class Record = NoRecord>
HWY_NOINLINE FootLanes polished_foot(const SuperquadricLanes& sq, const V3& q, FootLanes foot, M& active, NewtonProgress& done,
                                     const NewtonLimits& limits, Record record = {})
{
    constexpr float k_max_halvings = 4;
    record.position(foot.position);
    const F tolerance = set(limits.tolerance * sq.size()), one = set(1.f);
    LineToFoot line(q, foot.at);
    const V3 first = minus(q, foot.at.point);
    F distance_sq = dot(first, first);
    active = hn::And(active, hn::Gt(line.miss, tolerance));
    for (int trial = 0; trial < limits.max_trials && any(active); ++trial) {
        V3 step = newton_step(sq, foot.position, line);
        const I exponent = hn::Sub(set_int(127), hn::ConvertTo(di, done.halvings));
        step = scaled(hn::BitCast(df, hn::ShiftLeft<23>(exponent)), step);
        F gauge;
        const PositionLanes position = sq.through(sq.to_unit(plus(foot.at.point, step)), gauge);
        const SurfaceLanes next = sq.surface(position);
        const V3 d = minus(q, next.point);
        const F next_sq = dot(d, d);
        // The distance is flat at its minimum: there the miss decides, up to what rounding leaves of it.
        const M moved = hn::And(active, hn::Le(next_sq, hn::Mul(distance_sq, set(1.f + 1e-6f))));
        foot.position = blend(moved, position, foot.position);
        foot.at = {blend(moved, next.point, foot.at.point), blend(moved, next.normal, foot.at.normal)};
        distance_sq = blend(moved, next_sq, distance_sq);
        done.steps = hn::Add(done.steps, hn::IfThenElseZero(moved, one));
        done.halvings = hn::IfThenZeroElse(moved, hn::Add(done.halvings, one));
        line = LineToFoot(q, foot.at);
        active = hn::And(hn::And(active, hn::Gt(line.miss, tolerance)),
                         hn::And(hn::Lt(done.steps, set(limits.max_steps)), hn::Lt(done.halvings, set(k_max_halvings))));
        if (any(moved)) record.position(foot.position);
    }
    foot.miss = line.miss;
    return foot;
}

/// The same to its end.
template <class Record = NoRecord>
HWY_INLINE FootLanes polished_foot(const SuperquadricLanes& sq, const V3& q, const FootLanes& foot, M active,
                                   const NewtonLimits& limits = {}, Record record = {})
{
    NewtonProgress done{hn::Zero(df), hn::Zero(df)};
    return polished_foot(sq, q, foot, active, done, limits, record);
}

HWY_NOINLINE FootLanes foot_at(const SuperquadricLanes& sq, const PositionLanes& position)
{
    return {position, sq.surface(position), set(0.f)};
}

}  // namespace
}  // namespace sqmap::paper::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
