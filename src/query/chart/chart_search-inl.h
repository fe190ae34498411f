// The search for the nearest surface in the charts of directions, many points at a time.
#if defined(SQMAP_QUERY_CHART_CHART_SEARCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_CHART_CHART_SEARCH_INL_H
#undef SQMAP_QUERY_CHART_CHART_SEARCH_INL_H
#else
#define SQMAP_QUERY_CHART_CHART_SEARCH_INL_H
#endif

#include "chart-inl.h"
#include "search_limits.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Nearest surface about a seed, model space.
struct Found {
    F distance_sq;
    V3 offset;  // from the point
    V3 normal;  // outward, not of unit length
    M near;     // the point is right above the surface point
    M inside;   // it is below the surface, if near
};

/// The search for the nearest surface in one part's chart.
class ChartSearch {
public:
    ChartSearch(const ModelView& model, std::size_t index)
        : model_(model),
          data_(model.parts[index]),
          part_(model, data_),
          axes_{set(data_.a[0]), set(data_.a[1]), set(data_.a[2])},
          inverse_{set(1.f / data_.a[0]), set(1.f / data_.a[1]), set(1.f / data_.a[2])}
    {
    }

    /// Points, where to look, and where else; model space.
    struct From {
        V3 p, start, origin;
    };

    /// The nearest surface about a start, or where there is none about origin: the surface over there, the foot on the tangent
    /// plane for the next start, while that comes nearer. Lanes stop on their own, so that an answer does not depend on its
    /// neighbours.
    HWY_NOINLINE Found approach(const From& from, M active, int steps) const
    {
        const V3 z = part_.to_metric(from.p);
        FacePoint f = face_point(times(part_.to_metric(from.start), inverse_));
        Chart q = to_chart(f);
        F reach = hn::Abs(f.major);  // along the face's axis: of several surfaces the one nearest to there
        M all_near = none(), kept_exits = none();
        const F touching_sq = set(1e-9f * model_.header.sphere[3] * model_.header.sphere[3]), zero = hn::Zero(df);
        F found_sq = set(INFINITY), kept_along = zero;
        V3 kept_n{zero, zero, zero}, kept_d = kept_n;
        I kept_face = q.face;
        for (int step = 0; step < steps; ++step) {
            Surface over = surface_over(q, reach, active);
            if (step == 0 && any(hn::AndNot(over.valid, active))) look_over(from.origin, hn::AndNot(over.valid, active), over, q);
            active = over.valid;
            if (!any(active)) break;
            set_axis(f, q.face);
            const Tangent at = tangent(f, q, over.sheet, z);
            const M nearer = hn::And(active, hn::Lt(at.distance_sq, found_sq));
            // So near above the surface point that the tangent plane's foot is as good.
            const M above = hn::And(nearer, hn::Le(at.distance_sq, mul_add(set(k_approach_near), at.plane_sq, touching_sq)));
            all_near = hn::Or(all_near, above);
            found_sq = blend(above, at.plane_sq, blend(nearer, at.distance_sq, found_sq));
            kept_n = blend(nearer, at.n, kept_n);
            kept_d = blend(nearer, at.d, kept_d);
            kept_along = blend(nearer, at.along, kept_along);
            kept_face = blend(nearer, q.face, kept_face);
            kept_exits = hn::Or(hn::AndNot(nearer, kept_exits), hn::And(nearer, over.exits));
            active = hn::AndNot(above, nearer);
            if (step + 1 >= steps || !any(active)) break;
            f = face_point(f.unpermute(at.next));
            q = to_chart(f);
            reach = hn::Abs(f.major);
        }
        const M below = hn::Gt(kept_along, zero);
        const M inside = hn::And(all_near, hn::Or(hn::And(kept_exits, below), hn::Not(hn::Or(kept_exits, below))));
        set_axis(f, kept_face);
        const V3 in_plane = times(kept_n, {kept_along, kept_along, kept_along});
        const V3 minus{hn::Neg(kept_n.x), hn::Neg(kept_n.y), hn::Neg(kept_n.z)};
        return {found_sq, part_.from_frame(f.unpermute(blend(all_near, in_plane, kept_d))),
                part_.from_frame(f.unpermute(blend(kept_exits, kept_n, minus))), all_near, inside};
    }

private:
    /// A surface of the chart over a direction.
    struct Surface {
        Sheet sheet;
        M valid;  // there is one
        M exits;  // a ray from the centre leaves the solid there
    };
    HWY_INLINE Surface surface_over(const Chart& q, F reach, M active) const
    {
        const Leaves leaf = part_.leaves_at(q.face, q.s, q.t, active);
        Surface over{part_.value(leaf, q.s, q.t), none(), none()};
        const I kind = kind_of(leaf.cell);
        over.valid = hn::And(active, equal(kind, set_int(static_cast<std::int32_t>(CellKind::Single))));
        if (part_.centre_inside()) over.exits = over.valid;
        const M layered =
            hn::AndNot(over.valid, hn::And(active, equal(kind, set_int(static_cast<std::int32_t>(CellKind::Layered)))));
        if (any(layered)) pick_layer(q, leaf, reach, layered, over);
        over.valid = hn::And(over.valid, hn::Gt(over.sheet.w, set(1e-6f)));
        return over;
    }

