// The charts of directions, read for many points at a time.
#if defined(SQMAP_QUERY_CHART_CHART_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_CHART_CHART_INL_H
#undef SQMAP_QUERY_CHART_CHART_INL_H
#else
#define SQMAP_QUERY_CHART_CHART_INL_H
#endif

#include "math/lanes-inl.h"
#include "model/central_map.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;
using model::CellKind;
using model::CentralCell;
using model::CentralMap;
using model::Leaf;
using model::ModelView;
using model::Part;

HWY_INLINE I kind_of(I cell) { return shift_right<CentralCell::k_payload_bits>(cell); }

/// Points of a chart frame by face: major is the largest coordinate, u and v the next two in cyclic order.
struct FacePoint {
    M x_major, y_major;
    F major, u, v;
    HWY_INLINE V3 permute(const V3& p) const
    {
        return {blend(x_major, p.x, blend(y_major, p.y, p.z)), blend(x_major, p.y, blend(y_major, p.z, p.x)),
                blend(x_major, p.z, blend(y_major, p.x, p.y))};
    }
    HWY_INLINE V3 unpermute(const V3& p) const
    {
        return {blend(x_major, p.x, blend(y_major, p.z, p.y)), blend(x_major, p.y, blend(y_major, p.x, p.z)),
                blend(x_major, p.z, blend(y_major, p.y, p.x))};
    }
};

struct Chart {
    I face;
    F s, t, w;
};

HWY_INLINE FacePoint face_point(const V3& p)
{
    const F ax = hn::Abs(p.x), ay = hn::Abs(p.y), az = hn::Abs(p.z);
    FacePoint f;
    f.x_major = hn::And(hn::Ge(ax, ay), hn::Ge(ax, az));
    f.y_major = hn::AndNot(f.x_major, hn::Ge(ay, az));
    const V3 q = f.permute(p);
    f.major = q.x;
    f.u = q.y;
    f.v = q.z;
    return f;
}

HWY_INLINE Chart to_chart(const FacePoint& f)
{
    Chart c;
    c.w = hn::Div(set(1.f), hn::Max(hn::Abs(f.major), set(1e-18f)));
    c.s = hn::Mul(f.u, c.w);
    c.t = hn::Mul(f.v, c.w);
    const I axis2 = blend(f.x_major, hn::Zero(di), blend(f.y_major, set_int(2), set_int(4)));
    c.face = hn::Add(axis2, shift_right<31>(hn::BitCast(di, f.major)));
    return c;
}

/// A leaf under each lane: its cell word and the samples at its corners, still coded.
struct Leaves {
    I cell;
    I c00, c10, c01, c11;
    F s0, t0, inverse_size;
};

/// w of a surface and its derivatives.
struct Sheet {
    F w, ws, wt;
};

class ChartLanes {
public:
    ChartLanes(const ModelView& view, const Part& part)
        : part_(part),
          samples_(view.samples.data() + part.samples.first),
          cells_(view.cells.data() + part.cells.first),
          splits_(view.splits.data() + model::k_split_size * static_cast<std::size_t>(part.splits.first)),
          base_(static_cast<std::int32_t>(part.base))
    {
    }

    HWY_INLINE V3 to_frame(const V3& p) const
    {
        const V3 d{hn::Sub(p.x, set(part_.chart_centre[0])), hn::Sub(p.y, set(part_.chart_centre[1])),
                   hn::Sub(p.z, set(part_.chart_centre[2]))};
        return {row_dot(part_.chart_rows, d), row_dot(part_.chart_rows + 3, d), row_dot(part_.chart_rows + 6, d)};
    }

    /// Metric coordinates about the centre, along the axes.
    HWY_INLINE V3 to_metric(const V3& p) const
    {
        const V3 d{hn::Sub(p.x, set(part_.chart_centre[0])), hn::Sub(p.y, set(part_.chart_centre[1])),
                   hn::Sub(p.z, set(part_.chart_centre[2]))};
        return {row_dot(part_.rotation, d), row_dot(part_.rotation + 3, d), row_dot(part_.rotation + 6, d)};
    }

