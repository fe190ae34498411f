// Verdicts by the charts of directions, many points at a time: certain where the map's bounds prove them.
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

/// On which side points are, by the charts that their locator cells name.
class ChartVerdicts {
public:
    explicit ChartVerdicts(const ModelView& model) : model_(model) {}

    /// The verdict of the first part of each cell's list that holds the point; held by none, it is free by the cover.
    /// cells: words of Mixed cells, where mixed; adds to inside and certain.
    void decide(const V3& p, I cells, M mixed, M& inside, M& certain) const
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
                open = hn::AndNot(decide_by(static_cast<std::size_t>(which), p, these, inside, certain), open);
            }
        }
    }

    /// One part's verdict on the lanes of a mask that its chart holds; returns those.
    HWY_NOINLINE M decide_by(std::size_t index, const V3& p, M active, M& inside, M& certain) const
    {
        const ChartLanes part(model_, model_.parts[index]);
        const V3 x = part.to_frame(p);
        const M held = hn::And(active, part.in_domain(x));
        if (!any(held)) return held;
        const Chart q = to_chart(face_point(x));
        const Leaves leaf = part.leaves_at(q.face, q.s, q.t, held);
        const I kind = kind_of(leaf.cell);
        const M uniform = equal(kind, set_int(static_cast<std::int32_t>(CellKind::Uniform)));
        const M single = equal(kind, set_int(static_cast<std::int32_t>(CellKind::Single)));
        const F margin = hn::Sub(q.w, part.value(leaf, q.s, q.t).w);
        const M nearer = hn::Gt(margin, hn::Zero(df));  // w above the surface's: between it and the centre
        const M single_inside = part.centre_inside() ? nearer : hn::Not(nearer);
        const M uniform_inside = equal(hn::And(leaf.cell, set_int(1)), set_int(1));
        M in = hn::Or(hn::And(single, single_inside), hn::And(uniform, uniform_inside));
        M sure = hn::Or(uniform, hn::And(single, hn::Gt(hn::Abs(margin), part.deviation(leaf.cell))));
        const M layered = hn::And(held, equal(kind, set_int(static_cast<std::int32_t>(CellKind::Layered))));
        if (any(layered)) classify_layers(model_.parts[index], q, leaf, layered, in, sure);
        inside = hn::Or(inside, hn::And(held, in));
        certain = hn::Or(certain, hn::And(held, sure));
        return held;
    }

private:
    static std::int32_t first_of(I values, M mask)
    {
        HWY_ALIGN std::int32_t lanes[k_lanes];
        hn::Store(values, di, lanes);
        return lanes[hn::FindFirstTrue(df, mask)];
    }

    /// Cells of several surfaces, a lane at a time.
    void classify_layers(const Part& part, const Chart& q, const Leaves& leaves, M layered, M& in, M& sure) const
    {
        const CentralMap map(model_, part);
        HWY_ALIGN float s[k_lanes], t[k_lanes], w[k_lanes];
        HWY_ALIGN std::int32_t now_in[k_lanes] = {}, now_sure[k_lanes] = {};
        const StoredLeaves stored(leaves);
        hn::Store(q.s, df, s);
        hn::Store(q.t, df, t);
        hn::Store(q.w, df, w);
        each_lane(layered, [&](std::size_t i) {
            const model::ChartVerdict v = classify(stored.leaf(map, i, s[i], t[i]), s[i], t[i], w[i]);
            now_in[i] = v.inside ? -1 : 0;
            now_sure[i] = v.certain ? -1 : 0;
        });
        in = hn::Or(hn::AndNot(layered, in), hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, now_in))));
        sure = hn::Or(hn::AndNot(layered, sure), hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, now_sure))));
    }

    const ModelView& model_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