    /// Looks over the foot of the cell's centre in lanes whose chart has no surface over the point's own foot.
    HWY_NOINLINE void look_over(const V3& origin, M lost, Surface& over, Chart& q) const
    {
        const FacePoint again = face_point(times(part_.to_metric(origin), inverse_));
        const Chart there = to_chart(again);
        const Surface other = surface_over(there, hn::Abs(again.major), lost);
        const M found = other.valid;
        over.sheet = {blend(found, other.sheet.w, over.sheet.w), blend(found, other.sheet.ws, over.sheet.ws),
                      blend(found, other.sheet.wt, over.sheet.wt)};
        q = {blend(found, there.face, q.face), blend(found, there.s, q.s), blend(found, there.t, q.t), q.w};
        over.exits = hn::Or(over.exits, hn::And(found, other.exits));
        over.valid = hn::Or(over.valid, found);
    }

    /// Picks the surface over a layered leaf that lies nearest to the expected distance.
    HWY_NOINLINE void pick_layer(const Chart& q, const Leaves& leaves, F reach, M layered, Surface& over) const
    {
        const CentralMap map(model_, data_);
        HWY_ALIGN float s[k_lanes], t[k_lanes], expected[k_lanes], w[k_lanes] = {}, ws[k_lanes] = {}, wt[k_lanes] = {};
        HWY_ALIGN std::int32_t is_valid[k_lanes] = {}, is_exit[k_lanes] = {};
        const StoredLeaves stored(leaves);
        hn::Store(q.s, df, s);
        hn::Store(q.t, df, t);
        hn::Store(reach, df, expected);
        each_lane(layered, [&](std::size_t i) {
            const auto found = map.nearest_sheet(static_cast<std::uint16_t>(stored.cell[i]), stored.s0[i], stored.t0[i],
                                                 1.f / stored.inverse_size[i], s[i], t[i], expected[i]);
            w[i] = found.value.w;
            ws[i] = found.value.ws;
            wt[i] = found.value.wt;
            is_valid[i] = found.value.w > 0.f ? -1 : 0;
            is_exit[i] = found.exits ? -1 : 0;
        });
        over.sheet = {blend(layered, hn::Load(df, w), over.sheet.w), blend(layered, hn::Load(df, ws), over.sheet.ws),
                      blend(layered, hn::Load(df, wt), over.sheet.wt)};
        over.valid = hn::Or(over.valid, hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, is_valid))));
        over.exits = hn::Or(hn::AndNot(layered, over.exits), hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, is_exit))));
    }

    /// A surface point and the tangent plane there, seen from the point z; coordinates by face.
    struct Tangent {
        V3 d;  // from z to the surface point
        F distance_sq;
        V3 n;  // the plane's vector: n z = 1 on it
        F along, plane_sq;
        V3 next;  // the foot of z on the plane, chart frame
    };
    HWY_INLINE Tangent tangent(const FacePoint& f, const Chart& q, const Sheet& sheet, const V3& z) const
    {
        const V3 y = f.permute(z), a = f.permute(axes_), over = f.permute(inverse_);
        const F one = set(1.f), sign = hn::CopySign(one, hn::BitCast(df, hn::ShiftLeft<31>(q.face)));
        const F rho = hn::Div(one, hn::Max(sheet.w, set(1e-18f)));  // lanes that are done may hold 0
        Tangent at;
        at.d = {hn::Sub(hn::Mul(a.x, hn::Mul(sign, rho)), y.x), hn::Sub(hn::Mul(a.y, hn::Mul(q.s, rho)), y.y),
                hn::Sub(hn::Mul(a.z, hn::Mul(q.t, rho)), y.z)};
        at.distance_sq = dot(at.d, at.d);
        at.n = {hn::Mul(over.x, hn::Mul(sign, hn::Sub(hn::Sub(sheet.w, hn::Mul(sheet.ws, q.s)), hn::Mul(sheet.wt, q.t)))),
                hn::Mul(over.y, sheet.ws), hn::Mul(over.z, sheet.wt)};
        const F length_sq = hn::Max(dot(at.n, at.n), set(1e-30f)), gap = hn::Sub(one, dot(at.n, y));
        at.along = hn::Div(gap, length_sq);
        at.plane_sq = hn::Mul(gap, at.along);
        at.next = times(over, {mul_add(at.along, at.n.x, y.x), mul_add(at.along, at.n.y, y.y), mul_add(at.along, at.n.z, y.z)});
        return at;
    }

    static HWY_INLINE void set_axis(FacePoint& f, I face)
    {
        const I axis = hn::ShiftRight<1>(face);
        f.x_major = equal(axis, hn::Zero(di));
        f.y_major = equal(axis, set_int(1));
    }

    const ModelView& model_;
    const Part& data_;
    const ChartLanes part_;
    const V3 axes_, inverse_;  // metric coordinates over the axes are the chart's
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