    /// A metric offset of the frame, in model space.
    HWY_INLINE V3 from_frame(const V3& v) const
    {
        const float* r = part_.rotation;
        return {mul_add(set(r[0]), v.x, mul_add(set(r[3]), v.y, hn::Mul(set(r[6]), v.z))),
                mul_add(set(r[1]), v.x, mul_add(set(r[4]), v.y, hn::Mul(set(r[7]), v.z))),
                mul_add(set(r[2]), v.x, mul_add(set(r[5]), v.y, hn::Mul(set(r[8]), v.z)))};
    }

    HWY_INLINE M in_domain(const V3& x) const
    {
        const F values[9] = {x.x,
                             x.y,
                             x.z,
                             hn::Add(x.x, x.y),
                             hn::Sub(x.x, x.y),
                             hn::Add(x.x, x.z),
                             hn::Sub(x.x, x.z),
                             hn::Add(x.y, x.z),
                             hn::Sub(x.y, x.z)};
        M inside = hn::Ge(values[0], set(part_.chart_lo[0]));
        for (int i = 0; i < 9; ++i)
            inside =
                hn::And(inside, hn::And(hn::Ge(values[i], set(part_.chart_lo[i])), hn::Le(values[i], set(part_.chart_hi[i]))));
        return inside;
    }

    HWY_INLINE I column_of(F s) const
    {
        const I c = truncate(hn::Mul(hn::Mul(hn::Add(s, set(1.f)), set(0.5f)), set(static_cast<float>(base_))));
        return hn::Min(hn::Max(c, hn::Zero(di)), set_int(base_ - 1));
    }

    HWY_INLINE Leaves leaves_at(I face, F s, F t, M active) const
    {
        const F size0 = set(2.f / static_cast<float>(base_));
        const I column = column_of(s), row = column_of(t);
        const I index = hn::Add(hn::Mul(hn::Add(hn::Mul(face, set_int(base_)), row), set_int(base_)), column);
        Leaves leaf;
        leaf.cell = low(gather_pair(cells_, index));
        const I sample = hn::Add(hn::Mul(hn::Add(hn::Mul(face, set_int(base_ + 1)), row), set_int(base_ + 1)), column);
        const I bottom = gather_pair(samples_, sample), top = gather_pair(samples_, hn::Add(sample, set_int(base_ + 1)));
        leaf.c00 = low(bottom);
        leaf.c10 = high(bottom);
        leaf.c01 = low(top);
        leaf.c11 = high(top);
        leaf.s0 = mul_add(size0, to_float(column), set(-1.f));
        leaf.t0 = mul_add(size0, to_float(row), set(-1.f));
        leaf.inverse_size = set(0.5f * static_cast<float>(base_));
        F size = size0;
        const I split_kind = set_int(static_cast<std::int32_t>(CellKind::Split));
        for (M split = hn::And(active, equal(kind_of(leaf.cell), split_kind)); any(split);
             split = hn::And(split, equal(kind_of(leaf.cell), split_kind))) {
            size = hn::Mul(size, set(0.5f));
            const F s1 = hn::Add(leaf.s0, size), t1 = hn::Add(leaf.t0, size);
            const M right = hn::And(split, hn::Ge(s, s1)), up = hn::And(split, hn::Ge(t, t1));
            leaf.s0 = blend(right, s1, leaf.s0);
            leaf.t0 = blend(up, t1, leaf.t0);
            leaf.inverse_size = blend(split, hn::Add(leaf.inverse_size, leaf.inverse_size), leaf.inverse_size);
            const I record =
                hn::Mul(blend(split, hn::And(leaf.cell, set_int((1 << CentralCell::k_payload_bits) - 1)), hn::Zero(di)),
                        set_int(model::k_split_size));
            const I x = blend(right, set_int(1), hn::Zero(di)), y = blend(up, set_int(1), hn::Zero(di));
            const I cell = hn::Add(hn::Add(record, set_int(model::k_split_cells)), hn::Add(x, hn::Add(y, y)));
            leaf.cell = blend(split, low(gather_pair(splits_, cell)), leaf.cell);
            // The samples below the middle, left of it, in it, right of it and above it.
            const I first = gather_pair(splits_, record), second = gather_pair(splits_, hn::Add(record, set_int(2)));
            const I s_low = low(first), t_low = high(first), middle = low(second), t_high = high(second),
                    s_high = low(gather_pair(splits_, hn::Add(record, set_int(4))));
            const auto choose = [&](I old, I lower_left, I lower_right, I upper_left, I upper_right) {
                return blend(split, blend(up, blend(right, upper_right, upper_left), blend(right, lower_right, lower_left)), old);
            };
            leaf.c00 = choose(leaf.c00, leaf.c00, s_low, t_low, middle);
            leaf.c10 = choose(leaf.c10, s_low, leaf.c10, middle, t_high);
            leaf.c01 = choose(leaf.c01, t_low, middle, leaf.c01, s_high);
            leaf.c11 = choose(leaf.c11, middle, t_high, s_high, leaf.c11);
        }
        return leaf;
    }

