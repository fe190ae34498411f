// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, for many points at once. Compiled
// for each instruction set by Highway (J. Wassenberg et al.); no fused multiply-add, so that all give the same bits.
#include "frame_kernels.h"

#include "approach.h"
#include "central_query.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/frame_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using model::CellKind;
using model::ModelView;
using model::Part;
using model::PlaceKind;

using DF = hn::CappedTag<float, Probe::k_cluster>;
using DI = hn::RebindToSigned<DF>;
using DU = hn::RebindToUnsigned<DF>;
using F = hn::Vec<DF>;
using I = hn::Vec<DI>;
using M = hn::Mask<DF>;
constexpr DF df{};
constexpr DI di{};
constexpr DU du{};
constexpr std::size_t k_lanes = hn::MaxLanes(DF());

HWY_INLINE F set(float v) { return hn::Set(df, v); }
HWY_INLINE I set_int(std::int32_t v) { return hn::Set(di, v); }
HWY_INLINE F blend(M m, F yes, F no) { return hn::IfThenElse(m, yes, no); }
HWY_INLINE I blend(M m, I yes, I no) { return hn::IfThenElse(hn::RebindMask(di, m), yes, no); }
HWY_INLINE M equal(I a, I b) { return hn::RebindMask(df, hn::Eq(a, b)); }
HWY_INLINE M not_negative(I a) { return hn::RebindMask(df, hn::Gt(a, set_int(-1))); }
HWY_INLINE M none() { return hn::Ne(hn::Zero(df), hn::Zero(df)); }
HWY_INLINE bool any(M m) { return !hn::AllFalse(df, m); }
HWY_INLINE F mul_add(F a, F b, F c) { return hn::Add(hn::Mul(a, b), c); }
HWY_INLINE I truncate(F v) { return hn::ConvertTo(di, v); }
HWY_INLINE F truncate_float(F v) { return hn::ConvertTo(df, hn::ConvertTo(di, v)); }
HWY_INLINE F to_float(I v) { return hn::ConvertTo(df, v); }
template <int k>
HWY_INLINE I shift_right(I v)
{
    return hn::BitCast(di, hn::ShiftRight<k>(hn::BitCast(du, v)));
}

/// Two neighbouring 16-bit values from an index on, the first in the low half. Reading past an array's last value is safe:
/// something always follows it in a parsed model's blob.
HWY_INLINE I gather_pair(const std::uint16_t* base, I index)
{
    return hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(base), hn::Add(index, index));
}
HWY_INLINE I gather_word(const std::uint32_t* base, I index)
{
    return hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(base), index);
}
HWY_INLINE I low(I pair) { return hn::And(pair, set_int(0xffff)); }
HWY_INLINE I high(I pair) { return shift_right<16>(pair); }
HWY_INLINE I kind_of(I cell) { return shift_right<14>(cell); }

