// Layer 1 of section 4.2, many points at a time: which of them a superquadric holds (eq. 1), and where they leave it.
#if defined(SQMAP_QUERY_SUPERQUADRIC_HELD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_SUPERQUADRIC_HELD_INL_H
#undef SQMAP_QUERY_SUPERQUADRIC_HELD_INL_H
#else
#define SQMAP_QUERY_SUPERQUADRIC_HELD_INL_H
#endif

#include "query/superquadric/surface-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Points that a superquadric holds.
struct HeldLanes {
    V3 q;               // its own frame
    V3 unit;            // undeformed, in units of the semi-axes
    PositionLanes own;  // where the point's own ray leaves the surface
    F gauge;            // F^(1/2)
};

/// Points from their undeformed source in units of the semi-axes: most are outside the box before any power is raised.
HWY_INLINE M in_box(const V3& unit)
{
    return hn::Le(larger(larger(hn::Abs(unit.x), hn::Abs(unit.y)), hn::Abs(unit.z)), set(1.f + k_gauge_error));
}
/// Evaluates eq. 1. A point so near the surface that rounding and powers leave its side open counts as held.
HWY_INLINE M holds(const SuperquadricLanes& sq, HeldLanes& point)
{
    point.own = sq.through(point.unit, point.gauge);
    return hn::Le(point.gauge, set(1.f + k_gauge_error));
}

/// The surface points on the points' own rays from the superquadric's centre; model space.
struct LeavingLanes {
    V3 point, normal;
    F distance;
};
HWY_INLINE LeavingLanes leaving(const SuperquadricLanes& sq, const V3& p, const PositionLanes& own)
{
    const SurfaceLanes s = sq.surface(own);
    LeavingLanes l;
    l.point = sq.to_model(s.point);
    l.normal = sq.direction_to_model(s.normal);
    l.distance = length(minus(l.point, p));
    return l;
}

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