    HWY_INLINE F decode(I code) const { return mul_add(set(part_.w_step), to_float(code), set(part_.w_min)); }

    HWY_INLINE Sheet value(const Leaves& leaf, F s, F t) const
    {
        const F u = hn::Mul(hn::Sub(s, leaf.s0), leaf.inverse_size), v = hn::Mul(hn::Sub(t, leaf.t0), leaf.inverse_size);
        const F c00 = decode(leaf.c00), c10 = decode(leaf.c10), c01 = decode(leaf.c01), c11 = decode(leaf.c11);
        const F d0 = hn::Sub(c10, c00), d1 = hn::Sub(c11, c01);
        const F bottom = mul_add(u, d0, c00), top = mul_add(u, d1, c01), rise = hn::Sub(top, bottom);
        return {mul_add(v, rise, bottom), hn::Mul(mul_add(v, hn::Sub(d1, d0), d0), leaf.inverse_size),
                hn::Mul(rise, leaf.inverse_size)};
    }

    /// Certified deviation of Single cells.
    HWY_INLINE F deviation(I cell) const
    {
        const I code = hn::And(cell, set_int(0xff));
        const F mantissa = hn::Mul(to_float(hn::Add(hn::And(code, set_int(7)), set_int(8))), set(0.03125f * part_.w_step));
        const F power = hn::BitCast(df, hn::ShiftLeft<23>(hn::Add(shift_right<3>(code), set_int(127))));
        return hn::Mul(mantissa, power);
    }

    HWY_INLINE bool centre_inside() const { return (part_.flags & model::k_centre_inside) != 0; }
    const Part& part() const { return part_; }

private:
    const Part& part_;
    const std::uint16_t* samples_;
    const std::uint16_t* cells_;
    const std::uint16_t* splits_;
    std::int32_t base_;
};

/// Leaves out of their lanes, for what is done one by one.
struct StoredLeaves {
    HWY_ALIGN std::int32_t cell[k_lanes];
    HWY_ALIGN float s0[k_lanes], t0[k_lanes], inverse_size[k_lanes];

    explicit StoredLeaves(const Leaves& leaves)
    {
        hn::Store(leaves.cell, di, cell);
        hn::Store(leaves.s0, df, s0);
        hn::Store(leaves.t0, df, t0);
        hn::Store(leaves.inverse_size, df, inverse_size);
    }
    Leaf leaf(const CentralMap& map, std::size_t i, float s, float t) const
    {
        return map.leaf_of(static_cast<std::uint16_t>(cell[i]), s0[i], t0[i], 1.f / inverse_size[i], s, t);
    }
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
