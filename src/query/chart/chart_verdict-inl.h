// On which side of the surface points are, by the charts of directions, many points at a time.
#if defined(SQMAP_QUERY_CHART_CHART_VERDICT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_CHART_CHART_VERDICT_INL_H
#undef SQMAP_QUERY_CHART_CHART_VERDICT_INL_H
#else
#define SQMAP_QUERY_CHART_CHART_VERDICT_INL_H
#endif

#include "chart-inl.h"
#include "query/locator/locate-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Sides of points, one a lane.
struct VerdictLanes {
    M held;             ///< a chart holds the point; elsewhere nothing is said of it
    M inside, certain;  ///< certain: the map's bounds prove the side
    F margin;           ///< by how much w (lengths: from ChartVerdicts::by_all) may change before the side does
};

/// The sides of points, by charts of directions.
class ChartVerdicts {
public:
    explicit ChartVerdicts(const ModelView& model) : model_(model) {}

    /// In cells that are Mixed, the first part of the cell's list whose chart holds the point decides. Held by none, the point is
    /// free: the parts cover the solid. cells: words of the lanes of a mask; adds to inside and certain.
    void by_lists(const V3& p, I cells, M mixed, M& inside, M& certain) const
    {
        I list = gather_word(model_.part_lists.data(), blend(mixed, LocatorLanes::list_of(cells), hn::Zero(di)));
        M open = mixed;
        for (std::uint32_t k = 0; k < model::k_list_length && any(open); ++k) {
            const I part = hn::And(list, set_int(0xff));
            list = shift_right<8>(list);
            open = hn::AndNot(equal(part, set_int(model::k_no_part)), open);
            for (M todo = open; any(todo);) {
                const std::int32_t which = first_of(part, todo);
                const M these = hn::And(todo, equal(part, set_int(which)));
                todo = hn::AndNot(these, todo);
                const VerdictLanes v = by_part(static_cast<std::size_t>(which), p, these);
                inside = hn::Or(inside, hn::And(v.held, v.inside));
                certain = hn::Or(certain, hn::And(v.held, v.certain));
                open = hn::AndNot(v.held, open);
            }
        }
    }

    /// All parts are tried: a proof decides, else the part whose verdict is farthest from changing. answering: the index of that
    /// part, -1 where no chart holds the point. refine(index, verdict) may change what one part says.
    template <class Refine>
    HWY_NOINLINE VerdictLanes by_all(const V3& p, M active, I& answering, Refine&& refine) const
    {
        VerdictLanes best{none(), none(), none(), set(-1.f)};
        answering = set_int(-1);
        for (std::size_t index = 0; index < model_.parts.size() && any(active); ++index) {
            const float* sphere = model_.parts[index].sphere;
            const V3 d = minus(p, {set(sphere[0]), set(sphere[1]), set(sphere[2])});
            const M near = hn::And(active, hn::Le(dot(d, d), set(sphere[3] * sphere[3])));
            if (!any(near)) continue;
            VerdictLanes v = by_part(index, p, near);
            if (!any(v.held)) continue;
            v.margin = hn::Mul(v.margin, length_of_w(index, p));
            refine(index, v);
            const M better = hn::And(v.held, hn::Or(v.certain, hn::Gt(v.margin, best.margin)));
            best = {hn::Or(best.held, better), hn::Or(hn::AndNot(better, best.inside), hn::And(better, v.inside)),
                    hn::Or(hn::AndNot(better, best.certain), hn::And(better, v.certain)), blend(better, v.margin, best.margin)};
            answering = blend(better, set_int(static_cast<std::int32_t>(index)), answering);
            active = hn::AndNot(hn::And(v.held, v.certain), active);
        }
        return best;
    }

    /// One part's verdict, margin in w, on the lanes of a mask.
    HWY_NOINLINE VerdictLanes by_part(std::size_t index, const V3& p, M active) const
    {
        const ChartLanes part(model_, model_.parts[index]);
        const V3 x = part.to_frame(p);
        const M held = hn::And(active, part.in_domain(x));
        if (!any(held)) return {held, held, held, hn::Zero(df)};
        const Chart q = to_chart(face_point(x));
        const Leaves leaf = part.leaves_at(q.face, q.s, q.t, held);
        const I kind = kind_of(leaf.cell);
        const M uniform = equal(kind, set_int(static_cast<std::int32_t>(CellKind::Uniform)));
        const M single = equal(kind, set_int(static_cast<std::int32_t>(CellKind::Single)));
        const F above = hn::Sub(q.w, part.value(leaf, q.s, q.t).w);
        const M nearer = hn::Gt(above, hn::Zero(df));  // w above the surface's: between it and the centre
        const M single_inside = part.centre_inside() ? nearer : hn::Not(nearer);
        const M uniform_inside = equal(hn::And(leaf.cell, set_int(1)), set_int(1));
        const F margin = hn::Abs(above);
        VerdictLanes v{held, hn::Or(hn::And(single, single_inside), hn::And(uniform, uniform_inside)),
                       hn::Or(uniform, hn::And(single, hn::Gt(margin, part.deviation(leaf.cell)))), margin};
        const M layered = hn::And(held, equal(kind, set_int(static_cast<std::int32_t>(CellKind::Layered))));
        if (any(layered)) by_layers(model_.parts[index], q, leaf, layered, v);
        return v;
    }

private:
    /// A change of w as a length along the axis of a point's face: margins of different parts are compared as lengths, and
    /// d rho = rho^2 dw.
    HWY_INLINE F length_of_w(std::size_t index, const V3& p) const
    {
        const Part& part = model_.parts[index];
        const V3 x = ChartLanes(model_, part).to_frame(p);
        const F reach = hn::Max(hn::Max(hn::Mul(hn::Abs(x.x), set(part.a[0])), hn::Mul(hn::Abs(x.y), set(part.a[1]))),
                                hn::Mul(hn::Abs(x.z), set(part.a[2])));
        return hn::Div(reach, to_chart(face_point(x)).w);
    }

    static std::int32_t first_of(I values, M mask)
    {
        HWY_ALIGN std::int32_t lanes[k_lanes];
        hn::Store(values, di, lanes);
        return lanes[hn::FindFirstTrue(df, mask)];
    }

    /// Cells of several surfaces, a lane at a time.
    void by_layers(const Part& part, const Chart& q, const Leaves& leaves, M layered, VerdictLanes& v) const
    {
        const CentralMap map(model_, part);
        HWY_ALIGN float s[k_lanes], t[k_lanes], w[k_lanes], margin[k_lanes];
        HWY_ALIGN std::int32_t inside[k_lanes] = {}, certain[k_lanes] = {};
        const StoredLeaves stored(leaves);
        hn::Store(q.s, df, s);
        hn::Store(q.t, df, t);
        hn::Store(q.w, df, w);
        hn::Store(v.margin, df, margin);
        each_lane(layered, [&](std::size_t i) {
            const model::ChartVerdict one = classify(stored.leaf(map, i, s[i], t[i]), s[i], t[i], w[i]);
            inside[i] = one.inside ? -1 : 0;
            certain[i] = one.certain ? -1 : 0;
            margin[i] = one.margin;
        });
        v.inside = hn::Or(hn::AndNot(layered, v.inside), hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, inside))));
        v.certain = hn::Or(hn::AndNot(layered, v.certain), hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, certain))));
        v.margin = hn::Load(df, margin);
    }

    const ModelView& model_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