struct V3 {
    F x, y, z;
};
HWY_INLINE V3 blend(M m, const V3& yes, const V3& no) { return {blend(m, yes.x, no.x), blend(m, yes.y, no.y), blend(m, yes.z, no.z)}; }
HWY_INLINE F dot(const V3& a, const V3& b) { return mul_add(a.x, b.x, mul_add(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE F row_dot(const float* r, const V3& v) { return mul_add(set(r[0]), v.x, mul_add(set(r[1]), v.y, hn::Mul(set(r[2]), v.z))); }

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

class PartLanes {
public:
    PartLanes(const ModelView& view, const Part& part)
        : part_(part),
          samples_(view.samples.data() + part.first_sample),
          cells_(view.cells.data() + part.first_cell),
          splits_(view.splits.data() + model::k_split_size * static_cast<std::size_t>(part.first_split)),
          split_shift_(static_cast<std::int32_t>(splits_ - samples_)),
          base_(static_cast<std::int32_t>(part.base))
    {
    }

    HWY_INLINE V3 to_frame(const V3& p) const
    {
        const V3 d{hn::Sub(p.x, set(part_.chart_centre[0])), hn::Sub(p.y, set(part_.chart_centre[1])),
                   hn::Sub(p.z, set(part_.chart_centre[2]))};
        return {row_dot(part_.chart_rows, d), row_dot(part_.chart_rows + 3, d), row_dot(part_.chart_rows + 6, d)};
    }

    /// A direction or offset of the frame, times the axes, in model space.
    HWY_INLINE V3 from_frame(const V3& v) const
    {
        const float* r = part_.rotation;
        return {mul_add(set(r[0]), v.x, mul_add(set(r[3]), v.y, hn::Mul(set(r[6]), v.z))),
                mul_add(set(r[1]), v.x, mul_add(set(r[4]), v.y, hn::Mul(set(r[7]), v.z))),
                mul_add(set(r[2]), v.x, mul_add(set(r[5]), v.y, hn::Mul(set(r[8]), v.z)))};
    }

    HWY_INLINE M in_domain(const V3& x) const
    {
        const F values[9] = {x.x, x.y, x.z, hn::Add(x.x, x.y), hn::Sub(x.x, x.y), hn::Add(x.x, x.z), hn::Sub(x.x, x.z),
                             hn::Add(x.y, x.z), hn::Sub(x.y, x.z)};
        M inside = hn::Ge(values[0], set(part_.chart_lo[0]));
        for (int i = 0; i < 9; ++i)
            inside = hn::And(inside, hn::And(hn::Ge(values[i], set(part_.chart_lo[i])), hn::Le(values[i], set(part_.chart_hi[i]))));
        return inside;
    }

    HWY_INLINE I column_of(F s) const
    {
        const I c = truncate(hn::Mul(hn::Mul(hn::Add(s, set(1.f)), set(0.5f)), set(static_cast<float>(base_))));
        return hn::Min(hn::Max(c, hn::Zero(di)), set_int(base_ - 1));
    }

    HWY_INLINE Leaves leaves_at(I face, F s, F t, M active, bool refined) const
    {
        const F size0 = set(2.f / static_cast<float>(base_));
        const I column = column_of(s), row = column_of(t);
        const I index = hn::Add(hn::Mul(hn::Add(hn::Mul(face, set_int(base_)), row), set_int(base_)), column);
        Leaves leaf;
        leaf.cell = low(gather_pair(cells_, index));
        const I sample = hn::Add(hn::Mul(hn::Add(hn::Mul(face, set_int(base_ + 1)), row), set_int(base_ + 1)), column);
        // The corners' place, in values from the base samples on: their own array's, or the last split's.
        I corner = sample, stride = set_int(base_ + 1);
        leaf.s0 = mul_add(size0, to_float(column), set(-1.f));
        leaf.t0 = mul_add(size0, to_float(row), set(-1.f));
        leaf.inverse_size = set(0.5f * static_cast<float>(base_));
        if (refined) {
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
                const I record = hn::Mul(blend(split, hn::And(leaf.cell, set_int(0x3fff)), hn::Zero(di)), set_int(model::k_split_size));
                const I x = blend(right, set_int(1), hn::Zero(di)), y = blend(up, set_int(1), hn::Zero(di));
                const I cell = hn::Add(hn::Add(record, set_int(model::k_split_cells)), hn::Add(x, hn::Add(y, y)));
                leaf.cell = blend(split, low(gather_pair(splits_, cell)), leaf.cell);
                corner = blend(split, hn::Add(hn::Add(record, set_int(split_shift_)), hn::Add(x, hn::Add(y, hn::Add(y, y)))), corner);
                stride = blend(split, set_int(3), stride);
            }
        }
        const I bottom = gather_pair(samples_, corner), top = gather_pair(samples_, hn::Add(corner, stride));
        leaf.c00 = low(bottom);
        leaf.c10 = high(bottom);
        leaf.c01 = low(top);
        leaf.c11 = high(top);
        return leaf;
    }

    HWY_INLINE F decode(I code) const { return mul_add(set(part_.w_step), to_float(code), set(part_.w_min)); }

    HWY_INLINE Sheet value(const Leaves& leaf, F s, F t) const
    {
        const F u = hn::Mul(hn::Sub(s, leaf.s0), leaf.inverse_size), v = hn::Mul(hn::Sub(t, leaf.t0), leaf.inverse_size);
        const F c00 = decode(leaf.c00), c10 = decode(leaf.c10), c01 = decode(leaf.c01), c11 = decode(leaf.c11);
        const F d0 = hn::Sub(c10, c00), d1 = hn::Sub(c11, c01);
        const F bottom = mul_add(u, d0, c00), top = mul_add(u, d1, c01), rise = hn::Sub(top, bottom);
        return {mul_add(v, rise, bottom), hn::Mul(mul_add(v, hn::Sub(d1, d0), d0), leaf.inverse_size), hn::Mul(rise, leaf.inverse_size)};
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
    std::int32_t split_shift_;  // from the samples to the splits, in values: both lie in one blob
    std::int32_t base_;
};

/// The lanes of a mask one by one.
template <class Do>
HWY_INLINE void each_lane(M mask, Do&& action)
{
    HWY_ALIGN std::int32_t set_lanes[k_lanes];
    hn::Store(hn::VecFromMask(di, hn::RebindMask(di, mask)), di, set_lanes);
    for (std::size_t i = 0; i < hn::Lanes(df); ++i)
        if (set_lanes[i] != 0) action(i);
}

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

class FrameKernel {
public:
    explicit FrameKernel(const FrameJob& job) : job_(job), model_(job.model), locator_(job.model.locator)
    {
        inverse_cell_ = 1.f / locator_.cell;
        for (int k = 0; k < 3; ++k) cells_[k] = static_cast<float>(model::k_brick * locator_.bricks[k]);
    }

    FrameResult run()
    {
        if (job_.points == 0 || is_far(job_.sphere[0], job_.sphere[1], job_.sphere[2], job_.sphere[3])) return result_;
        for (std::size_t g = 0; g < job_.groups; ++g) {
            if (job_.groups > 1 && is_far(job_.group_x[g], job_.group_y[g], job_.group_z[g], job_.group_radius[g])) continue;
            const std::size_t last = std::min(job_.clusters, (g + 1) * Probe::k_cluster);
            for (std::size_t c = g * Probe::k_cluster; c < last; ++c) {
                if (is_far(job_.centre_x[c], job_.centre_y[c], job_.centre_z[c], job_.radius[c])) continue;
                for (std::size_t i = 0; i < Probe::k_cluster; i += hn::Lanes(df)) ask(c * Probe::k_cluster + i);
                if (queued_ > k_queue - Probe::k_cluster || (job_.first_only && queued_ > 0)) {
                    flush();
                    if (job_.first_only && result_.contacts > 0) return result_;
                }
            }
        }
        flush();
        return result_;
    }

private:
    static constexpr std::size_t k_queue = 512;
    enum Flag : std::uint8_t { k_certain = 1, k_inside = 2, k_free = 4 };

    Vec3f transformed(float x, float y, float z) const
    {
        const float* r = job_.rotation;
        return {r[0] * x + r[1] * y + r[2] * z + job_.translation[0], r[3] * x + r[4] * y + r[5] * z + job_.translation[1],
                r[6] * x + r[7] * y + r[8] * z + job_.translation[2]};
    }

    /// True where no point of a sphere (of the probe) is in the solid, by the locator's gap about its centre.
    bool is_far(float x, float y, float z, float radius) const
    {
        const Vec3f c = transformed(x, y, z);
        const float reach = radius * job_.scale;
        float outside_sq = 0.f;
        int at[3];
        Vec3f g;
        for (int k = 0; k < 3; ++k) {
            const float in_cells = (c[k] - locator_.origin[k]) * inverse_cell_;
            g[k] = std::clamp(in_cells, 0.f, cells_[k]);
            const float gap = (in_cells - g[k]) * locator_.cell;
            outside_sq += gap * gap;
            at[k] = std::min(static_cast<int>(g[k]), static_cast<int>(cells_[k]) - 1);
        }
        // Also where the sum overflows.
        if (!(outside_sq <= reach * reach * 1.0001f)) return true;
        const std::uint32_t brick =
            model_.bricks[(static_cast<std::size_t>(at[2] / model::k_brick) * locator_.bricks[1] + static_cast<std::size_t>(at[1] / model::k_brick)) *
                              locator_.bricks[0] +
                          static_cast<std::size_t>(at[0] / model::k_brick)];
        float gap = 0.f, half = 0.5f;
        if ((brick & model::k_free_brick) != 0) {
            gap = static_cast<float>(brick & ~model::k_free_brick);
            half = 0.5f * model::k_brick;
            for (int& a : at) a = a / model::k_brick * model::k_brick;
        } else {
            const std::uint32_t place =
                model_.places[brick + static_cast<std::uint32_t>((at[2] % model::k_brick * model::k_brick + at[1] % model::k_brick) * model::k_brick +
                                                                 at[0] % model::k_brick)];
            if (model::place_kind(place) != PlaceKind::Free) return false;
            gap = static_cast<float>(model::place_gap(place));
        }
        const Vec3f d{g.x - static_cast<float>(at[0]) - half, g.y - static_cast<float>(at[1]) - half, g.z - static_cast<float>(at[2]) - half};
        const float away = (gap * model::k_gap_step - norm(d)) * locator_.cell;
        return away > 0.f && away * away + outside_sq > reach * reach * 1.0001f;
    }

    /// Asks one batch of points from a slot on, and queues those that are inside or have to be asked again.
    void ask(std::size_t slot)
    {
        const F px = hn::LoadU(df, job_.x + slot), py = hn::LoadU(df, job_.y + slot), pz = hn::LoadU(df, job_.z + slot);
        const V3 local{px, py, pz};
        const float* r = job_.rotation;
        const V3 p{hn::Add(row_dot(r, local), set(job_.translation[0])), hn::Add(row_dot(r + 3, local), set(job_.translation[1])),
                   hn::Add(row_dot(r + 6, local), set(job_.translation[2]))};
        // Where in the grid.
        const F scale = set(inverse_cell_);
        const F gx = hn::Mul(hn::Sub(p.x, set(locator_.origin[0])), scale), gy = hn::Mul(hn::Sub(p.y, set(locator_.origin[1])), scale),
                gz = hn::Mul(hn::Sub(p.z, set(locator_.origin[2])), scale);
        const F zero = hn::Zero(df);
        M in_grid = hn::And(hn::And(hn::Ge(gx, zero), hn::Ge(gy, zero)), hn::Ge(gz, zero));
        in_grid = hn::And(in_grid, hn::And(hn::And(hn::Lt(gx, set(cells_[0])), hn::Lt(gy, set(cells_[1]))), hn::Lt(gz, set(cells_[2]))));
        // The padding of the last cluster is nobody.
        if (slot + hn::Lanes(df) > job_.points)
            in_grid = hn::And(in_grid, hn::FirstN(df, job_.points > slot ? job_.points - slot : 0));
        if (!any(in_grid)) return;
        const I ix = blend(in_grid, truncate(gx), hn::Zero(di)), iy = blend(in_grid, truncate(gy), hn::Zero(di)),
                iz = blend(in_grid, truncate(gz), hn::Zero(di));
        const I bx = shift_right<2>(ix), by = shift_right<2>(iy), bz = shift_right<2>(iz);
        const I brick_index = hn::Add(
            hn::Mul(hn::Add(hn::Mul(bz, set_int(static_cast<std::int32_t>(locator_.bricks[1]))), by), set_int(static_cast<std::int32_t>(locator_.bricks[0]))), bx);
        const I brick = gather_word(model_.bricks.data(), brick_index);
        const M stored = hn::And(in_grid, not_negative(brick));
        if (!any(stored)) return;
        const I three = set_int(3);
        const I within = hn::Add(hn::ShiftLeft<2>(hn::Add(hn::ShiftLeft<2>(hn::And(iz, three)), hn::And(iy, three))), hn::And(ix, three));
        const I place = gather_word(model_.places.data(), blend(stored, hn::Add(brick, within), hn::Zero(di)));
        const I kind = hn::And(place, three);
        const M occupied = hn::And(stored, hn::RebindMask(df, hn::Ne(kind, hn::Zero(di))));
        if (!any(occupied)) return;

        const M inside = hn::And(occupied, equal(kind, set_int(static_cast<std::int32_t>(PlaceKind::Inside))));
        const M mixed = hn::And(occupied, equal(kind, set_int(static_cast<std::int32_t>(PlaceKind::Mixed))));
        if (job_.layer == Layer::Three) {
            // The nearest surface tells the side as well, where it is found at once.
            const M found = from_first_seed(slot, p, place, hn::Or(inside, mixed), inside);
            const M rest = hn::AndNot(found, occupied);
            if (any(rest)) enqueue(slot, p, place, rest, inside, none());
            return;
        }
        M in = inside, certain = inside;
        M undecided = hn::AndNot(hn::Or(inside, mixed), occupied);
        if (any(mixed)) undecided = hn::Or(undecided, verdicts(p, place, mixed, in, certain));
        if (job_.exact) undecided = hn::Or(undecided, hn::AndNot(certain, mixed));
        const M rest = hn::Or(in, undecided);
        if (any(rest)) enqueue(slot, p, place, rest, hn::AndNot(undecided, in), certain);
    }

    /// The verdict of the first part of each place's list that holds the point. Returns the lanes that none holds: free by the
    /// cover.
    M verdicts(const V3& p, I place, M mixed, M& inside, M& certain) const
    {
        const I list_index = hn::And(shift_right<2>(place), set_int(0xfff));
        I list = gather_word(model_.part_lists.data(), blend(mixed, list_index, hn::Zero(di)));
        M open = mixed;
        for (std::uint32_t k = 0; k < model::k_list_length && any(open); ++k) {
            const I part = hn::And(list, set_int(0xff));
            list = shift_right<8>(list);
            open = hn::AndNot(equal(part, set_int(model::k_no_part)), open);
            for (M todo = open; any(todo);) {
                const std::int32_t which = first_of(part, todo);
                const M these = hn::And(todo, equal(part, set_int(which)));
                todo = hn::AndNot(these, todo);
                open = hn::AndNot(decide(static_cast<std::size_t>(which), p, these, inside, certain), open);
            }
        }
        return none();
    }

    void enqueue(std::size_t slot, const V3& p, I place, M rest, M known_inside, M certain)
    {
        HWY_ALIGN float x[k_lanes], y[k_lanes], z[k_lanes];
        HWY_ALIGN std::int32_t places[k_lanes], sure[k_lanes], in[k_lanes];
        hn::Store(p.x, df, x);
        hn::Store(p.y, df, y);
        hn::Store(p.z, df, z);
        hn::Store(place, di, places);
        hn::Store(hn::VecFromMask(di, hn::RebindMask(di, certain)), di, sure);
        hn::Store(hn::VecFromMask(di, hn::RebindMask(di, known_inside)), di, in);
        each_lane(rest, [&](std::size_t i) {
            queue_x_[queued_] = x[i];
            queue_y_[queued_] = y[i];
            queue_z_[queued_] = z[i];
            queue_point_[queued_] = job_.point[slot + i];
            queue_place_[queued_] = static_cast<std::uint32_t>(places[i]);
            queue_flags_[queued_] = static_cast<std::uint8_t>((sure[i] != 0 ? k_certain : 0) | (in[i] != 0 ? k_inside : 0));
            ++queued_;
        });
    }

    /// The nearest surface from the place's first seed, for the lanes where that settles it: contacts among them are written.
    /// inside: lanes known to be. Returns the settled lanes.
    M from_first_seed(std::size_t slot, const V3& p, I place, M active, M inside)
    {
        const I seed = first_seed(p, place, active);
        const I part = hn::And(seed, set_int(0xff));
        M settled = none();
        Found all{hn::Zero(df), {hn::Zero(df), hn::Zero(df), hn::Zero(df)}, {hn::Zero(df), hn::Zero(df), hn::Zero(df)}, none(), none()};
        for (M todo = active; any(todo);) {
            const std::int32_t which = first_of(part, todo);
            const M these = hn::And(todo, equal(part, set_int(which)));
            todo = hn::AndNot(these, todo);
            const Found found = approach(static_cast<std::size_t>(which), p, seed, these);
            const M near = hn::And(these, found.near);
            settled = hn::Or(settled, near);
            inside = hn::Or(inside, hn::And(near, found.inside));
            all.distance_sq = blend(near, found.distance_sq, all.distance_sq);
            all.offset = blend(near, found.offset, all.offset);
            all.normal = blend(near, found.normal, all.normal);
        }
        const F depth = hn::Sqrt(all.distance_sq);
        const M single = hn::Not(not_negative(seed));
        if (any(hn::AndNot(single, settled))) {
            // A chain: settled only within the first seed's reach.
            const F reach = hn::Mul(to_float(first_reach(place, active, p)), set(model::k_seed_reach_step * locator_.cell));
            settled = hn::And(settled, hn::Or(single, hn::Le(depth, reach)));
        }
        const M contact = hn::And(settled, inside);
        if (!any(contact)) return settled;
        const F inverse = hn::Div(set(1.f), hn::Max(hn::Sqrt(dot(all.normal, all.normal)), set(1e-30f)));
        HWY_ALIGN float v[7][k_lanes];
        HWY_ALIGN std::int32_t parts[k_lanes];
        hn::Store(hn::Add(p.x, all.offset.x), df, v[0]);
        hn::Store(hn::Add(p.y, all.offset.y), df, v[1]);
        hn::Store(hn::Add(p.z, all.offset.z), df, v[2]);
        hn::Store(hn::Mul(all.normal.x, inverse), df, v[3]);
        hn::Store(hn::Mul(all.normal.y, inverse), df, v[4]);
        hn::Store(hn::Mul(all.normal.z, inverse), df, v[5]);
        hn::Store(depth, df, v[6]);
        hn::Store(part, di, parts);
        each_lane(contact, [&](std::size_t i) {
            const std::size_t at = result_.contacts++;
            if (at >= job_.out.size()) {
                result_.status |= k_frame_full;
                return;
            }
            job_.out[at] = {{v[0][i], v[1][i], v[2][i]}, {v[3][i], v[4][i], v[5][i]}, v[6][i], job_.point[slot + i],
                            static_cast<std::int16_t>(parts[i]), false, k_ok};
        });
        return settled;
    }

    static std::int32_t first_of(I values, M mask)
    {
        HWY_ALIGN std::int32_t lanes[k_lanes];
        hn::Store(values, di, lanes);
        return lanes[hn::FindFirstTrue(df, mask)];
    }

    /// One part's verdict on the lanes of a mask that its chart holds; returns those.
    M decide(std::size_t index, const V3& p, M active, M& inside, M& certain) const
    {
        const PartLanes part(model_, model_.parts[index]);
        const V3 x = part.to_frame(p);
        const M held = hn::And(active, part.in_domain(x));
        if (!any(held)) return held;
        const Chart q = to_chart(face_point(x));
        const Leaves leaf = part.leaves_at(q.face, q.s, q.t, held, true);
        const I kind = kind_of(leaf.cell);
        const M uniform = equal(kind, set_int(static_cast<std::int32_t>(CellKind::Uniform)));
        const M single = equal(kind, set_int(static_cast<std::int32_t>(CellKind::Single)));
        const F margin = hn::Sub(q.w, part.value(leaf, q.s, q.t).w);
        const M nearer = hn::Gt(margin, hn::Zero(df));  // w above the surface's: between it and the centre
        const M single_inside = part.centre_inside() ? nearer : hn::Not(nearer);
        const M uniform_inside = equal(hn::And(leaf.cell, set_int(1)), set_int(1));
        M in = hn::Or(hn::And(single, single_inside), hn::And(uniform, uniform_inside));
        M sure = hn::Or(uniform, hn::And(single, hn::Gt(hn::Abs(margin), part.deviation(leaf.cell))));
        if (job_.layer == Layer::Two) in = base_verdict(part, q, held, sure, in);
        const M layered = hn::And(held, equal(kind, set_int(static_cast<std::int32_t>(CellKind::Layered))));
        if (any(layered)) ask_layers(model_.parts[index], q, leaf, layered, in, sure);
        inside = hn::Or(inside, hn::And(held, in));
        certain = hn::Or(certain, hn::And(held, sure));
        return held;
    }

    /// Layer 2: what the bounds leave open is decided by the base samples, where all four exist.
    HWY_INLINE M base_verdict(const PartLanes& part, const Chart& q, M held, M sure, M in) const
    {
        const Leaves base = part.leaves_at(q.face, q.s, q.t, held, false);
        const I missing = set_int(model::k_no_surface);
        M open = hn::AndNot(sure, held);
        for (const I c : {base.c00, base.c10, base.c01, base.c11}) open = hn::AndNot(equal(c, missing), open);
        const M nearer = hn::Gt(q.w, part.value(base, q.s, q.t).w);
        return hn::Or(hn::AndNot(open, in), hn::And(open, part.centre_inside() ? nearer : hn::Not(nearer)));
    }

    /// Cells of several surfaces, a lane at a time.
    void ask_layers(const Part& part, const Chart& q, const Leaves& leaves, M layered, M& in, M& sure) const
    {
        const CentralMap map(model_, part);
        HWY_ALIGN float s[k_lanes], t[k_lanes], w[k_lanes];
        HWY_ALIGN std::int32_t now_in[k_lanes] = {}, now_sure[k_lanes] = {};
        const StoredLeaves stored(leaves);
        hn::Store(q.s, df, s);
        hn::Store(q.t, df, t);
        hn::Store(q.w, df, w);
        each_lane(layered, [&](std::size_t i) {
            const ChartVerdict v = classify(stored.leaf(map, i, s[i], t[i]), s[i], t[i], w[i]);
            now_in[i] = v.inside ? -1 : 0;
            now_sure[i] = v.certain ? -1 : 0;
        });
        in = hn::Or(hn::AndNot(layered, in), hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, now_in))));
        sure = hn::Or(hn::AndNot(layered, sure), hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, now_sure))));
    }

    /// Finds the nearest surfaces of what is queued, seed by seed: a round takes one seed of each contact that needs one more,
    /// part after part, so that lanes are full.
    void flush()
    {
        settle();
        std::size_t open = queued_;
        for (std::size_t i = 0; i < queued_; ++i) {
            best_sq_[i] = INFINITY;
            best_part_[i] = -1;
            todo_[i] = static_cast<std::uint16_t>(i);
            seed_at_[i] = model::place_seed(queue_place_[i]);
        }
        while (open > 0) {
            std::uint16_t first[257] = {};
            for (std::size_t k = 0; k < open; ++k) ++first[model::seed_part(model_.seeds[seed_at_[todo_[k]]]) + 1];
            for (std::size_t part = 0; part < model_.parts.size(); ++part) first[part + 1] = static_cast<std::uint16_t>(first[part + 1] + first[part]);
            for (std::size_t k = 0; k < open; ++k) sorted_[first[model::seed_part(model_.seeds[seed_at_[todo_[k]]])]++] = todo_[k];
            std::size_t next = 0;
            for (std::size_t k = 0; k < open;) {
                const std::uint32_t part = model::seed_part(model_.seeds[seed_at_[sorted_[k]]]);
                const std::size_t end = first[part];
                for (; k < end; k += hn::Lanes(df)) approach_queued(part, k, std::min(hn::Lanes(df), end - k), next);
                k = end;
            }
            open = next;
        }
        write();
        queued_ = 0;
    }

    /// The seed that a lane starts from: the only one, or of a chain the one that its octant of the place names.
    HWY_INLINE I first_seed(const V3& p, I place, M active) const
    {
        const I at = blend(active, shift_right<14>(place), hn::Zero(di));
        const I seed = gather_word(model_.seeds.data(), at);
        const M chain = hn::And(active, not_negative(seed));
        if (!any(chain)) return seed;
        return blend(chain, gather_word(model_.seeds.data(), hn::Add(at, octant_choice(p, at, chain))), seed);
    }

    /// Which seed of a chain the octant of a point names: three bits an octant in the word before the chain.
    HWY_INLINE I octant_choice(const V3& p, I at, M chain) const
    {
        const I choices = gather_word(model_.seeds.data(), blend(chain, hn::Sub(at, set_int(1)), hn::Zero(di)));
        const auto upper = [&](F v, float origin, std::int32_t bit) {
            const F in_cells = hn::Mul(hn::Sub(v, set(origin)), set(inverse_cell_));
            return blend(hn::Ge(hn::Sub(in_cells, truncate_float(in_cells)), set(0.5f)), set_int(bit), hn::Zero(di));
        };
        const I octant = hn::Add(hn::Add(upper(p.x, locator_.origin[0], 3), upper(p.y, locator_.origin[1], 6)), upper(p.z, locator_.origin[2], 12));
        return blend(chain, hn::And(hn::Shr(choices, octant), set_int(7)), hn::Zero(di));
    }

    HWY_INLINE I first_reach(I place, M active, const V3& p) const
    {
        const I at = blend(active, shift_right<14>(place), hn::Zero(di));
        const M chain = hn::And(active, not_negative(gather_word(model_.seeds.data(), at)));
        const I which = hn::Add(at, octant_choice(p, at, chain));
        return hn::And(hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(model_.seed_reaches.data()), which), set_int(0xff));
    }

    /// The points' feet on the planes of seeds, about the centres of the places that the points lie in.
    HWY_INLINE V3 foot_on_seed(const V3& p, I seed) const
    {
        constexpr int bits = model::k_seed_normal_bits;
        const I mask = set_int((1 << bits) - 1);
        const F step = set(2.f / static_cast<float>(1 << bits)), half = set(0.5f), one = set(1.f);
        const F x = hn::Sub(hn::Mul(hn::Add(to_float(hn::And(shift_right<8>(seed), mask)), half), step), one);
        const F y = hn::Sub(hn::Mul(hn::Add(to_float(hn::And(shift_right<8 + bits>(seed), mask)), half), step), one);
        const F z = hn::Sub(hn::Sub(one, hn::Abs(x)), hn::Abs(y)), fold = hn::Max(hn::Neg(z), hn::Zero(df));
        const V3 n{blend(hn::Lt(x, hn::Zero(df)), hn::Add(x, fold), hn::Sub(x, fold)),
                   blend(hn::Lt(y, hn::Zero(df)), hn::Add(y, fold), hn::Sub(y, fold)), z};
        const F inverse_sq = hn::Div(one, dot(n, n));
        const F cell = set(locator_.cell);
        const auto from_centre = [&](F v, float origin) {
            const F in_cells = truncate_float(hn::Mul(hn::Sub(v, set(origin)), set(inverse_cell_)));
            return hn::Sub(v, mul_add(hn::Add(in_cells, half), cell, set(origin)));
        };
        const V3 d{from_centre(p.x, locator_.origin[0]), from_centre(p.y, locator_.origin[1]), from_centre(p.z, locator_.origin[2])};
        const F length = hn::Mul(to_float(hn::And(shift_right<22>(seed), set_int(model::k_max_seed_distance))),
                                 set(model::k_seed_distance_step * locator_.cell));
        // (length - n.d / |n|) n / |n|
        const F along = hn::Sub(hn::Mul(length, hn::Sqrt(inverse_sq)), hn::Mul(dot(n, d), inverse_sq));
        return {mul_add(along, n.x, p.x), mul_add(along, n.y, p.y), mul_add(along, n.z, p.z)};
    }

    /// Nearest surface about a seed, the model's space.
    struct Found {
        F distance_sq;
        V3 offset;  // from the point
        V3 normal;  // outward, not of unit length
        M near;     // the point is right above the surface point
        M inside;   // it is below the surface, if near
    };

    /// From a seed to the nearest surface about it: the foot on its plane, the surface over there, the foot on the tangent plane,
    /// while that comes nearer. Lanes stop on their own, so that an answer does not depend on its neighbours.
    HWY_NOINLINE Found approach(std::size_t index, const V3& p, I seed, M active) const
    {
        const Part& data = model_.parts[index];
        const PartLanes part(model_, data);
        const V3 x = part.to_frame(p);
        const V3 axes{set(data.a[0]), set(data.a[1]), set(data.a[2])};
        const V3 over_sq{set(1.f / (data.a[0] * data.a[0])), set(1.f / (data.a[1] * data.a[1])), set(1.f / (data.a[2] * data.a[2]))};
        const FacePoint start = face_point(part.to_frame(foot_on_seed(p, seed)));
        Chart q = to_chart(start);
        F reach = hn::Abs(start.major);  // along the face's axis: of several surfaces the one nearest to there
        M all_near = none(), all_inside = none();
        const F touching_sq = set(1e-9f * model_.header.sphere[3] * model_.header.sphere[3]);
        F found_sq = set(INFINITY);
        V3 found_offset{hn::Zero(df), hn::Zero(df), hn::Zero(df)}, found_plane = found_offset;
        for (int step = 0; step < k_approach_steps && any(active); ++step) {
            const Leaves leaf = part.leaves_at(q.face, q.s, q.t, active, job_.layer != Layer::Two);
            Sheet sheet = part.value(leaf, q.s, q.t);
            const I kind = kind_of(leaf.cell);
            M valid = hn::And(active, equal(kind, set_int(static_cast<std::int32_t>(CellKind::Single))));
            M exits = part.centre_inside() ? valid : none();
            const M layered = hn::And(active, equal(kind, set_int(static_cast<std::int32_t>(CellKind::Layered))));
            if (any(layered)) pick_layer(data, q, leaf, reach, layered, sheet, valid, exits);
            valid = hn::And(valid, hn::Gt(sheet.w, set(1e-6f)));
            active = valid;
            if (!any(active)) break;
            // Coordinates by face; the surface point there.
            const I axis = hn::ShiftRight<1>(q.face);
            FacePoint f;
            f.x_major = equal(axis, hn::Zero(di));
            f.y_major = equal(axis, set_int(1));
            const V3 y = f.permute(x), a = f.permute(axes), inverse_sq = f.permute(over_sq);
            const F sign = blend(equal(hn::And(q.face, set_int(1)), set_int(1)), set(-1.f), set(1.f));
            const F rho = hn::Div(set(1.f), sheet.w);
            const V3 foot{hn::Mul(sign, rho), hn::Mul(q.s, rho), hn::Mul(q.t, rho)};
            const V3 d{hn::Mul(a.x, hn::Sub(foot.x, y.x)), hn::Mul(a.y, hn::Sub(foot.y, y.y)), hn::Mul(a.z, hn::Sub(foot.z, y.z))};
            const F distance_sq = dot(d, d);
            const M nearer = hn::And(active, hn::Lt(distance_sq, found_sq));
            const V3 n{hn::Mul(sign, hn::Sub(hn::Sub(sheet.w, hn::Mul(sheet.ws, q.s)), hn::Mul(sheet.wt, q.t))), sheet.ws, sheet.wt};
            const V3 scaled{hn::Mul(inverse_sq.x, n.x), hn::Mul(inverse_sq.y, n.y), hn::Mul(inverse_sq.z, n.z)};
            const F length_sq = dot(n, scaled), gap = hn::Sub(set(1.f), dot(n, y));
            const M regular = hn::Gt(length_sq, set(0.f));
            const F along = hn::Div(gap, hn::Max(length_sq, set(1e-30f)));
            const F plane_sq = hn::Mul(gap, along);
            // So near above the surface point that the tangent plane's foot is as good.
            const M above = hn::And(hn::And(nearer, regular), hn::Le(distance_sq, mul_add(set(k_approach_near), plane_sq, touching_sq)));
            all_near = hn::Or(all_near, above);
            const M below = hn::Gt(gap, hn::Zero(df));
            all_inside = hn::Or(all_inside, hn::And(above, hn::Or(hn::And(exits, below), hn::AndNot(hn::Or(exits, below), above))));
            const V3 in_plane{hn::Mul(hn::Mul(along, scaled.x), a.x), hn::Mul(hn::Mul(along, scaled.y), a.y), hn::Mul(hn::Mul(along, scaled.z), a.z)};
            found_sq = blend(above, plane_sq, blend(nearer, distance_sq, found_sq));
            found_offset = blend(nearer, f.unpermute(blend(above, in_plane, d)), found_offset);
            const V3 normal{hn::Mul(scaled.x, a.x), hn::Mul(scaled.y, a.y), hn::Mul(scaled.z, a.z)};
            const V3 minus{hn::Neg(normal.x), hn::Neg(normal.y), hn::Neg(normal.z)};
            found_plane = blend(nearer, f.unpermute(blend(exits, normal, minus)), found_plane);
            active = hn::AndNot(above, hn::And(nearer, regular));
            if (!any(active)) break;
            const V3 next{mul_add(along, scaled.x, y.x), mul_add(along, scaled.y, y.y), mul_add(along, scaled.z, y.z)};
            const FacePoint fp = face_point(f.unpermute(next));
            q = to_chart(fp);
            reach = hn::Abs(fp.major);
        }
        return {found_sq, part.from_frame(found_offset), part.from_frame(found_plane), all_near, all_inside};
    }

    /// The same for a run of the queue with seeds of one part; those whose chain goes on join the next round.
    void approach_queued(std::uint32_t index, std::size_t first, std::size_t count, std::size_t& next_open)
    {
        HWY_ALIGN float px[k_lanes], py[k_lanes], pz[k_lanes];
        HWY_ALIGN std::int32_t seeds[k_lanes];
        for (std::size_t i = 0; i < hn::Lanes(df); ++i) {
            const std::size_t k = sorted_[first + std::min(i, count - 1)];
            px[i] = queue_x_[k];
            py[i] = queue_y_[k];
            pz[i] = queue_z_[k];
            seeds[i] = static_cast<std::int32_t>(model_.seeds[seed_at_[k]]);
        }
        const V3 p{hn::Load(df, px), hn::Load(df, py), hn::Load(df, pz)};
        const Found found = approach(index, p, hn::Load(di, seeds), hn::FirstN(df, count));
        HWY_ALIGN float distance_sq[k_lanes], values[6][k_lanes];
        hn::Store(found.distance_sq, df, distance_sq);
        hn::Store(found.offset.x, df, values[0]);
        hn::Store(found.offset.y, df, values[1]);
        hn::Store(found.offset.z, df, values[2]);
        hn::Store(found.normal.x, df, values[3]);
        hn::Store(found.normal.y, df, values[4]);
        hn::Store(found.normal.z, df, values[5]);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint16_t k = sorted_[first + i];
            if (distance_sq[i] < best_sq_[k]) {
                best_sq_[k] = distance_sq[i];
                best_part_[k] = static_cast<std::int16_t>(index);
                for (int v = 0; v < 6; ++v) best_[v][k] = values[v][i];
            }
            const float enough = locator_.cell * (model::k_seed_reach_step * static_cast<float>(model_.seed_reaches[seed_at_[k]]));
            if ((model_.seeds[seed_at_[k]] & model::k_last_seed) != 0 || distance_sq[i] <= enough * enough) continue;
            ++seed_at_[k];
            todo_[next_open++] = k;
        }
    }

    /// Of the surfaces over a layered leaf that one which is nearest to where the surface is expected.
    void pick_layer(const Part& data, const Chart& q, const Leaves& leaves, F reach, M layered, Sheet& sheet, M& valid, M& exits) const
    {
        const CentralMap map(model_, data);
        HWY_ALIGN float s[k_lanes], t[k_lanes], expected[k_lanes], w[k_lanes] = {}, ws[k_lanes] = {}, wt[k_lanes] = {};
        HWY_ALIGN std::int32_t is_valid[k_lanes] = {}, is_exit[k_lanes] = {};
        const StoredLeaves stored(leaves);
        hn::Store(q.s, df, s);
        hn::Store(q.t, df, t);
        hn::Store(reach, df, expected);
        each_lane(layered, [&](std::size_t i) {
            const Leaf leaf = stored.leaf(map, i, s[i], t[i]);
            float least = INFINITY;
            for (int j = 0; j < leaf.sheets; ++j) {
                const SheetValue v = sheet_value(leaf, j, s[i], t[i]);
                if (!(v.w > 1e-6f)) continue;
                const float miss = std::abs(1.f / v.w - expected[i]);
                if (!(miss < least)) continue;
                least = miss;
                w[i] = v.w;
                ws[i] = v.ws;
                wt[i] = v.wt;
                is_valid[i] = -1;
                is_exit[i] = leaf.centre_inside == ((j & 1) == 0) ? -1 : 0;
            }
        });
        sheet = {blend(layered, hn::Load(df, w), sheet.w), blend(layered, hn::Load(df, ws), sheet.ws), blend(layered, hn::Load(df, wt), sheet.wt)};
        valid = hn::Or(valid, hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, is_valid))));
        exits = hn::Or(hn::AndNot(layered, exits), hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, is_exit))));
    }

    /// Decides what the lanes left open, and drops what turns out free.
    void settle()
    {
        if (job_.layer == Layer::Three)
            for (std::size_t first = 0; first < queued_; first += hn::Lanes(df)) {
                const M here = hn::FirstN(df, std::min(queued_ - first, hn::Lanes(df)));
                const V3 p{hn::LoadU(df, queue_x_ + first), hn::LoadU(df, queue_y_ + first), hn::LoadU(df, queue_z_ + first)};
                const I place = hn::LoadU(di, reinterpret_cast<const std::int32_t*>(queue_place_ + first));
                const M mixed = hn::And(here, equal(hn::And(place, set_int(3)), set_int(static_cast<std::int32_t>(PlaceKind::Mixed))));
                if (!any(mixed)) continue;
                M inside = none(), certain = none();
                verdicts(p, place, mixed, inside, certain);
                HWY_ALIGN std::int32_t in[k_lanes], sure[k_lanes];
                hn::Store(hn::VecFromMask(di, hn::RebindMask(di, inside)), di, in);
                hn::Store(hn::VecFromMask(di, hn::RebindMask(di, certain)), di, sure);
                each_lane(mixed, [&](std::size_t i) {
                    queue_flags_[first + i] = static_cast<std::uint8_t>((in[i] != 0 ? k_inside : k_free) | (sure[i] != 0 ? k_certain : 0));
                });
            }
        std::size_t kept = 0;
        for (std::size_t i = 0; i < queued_; ++i) {
            std::uint8_t flags = queue_flags_[i];
            if ((flags & k_free) != 0) continue;
            if ((flags & k_inside) == 0) {
                const Contact c = query_central(model_, {queue_x_[i], queue_y_[i], queue_z_[i]}, job_.layer);
                if (!c.contact) continue;
                flags = c.certain ? k_certain : 0;
            }
            queue_x_[kept] = queue_x_[i];
            queue_y_[kept] = queue_y_[i];
            queue_z_[kept] = queue_z_[i];
            queue_point_[kept] = queue_point_[i];
            queue_place_[kept] = queue_place_[i];
            queue_flags_[kept++] = flags;
        }
        queued_ = kept;
    }

    void write()
    {
        const float on_surface_sq = 1e-8f * model_.header.sphere[3] * model_.header.sphere[3];
        for (std::size_t i = 0; i < queued_; ++i) {
            const std::size_t slot = result_.contacts++;
            if (slot >= job_.out.size()) {
                result_.status |= k_frame_full;
                continue;
            }
            FrameContact& c = job_.out[slot];
            c.index = queue_point_[i];
            c.certain = (queue_flags_[i] & k_certain) != 0;
            c.status = k_ok;
            if (best_part_[i] >= 0) {
                const Vec3f offset{best_[0][i], best_[1][i], best_[2][i]};
                c.depth = std::sqrt(best_sq_[i]);
                // Away from the surface the way out is the way to the nearest point; on it, the surface's own normal.
                c.normal = best_sq_[i] > on_surface_sq ? offset / c.depth : normalized(Vec3f{best_[3][i], best_[4][i], best_[5][i]});
                c.point = Vec3f{queue_x_[i], queue_y_[i], queue_z_[i]} + offset;
                c.part = best_part_[i];
                continue;
            }
            // No map knows a surface about the seed: the search over all of them does.
            const Contact found = query_central(model_, {queue_x_[i], queue_y_[i], queue_z_[i]}, job_.layer);
            c.depth = found.depth;
            c.normal = found.normal;
            c.point = found.point;
            c.part = static_cast<std::int16_t>(found.part);
            ++result_.searched;
        }
    }

    const FrameJob& job_;
    const ModelView& model_;
    const model::Locator& locator_;
    float inverse_cell_;
    float cells_[3];
    FrameResult result_;
    std::size_t queued_ = 0;
    float queue_x_[k_queue + Probe::k_cluster], queue_y_[k_queue + Probe::k_cluster], queue_z_[k_queue + Probe::k_cluster];
    std::uint32_t queue_point_[k_queue + Probe::k_cluster], queue_place_[k_queue + Probe::k_cluster];
    std::uint8_t queue_flags_[k_queue + Probe::k_cluster];
    // Nearest surface so far of what is queued: squared distance, offset from the point, surface normal (not of unit length).
    float best_sq_[k_queue + Probe::k_cluster], best_[6][k_queue + Probe::k_cluster];
    std::int16_t best_part_[k_queue + Probe::k_cluster];
    std::uint32_t seed_at_[k_queue + Probe::k_cluster];
    std::uint16_t todo_[k_queue + Probe::k_cluster], sorted_[k_queue + Probe::k_cluster];
};

}  // namespace

FrameResult run(const FrameJob& job) { return FrameKernel(job).run(); }

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(run);

FrameResult run_frame(const FrameJob& job) noexcept { return HWY_DYNAMIC_DISPATCH(run)(job); }

}  // namespace sqmap::query
#endif
