// K. Moustakas, D. Tzovaras, M. G. Strintzis, SQ-Map, IEEE TVCG 13(1), 2007, section 4.2, for many points at once. Compiled
// for each instruction set by Highway (J. Wassenberg et al.); no fused multiply-add, so that all give the same bits.
#include "probe_kernels.h"

#include "central_query.h"
#include "model/approach.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/point/probe_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "flat-inl.h"

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using model::CellKind;
using model::CentralMap;
using model::ChartVerdict;
using model::k_approach_near;
using model::k_approach_steps;
using model::Leaf;
using model::Part;

HWY_INLINE I kind_of(I cell) { return shift_right<14>(cell); }

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

    HWY_INLINE Leaves leaves_at(I face, F s, F t, M active, bool refined) const
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
                const I record =
                    hn::Mul(blend(split, hn::And(leaf.cell, set_int(0x3fff)), hn::Zero(di)), set_int(model::k_split_size));
                const I x = blend(right, set_int(1), hn::Zero(di)), y = blend(up, set_int(1), hn::Zero(di));
                const I cell = hn::Add(hn::Add(record, set_int(model::k_split_cells)), hn::Add(x, hn::Add(y, y)));
                leaf.cell = blend(split, low(gather_pair(splits_, cell)), leaf.cell);
                // The samples below the middle, left of it, in it, right of it and above it.
                const I first = gather_pair(splits_, record), second = gather_pair(splits_, hn::Add(record, set_int(2)));
                const I s_low = low(first), t_low = high(first), middle = low(second), t_high = high(second),
                        s_high = low(gather_pair(splits_, hn::Add(record, set_int(4))));
                const auto choose = [&](I old, I lower_left, I lower_right, I upper_left, I upper_right) {
                    return blend(split, blend(up, blend(right, upper_right, upper_left), blend(right, lower_right, lower_left)),
                                 old);
                };
                leaf.c00 = choose(leaf.c00, leaf.c00, s_low, t_low, middle);
                leaf.c10 = choose(leaf.c10, s_low, leaf.c10, middle, t_high);
                leaf.c01 = choose(leaf.c01, t_low, middle, leaf.c01, s_high);
                leaf.c11 = choose(leaf.c11, middle, t_high, s_high, leaf.c11);
            }
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

class ProbeKernel : Places {
public:
    explicit ProbeKernel(const ProbeJob& job) : Places(job), lowest_planes_(*this) {}

    ProbeResult run()
    {
        each_near([&](std::size_t slot) { collect(slot); },
                  [&] {
                      // Between clusters only, whatever a vector holds of one: the order of the answers is the same for all.
                      if (addressed_.count > k_addressed - Probe::k_cluster) read_places();
                  },
                  [&] {
                      if (job_.first_only) finish();
                      return !job_.first_only || result_.contacts == 0;
                  });
        finish();
        return result_;
    }

private:
    static constexpr std::size_t k_queue = 1024;
    static constexpr std::size_t k_addressed = 256;
    static constexpr int k_first_steps = 2;
    static constexpr std::int32_t k_whole = std::numeric_limits<std::int32_t>::min();  ///< of a place's index: it is a brick
    enum Flag : std::int32_t { k_certain = 1, k_inside = 2, k_free = 4, k_single = 8 };

    void finish()
    {
        read_places();
        answer_located();
        if (queued_ > 0) search();
    }

    /// Poses a vector of points from a slot on, keeps those whose places have to be read, side by side, and has these fetched:
    /// between two queries others use the caches, and what a query mostly does is wait for places.
    HWY_NOINLINE void collect(std::size_t slot)
    {
        const Posed e = pose(slot);
        const Address a = address(e.in_cells, e.in_grid);
        const M read = hn::AndNot(a.free_brick, e.in_grid);
        if (!any(read)) return;
        fetch(model_.places.data(), a.index, read);
        const I whole = hn::IfThenElseZero(hn::RebindMask(di, a.whole), set_int(k_whole));
        addressed_.add(e.p, a.offset, hn::Or(a.index, whole),
                       hn::LoadU(di, reinterpret_cast<const std::int32_t*>(job_.point + slot)), read);
    }

    /// Reads the places of the points that were collected and keeps those that may be inside.
    HWY_NOINLINE void read_places()
    {
        if (located_.count > LocatedPoints::k_size - k_addressed) answer_located();
        for (std::size_t first = 0; first < addressed_.count; first += hn::Lanes(df)) {
            const I word = hn::LoadU(di, addressed_.place + first);
            const M present = addressed_.present(first), whole = hn::RebindMask(df, hn::Lt(word, hn::Zero(di)));
            const I place = gather_word(model_.places.data(),
                                        hn::IfThenElseZero(hn::RebindMask(di, present), hn::And(word, set_int(~k_whole))));
            const M occupied = hn::AndNot(is_free(place, whole), present);
            if (!any(occupied)) continue;
            fetch_next(place, occupied);
            located_.add(LocatedPoints::load(addressed_.p, first), LocatedPoints::load(addressed_.offset, first), place,
                         hn::LoadU(di, addressed_.point + first), occupied);
        }
        addressed_.count = 0;
    }

    /// What is read next: planes of flat places, eighths of divided ones.
    HWY_INLINE void fetch_next(I place, M occupied) const
    {
        const M divided = is_divided(place, occupied), flat = is_flat(place, occupied);
        const I at = shift_right<14>(place);
        if (any(divided)) fetch(model_.places.data(), at, divided);
        if (any(flat)) fetch(model_.planes.data(), at, flat);
    }

    HWY_NOINLINE void answer_located()
    {
        if (queued_ > k_queue - LocatedPoints::k_size) search();
        for (std::size_t first = 0; first < located_.count; first += hn::Lanes(df)) {
            V3 offset = LocatedPoints::load(located_.offset, first);
            I place = hn::LoadU(di, located_.place + first), index = hn::Zero(di);
            M occupied = located_.present(first);
            const M divided = is_divided(place, occupied);
            divide(place, index, offset, occupied);
            if (any(divided)) fetch_next(place, hn::And(divided, occupied));
            if (job_.layer == Layer::One) {
                ask_superquadrics(first, occupied);
                continue;
            }
            located_.set(first, offset, sort_out(first, offset, place, occupied));
        }
        if (job_.layer != Layer::One)
            lowest_planes_.find(located_,
                                [&](std::size_t first, M flat, const FlatPlanes& lowest) { write_flat(first, flat, lowest); });
        located_.count = 0;
    }

    /// What the planes of its place answer, for each lane: the place, with what is known of the side instead of its kind. 0 for
    /// the others, which are free, or queued for the charts.
    HWY_INLINE I sort_out(std::size_t first, const V3& offset, I place, M occupied)
    {
        const V3 p = LocatedPoints::load(located_.p, first);
        const M flat = is_flat(place, occupied), inside = is_inside(place, occupied);
        M by_planes = flat, in = inside, certain = inside, rest = hn::AndNot(flat, occupied);
        if (job_.layer == Layer::Two) {
            // The nearest surface tells no side here.
            const M mixed =
                hn::And(occupied, equal(hn::And(place, set_int(3)), set_int(static_cast<std::int32_t>(LocatorCellKind::Mixed))));
            M undecided = hn::AndNot(hn::Or(inside, mixed), occupied);
            if (any(mixed)) verdicts(p, place, mixed, in, certain);
            if (const M now = hn::And(undecided, flat); any(now)) {
                ask_points(p, now, in, certain);
                undecided = hn::AndNot(flat, undecided);
            }
            by_planes = hn::And(in, flat);
            rest = hn::AndNot(flat, hn::Or(in, undecided));
            in = hn::AndNot(undecided, in);
        }
        if (any(rest))
            enqueue(p, offset, place, hn::LoadU(di, located_.point + first), start_of(place, offset, rest), rest, in, certain);
        const I known = hn::Or(hn::IfThenElseZero(hn::RebindMask(di, in), set_int(k_inside)),
                               hn::IfThenElseZero(hn::RebindMask(di, certain), set_int(k_certain)));
        return hn::IfThenElseZero(hn::RebindMask(di, by_planes), hn::Or(hn::AndNot(set_int(3), place), known));
    }

    HWY_INLINE void write_flat(std::size_t first, M flat, const FlatPlanes& lowest)
    {
        const I place = hn::LoadU(di, located_.place + first);
        const F gap = hn::Mul(lowest.gap, set(locator_.cell)), zero = hn::Zero(df);
        const M inside = hn::RebindMask(df, hn::Ne(hn::And(place, set_int(k_inside)), hn::Zero(di)));
        const M contact = hn::And(flat, hn::Or(inside, hn::Gt(gap, zero)));
        if (!any(contact)) return;
        const F depth = hn::Max(gap, zero);
        const V3 p = LocatedPoints::load(located_.p, first);
        const V3 normal = octahedral_normal<model::k_plane_normal_bits>(lowest.plane);
        const I sure = hn::IfThenElseZero(
            hn::RebindMask(di, hn::RebindMask(df, hn::Ne(hn::And(place, set_int(k_certain)), hn::Zero(di)))), set_int(1 << 16));
        write_lanes(contact, {mul_add(depth, normal.x, p.x), mul_add(depth, normal.y, p.y), mul_add(depth, normal.z, p.z)},
                    normal, depth, hn::LoadU(di, located_.point + first), hn::Or(part_of(place, lowest.plane, contact), sure));
    }

    /// Contacts as ProbeContact has them: eight words, and a ninth of part (16 bits), certain and status.
    HWY_INLINE void write_lanes(M which, const V3& point, const V3& normal, F depth, I index, I ninth)
    {
        static_assert(sizeof(ProbeContact) == 36 && offsetof(ProbeContact, normal) == 12 && offsetof(ProbeContact, depth) == 24 &&
                      offsetof(ProbeContact, index) == 28 && offsetof(ProbeContact, part) == 32 &&
                      offsetof(ProbeContact, certain) == 34 && k_ok == 0);
        HWY_ALIGN float low[4 * k_lanes], high[4 * k_lanes];
        HWY_ALIGN std::int32_t last[k_lanes];
        const auto packed = [&](F v) { return hn::Compress(v, which); };
        hn::StoreInterleaved4(packed(point.x), packed(point.y), packed(point.z), packed(normal.x), df, low);
        hn::StoreInterleaved4(packed(normal.y), packed(normal.z), packed(depth), packed(hn::BitCast(df, index)), df, high);
        hn::Store(hn::Compress(ninth, hn::RebindMask(di, which)), di, last);
        const std::size_t count = hn::CountTrue(df, which), at = std::min(result_.contacts, job_.out.size()),
                          room = std::min(count, job_.out.size() - at);
        auto* to = reinterpret_cast<std::byte*>(job_.out.data() + at);
        for (std::size_t i = 0; i < room; ++i, to += sizeof(ProbeContact)) {
            std::memcpy(to, low + 4 * i, 16);
            std::memcpy(to + 16, high + 4 * i, 16);
            std::memcpy(to + 32, last + i, 4);
        }
        result_.contacts += count;
        if (room < count) result_.status |= k_probe_full;
    }

    /// Layer 1: of the points that are not in free places those that a superquadric holds.
    HWY_NOINLINE void ask_superquadrics(std::size_t first, M occupied)
    {
        each_lane(occupied, [&](std::size_t i) {
            const std::size_t k = first + i;
            if (job_.first_only && result_.contacts > 0) return;
            const Contact c = query_point(model_, Vec3f{located_.p[0][k], located_.p[1][k], located_.p[2][k]}, job_.layer);
            if (c.contact) write(static_cast<std::uint32_t>(located_.point[k]), c.part, c.point, c.normal, c.depth, c.certain);
        });
    }

    /// Verdicts on lanes, one by one.
    HWY_NOINLINE void ask_points(const V3& p, M which, M& in, M& certain) const
    {
        HWY_ALIGN float x[k_lanes], y[k_lanes], z[k_lanes];
        HWY_ALIGN std::int32_t now_in[k_lanes] = {}, now_sure[k_lanes] = {};
        hn::Store(p.x, df, x);
        hn::Store(p.y, df, y);
        hn::Store(p.z, df, z);
        each_lane(which, [&](std::size_t i) {
            const PointVerdict v = verdict_central(model_, {x[i], y[i], z[i]}, job_.layer);
            now_in[i] = v.inside ? -1 : 0;
            now_sure[i] = v.certain ? -1 : 0;
        });
        in = hn::Or(in, hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, now_in))));
        certain = hn::Or(certain, hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, now_sure))));
    }

    /// Where a lane's search starts: at the only seed of its place, or of a chain at the one that its octant names.
    struct Start {
        SeedPlanes planes;
        M single;
        I chain;  // index of the chain's first seed
        F reach;  // a surface found within is the nearest, model units
    };
    HWY_INLINE Start start_of(I place, const V3& offset, M occupied) const
    {
        const auto* words = reinterpret_cast<const std::uint32_t*>(model_.seeds.data());
        Start start;
        start.chain = blend(occupied, shift_right<14>(place), hn::Zero(di));
        I word = hn::Add(start.chain, start.chain);
        I direction = gather_word(words, word), extent = gather_word(words + 1, word);
        start.single = hn::Not(not_negative(extent));
        const M chain = hn::AndNot(start.single, occupied);
        if (any(chain)) {
            const I choices = gather_word(words, blend(chain, hn::Sub(word, set_int(2)), hn::Zero(di)));
            const auto upper = [&](F v, std::int32_t bit) { return blend(hn::Gt(v, hn::Zero(df)), set_int(bit), hn::Zero(di)); };
            const I octant3 = hn::Add(hn::Add(upper(offset.x, 3), upper(offset.y, 6)), upper(offset.z, 12));
            const I choice = blend(chain, hn::And(hn::Shr(choices, octant3), set_int(7)), hn::Zero(di));
            word = hn::Add(word, hn::Add(choice, choice));
            direction = gather_word(words, word);
            extent = gather_word(words + 1, word);
        }
        start.planes = planes_of(direction, extent, offset);
        start.reach =
            hn::Mul(to_float(hn::And(shift_right<16>(extent), set_int(0xff))), set(model::k_seed_reach_step * locator_.cell));
        return start;
    }

    /// The verdict of the first part of each place's list that holds the point; held by none, it is free by the cover.
    void verdicts(const V3& p, I place, M mixed, M& inside, M& certain) const
    {
        const I list_index = hn::And(shift_right<2>(place), set_int(0x1ff));
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
    }

    HWY_NOINLINE void enqueue(const V3& p, const V3& offset, I place, I point, const Start& start, M which, M known_inside,
                              M certain)
    {
        const I flags = hn::Or(hn::IfThenElseZero(hn::RebindMask(di, known_inside), set_int(k_inside)),
                               hn::Or(hn::IfThenElseZero(hn::RebindMask(di, certain), set_int(k_certain)),
                                      hn::IfThenElseZero(hn::RebindMask(di, start.single), set_int(k_single))));
        const SeedPlanes& planes = start.planes;
        const std::size_t n = queued_;
        const F floats[10] = {p.x,
                              p.y,
                              p.z,
                              offset.x,
                              offset.y,
                              offset.z,
                              mul_add(planes.gap, planes.normal.x, p.x),
                              mul_add(planes.gap, planes.normal.y, p.y),
                              mul_add(planes.gap, planes.normal.z, p.z),
                              start.reach};
        for (int k = 0; k < 10; ++k) pack(floats[k], which, queue_[k] + n);
        pack(place, which, queue_place_ + n);
        pack(point, which, queue_point_ + n);
        pack(start.chain, which, queue_seed_ + n);
        pack(planes.part, which, queue_part_ + n);
        pack(flags, which, queue_flags_ + n);
        queued_ += hn::CountTrue(df, which);
    }

    static std::int32_t first_of(I values, M mask)
    {
        HWY_ALIGN std::int32_t lanes[k_lanes];
        hn::Store(values, di, lanes);
        return lanes[hn::FindFirstTrue(df, mask)];
    }

    /// One part's verdict on the lanes of a mask that its chart holds; returns those.
    HWY_NOINLINE M decide(std::size_t index, const V3& p, M active, M& inside, M& certain) const
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
        const M open = with_corners(base, hn::AndNot(sure, held));
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

    /// Answers what is queued, part after part so that lanes are full: first each point by its first seed, which settles most,
    /// then the rest by its verdict and, round by round, by every seed of its chain.
    HWY_NOINLINE void search()
    {
        std::size_t open = queued_;
        for (std::size_t i = 0; i < queued_; ++i) todo_[i] = static_cast<std::uint16_t>(i);
        if (job_.layer != Layer::Two) open = round(queued_, true);
        open = settle(open);
        for (std::size_t k = 0; k < open; ++k) {
            const std::size_t i = todo_[k];
            best_[6][i] = INFINITY;
            best_part_[i] = -1;
            queue_part_[i] = static_cast<std::int32_t>(model::seed_part(model_.seeds[static_cast<std::size_t>(queue_seed_[i])]));
            kept_[k] = todo_[k];
        }
        const std::size_t kept = open;
        while (open > 0) open = round(open, false);
        for (std::size_t k = 0; k < kept; ++k) {
            const std::size_t i = kept_[k];
            const bool certain = (queue_flags_[i] & k_certain) != 0;
            const auto point = static_cast<std::uint32_t>(queue_point_[i]);
            result_.unseen += best_by_plane_[i] ? 1u : 0u;
            write(point, best_part_[i], {best_[0][i], best_[1][i], best_[2][i]}, {best_[3][i], best_[4][i], best_[5][i]},
                  best_[6][i], certain);
        }
        queued_ = 0;
    }

    Vec3f queued_point(std::size_t i) const { return {queue_[0][i], queue_[1][i], queue_[2][i]}; }

    /// One seed for each of todo_[0, open), part after part. Returns how many need another.
    HWY_NOINLINE std::size_t round(std::size_t open, bool first_round)
    {
        std::uint16_t first[257] = {};
        for (std::size_t k = 0; k < open; ++k) ++first[queue_part_[todo_[k]] + 1];
        for (std::size_t part = 0; part < model_.parts.size(); ++part)
            first[part + 1] = static_cast<std::uint16_t>(first[part + 1] + first[part]);
        for (std::size_t k = 0; k < open; ++k) sorted_[first[queue_part_[todo_[k]]]++] = todo_[k];
        std::size_t next = 0;
        for (std::size_t k = 0; k < open;) {
            const auto part = static_cast<std::uint32_t>(queue_part_[sorted_[k]]);
            const std::size_t end = first[part];
            for (; k < end; k += hn::Lanes(df)) approach_queued(part, k, std::min(hn::Lanes(df), end - k), first_round, next);
            k = end;
        }
        return next;
    }

    /// Nearest surface about a seed, the model's space.
    struct Found {
        F distance_sq;
        V3 offset;  // from the point
        V3 normal;  // outward, not of unit length
        M near;     // the point is right above the surface point
        M inside;   // it is below the surface, if near
    };

    /// The nearest surface of one part about a start, or where there is none about origin: the surface over there, the foot on
    /// the tangent plane for the next start, while that comes nearer. Lanes stop on their own, so that an answer does not depend
    /// on its neighbours.
    HWY_NOINLINE Found approach(std::size_t index, const V3& p, const V3& start, const V3& origin, M active, int steps) const
    {
        const Part& data = model_.parts[index];
        const PartLanes part(model_, data);
        // Metric coordinates in the part's frame, and what divides them into the chart's.
        const V3 z = part.to_metric(p);
        const V3 axes{set(data.a[0]), set(data.a[1]), set(data.a[2])};
        const V3 inverse{set(1.f / data.a[0]), set(1.f / data.a[1]), set(1.f / data.a[2])};
        FacePoint f = face_point(times(part.to_metric(start), inverse));
        Chart q = to_chart(f);
        F reach = hn::Abs(f.major);  // along the face's axis: of several surfaces the one nearest to there
        M all_near = none(), all_inside = none(), kept_exits = none();
        const F touching_sq = set(1e-9f * model_.header.sphere[3] * model_.header.sphere[3]);
        F found_sq = set(INFINITY), kept_along = hn::Zero(df);
        V3 kept_n{hn::Zero(df), hn::Zero(df), hn::Zero(df)}, kept_d = kept_n;
        I kept_face = q.face;
        for (int step = 0; step < steps; ++step) {
            const Leaves leaf = part.leaves_at(q.face, q.s, q.t, active, job_.layer != Layer::Two);
            Sheet sheet = part.value(leaf, q.s, q.t);
            const I kind = kind_of(leaf.cell);
            M valid = hn::And(active, equal(kind, set_int(static_cast<std::int32_t>(CellKind::Single))));
            if (job_.layer == Layer::Two) valid = with_corners(leaf, active);
            M exits = part.centre_inside() ? valid : none();
            const M layered =
                hn::AndNot(valid, hn::And(active, equal(kind, set_int(static_cast<std::int32_t>(CellKind::Layered)))));
            if (any(layered)) pick_layer(data, q, leaf, reach, layered, sheet, valid, exits);
            valid = hn::And(valid, hn::Gt(sheet.w, set(1e-6f)));
            if (step == 0 && any(hn::AndNot(valid, active))) {
                // Nothing over the point's foot: over the foot of the place's centre there is.
                const M lost = hn::AndNot(valid, active);
                const FacePoint again = face_point(times(part.to_metric(origin), inverse));
                const Chart there = to_chart(again);
                const F there_reach = hn::Abs(again.major);
                const Leaves second = part.leaves_at(there.face, there.s, there.t, lost, job_.layer != Layer::Two);
                Sheet other = part.value(second, there.s, there.t);
                const I other_kind = kind_of(second.cell);
                M found = hn::And(lost, equal(other_kind, set_int(static_cast<std::int32_t>(CellKind::Single))));
                if (job_.layer == Layer::Two) found = with_corners(second, lost);
                M other_exits = part.centre_inside() ? found : none();
                const M layers =
                    hn::AndNot(found, hn::And(lost, equal(other_kind, set_int(static_cast<std::int32_t>(CellKind::Layered)))));
                if (any(layers)) pick_layer(data, there, second, there_reach, layers, other, found, other_exits);
                found = hn::And(found, hn::Gt(other.w, set(1e-6f)));
                sheet = {blend(found, other.w, sheet.w), blend(found, other.ws, sheet.ws), blend(found, other.wt, sheet.wt)};
                q = {blend(found, there.face, q.face), blend(found, there.s, q.s), blend(found, there.t, q.t), q.w};
                exits = hn::Or(exits, hn::And(found, other_exits));
                valid = hn::Or(valid, found);
            }
            active = valid;
            if (!any(active)) break;
            // Coordinates by face; the surface point there.
            const I axis = hn::ShiftRight<1>(q.face);
            f.x_major = equal(axis, hn::Zero(di));
            f.y_major = equal(axis, set_int(1));
            const V3 y = f.permute(z), a = f.permute(axes), over = f.permute(inverse);
            const F one = set(1.f), sign = hn::CopySign(one, hn::BitCast(df, hn::ShiftLeft<31>(q.face)));
            const F rho = hn::Div(one, hn::Max(sheet.w, set(1e-18f)));  // lanes that are done may hold 0
            const V3 d{hn::Sub(hn::Mul(a.x, hn::Mul(sign, rho)), y.x), hn::Sub(hn::Mul(a.y, hn::Mul(q.s, rho)), y.y),
                       hn::Sub(hn::Mul(a.z, hn::Mul(q.t, rho)), y.z)};
            const F distance_sq = dot(d, d);
            const M nearer = hn::And(active, hn::Lt(distance_sq, found_sq));
            const V3 n{hn::Mul(over.x, hn::Mul(sign, hn::Sub(hn::Sub(sheet.w, hn::Mul(sheet.ws, q.s)), hn::Mul(sheet.wt, q.t)))),
                       hn::Mul(over.y, sheet.ws), hn::Mul(over.z, sheet.wt)};
            const F length_sq = hn::Max(dot(n, n), set(1e-30f)), gap = hn::Sub(one, dot(n, y));
            const F along = hn::Div(gap, length_sq), plane_sq = hn::Mul(gap, along);
            // So near above the surface point that the tangent plane's foot is as good.
            const M above = hn::And(nearer, hn::Le(distance_sq, mul_add(set(k_approach_near), plane_sq, touching_sq)));
            all_near = hn::Or(all_near, above);
            found_sq = blend(above, plane_sq, blend(nearer, distance_sq, found_sq));
            kept_n = blend(nearer, n, kept_n);
            kept_d = blend(nearer, d, kept_d);
            kept_along = blend(nearer, along, kept_along);
            kept_face = blend(nearer, q.face, kept_face);
            kept_exits = hn::Or(hn::AndNot(nearer, kept_exits), hn::And(nearer, exits));
            active = hn::AndNot(above, nearer);
            if (step + 1 >= steps || !any(active)) break;
            const V3 next{mul_add(along, n.x, y.x), mul_add(along, n.y, y.y), mul_add(along, n.z, y.z)};
            f = face_point(f.unpermute({hn::Mul(over.x, next.x), hn::Mul(over.y, next.y), hn::Mul(over.z, next.z)}));
            q = to_chart(f);
            reach = hn::Abs(f.major);
        }
        const M below = hn::Gt(kept_along, hn::Zero(df));
        all_inside = hn::And(all_near, hn::Or(hn::And(kept_exits, below), hn::Not(hn::Or(kept_exits, below))));
        f.x_major = equal(hn::ShiftRight<1>(kept_face), hn::Zero(di));
        f.y_major = equal(hn::ShiftRight<1>(kept_face), set_int(1));
        const V3 in_plane{hn::Mul(kept_along, kept_n.x), hn::Mul(kept_along, kept_n.y), hn::Mul(kept_along, kept_n.z)};
        const V3 minus{hn::Neg(kept_n.x), hn::Neg(kept_n.y), hn::Neg(kept_n.z)};
        return {found_sq, part.from_frame(f.unpermute(blend(all_near, in_plane, kept_d))),
                part.from_frame(f.unpermute(blend(kept_exits, kept_n, minus))), all_near, all_inside};
    }

    /// Base cells with a surface at every corner: what Layer 2 reads.
    HWY_INLINE static M with_corners(const Leaves& base, M active)
    {
        const I missing = set_int(model::k_no_surface);
        M all = hn::AndNot(equal(kind_of(base.cell), hn::Zero(di)), active);
        for (const I c : {base.c00, base.c10, base.c01, base.c11}) all = hn::AndNot(equal(c, missing), all);
        return all;
    }

    /// A round's seeds of one part: the nearest surfaces of sorted_[first, first + count). Lanes that are not settled go to
    /// todo_.
    void approach_queued(std::uint32_t index, std::size_t first, std::size_t count, bool first_round, std::size_t& next_open)
    {
        HWY_ALIGN std::int32_t order[k_lanes];
        for (std::size_t i = 0; i < hn::Lanes(df); ++i) order[i] = sorted_[first + std::min(i, count - 1)];
        const I at = hn::Load(di, order);
        const auto column = [&](int k) { return hn::GatherIndex(df, queue_[k], at); };
        const V3 p{column(0), column(1), column(2)};
        const M active = hn::FirstN(df, count);
        V3 start{column(6), column(7), column(8)}, origin = start, plane_normal = start;
        F plane_gap = hn::Zero(df);
        if (!first_round) {
            const auto* words = reinterpret_cast<const std::uint32_t*>(model_.seeds.data());
            const I seed = hn::GatherIndex(di, queue_seed_, at), word = hn::Add(seed, seed);
            const V3 offset{column(3), column(4), column(5)};
            const SeedPlanes planes = planes_of(gather_word(words, word), gather_word(words + 1, word), offset);
            plane_normal = planes.normal;
            plane_gap = hn::Max(planes.gap, hn::Zero(df));
            start = {mul_add(planes.gap, planes.normal.x, p.x), mul_add(planes.gap, planes.normal.y, p.y),
                     mul_add(planes.gap, planes.normal.z, p.z)};
            const auto foot_of_centre = [&](F v, F off, F n) {
                return mul_add(planes.length, n, hn::Sub(v, hn::Mul(off, set(locator_.cell))));
            };
            origin = {foot_of_centre(p.x, offset.x, planes.normal.x), foot_of_centre(p.y, offset.y, planes.normal.y),
                      foot_of_centre(p.z, offset.z, planes.normal.z)};
        }
        Found found = approach(index, p, start, origin, active, first_round ? k_first_steps : k_approach_steps);
        // Where the chart shows no surface about the seed, its plane answers, behind whatever else is found.
        const M lost = hn::Eq(found.distance_sq, set(INFINITY));
        found.offset = blend(lost, times(plane_normal, {plane_gap, plane_gap, plane_gap}), found.offset);
        found.normal = blend(lost, plane_normal, found.normal);
        found.distance_sq = blend(lost, hn::Mul(plane_gap, plane_gap), found.distance_sq);
        const F depth = hn::Sqrt(found.distance_sq);
        const M away = hn::AndNot(found.near, hn::Gt(depth, set(1e-4f * model_.header.sphere[3])));
        const F inverse = hn::Div(set(1.f), hn::Max(blend(away, depth, hn::Sqrt(dot(found.normal, found.normal))), set(1e-30f)));
        const V3 along = blend(away, found.offset, found.normal);
        HWY_ALIGN float v[7][k_lanes];
        hn::Store(hn::Add(p.x, found.offset.x), df, v[0]);
        hn::Store(hn::Add(p.y, found.offset.y), df, v[1]);
        hn::Store(hn::Add(p.z, found.offset.z), df, v[2]);
        hn::Store(hn::Mul(along.x, inverse), df, v[3]);
        hn::Store(hn::Mul(along.y, inverse), df, v[4]);
        hn::Store(hn::Mul(along.z, inverse), df, v[5]);
        hn::Store(depth, df, v[6]);
        if (first_round) {
            const M single =
                hn::RebindMask(df, hn::Ne(hn::And(hn::GatherIndex(di, queue_flags_, at), set_int(k_single)), hn::Zero(di)));
            const F enough = column(9);
            const M settled = hn::And(hn::And(active, found.near), hn::Or(single, hn::Le(depth, enough)));
            HWY_ALIGN std::int32_t in[k_lanes], done[k_lanes];
            hn::Store(hn::VecFromMask(di, hn::RebindMask(di, found.inside)), di, in);
            hn::Store(hn::VecFromMask(di, hn::RebindMask(di, settled)), di, done);
            for (std::size_t i = 0; i < count; ++i) {
                const std::size_t k = static_cast<std::size_t>(order[i]);
                if (done[i] == 0)
                    todo_[next_open++] = static_cast<std::uint16_t>(k);
                else if (in[i] != 0 || (queue_flags_[k] & k_inside) != 0)
                    write(static_cast<std::uint32_t>(queue_point_[k]), static_cast<std::int32_t>(index),
                          {v[0][i], v[1][i], v[2][i]}, {v[3][i], v[4][i], v[5][i]}, v[6][i], (queue_flags_[k] & k_certain) != 0);
            }
            return;
        }
        HWY_ALIGN std::int32_t by_planes[k_lanes];
        hn::Store(hn::VecFromMask(di, hn::RebindMask(di, lost)), di, by_planes);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t k = static_cast<std::size_t>(order[i]);
            const bool by_plane = by_planes[i] != 0;
            if (best_part_[k] < 0 || (best_by_plane_[k] && !by_plane) ||
                (best_by_plane_[k] == by_plane && v[6][i] < best_[6][k])) {
                best_by_plane_[k] = by_plane;
                best_part_[k] = static_cast<std::int16_t>(index);
                for (int j = 0; j < 7; ++j) best_[j][k] = v[j][i];
            }
            const model::Seed seed = model_.seeds[static_cast<std::size_t>(queue_seed_[k])];
            const float enough = locator_.cell * (model::k_seed_reach_step * static_cast<float>(model::seed_reach(seed)));
            if ((seed.extent & model::k_last_seed) != 0 || (!by_plane && v[6][i] <= enough)) continue;
            ++queue_seed_[k];
            queue_part_[k] = static_cast<std::int32_t>(model::seed_part(model_.seeds[static_cast<std::size_t>(queue_seed_[k])]));
            todo_[next_open++] = static_cast<std::uint16_t>(k);
        }
    }

    void write(std::uint32_t index, std::int32_t part, Vec3f point, Vec3f normal, float depth, bool certain)
    {
        const std::size_t at = result_.contacts++;
        if (at >= job_.out.size()) {
            result_.status |= k_probe_full;
            return;
        }
        job_.out[at] = {point, normal, depth, index, static_cast<std::int16_t>(part), certain, k_ok};
    }

    /// Of the surfaces over a layered leaf that one which is nearest to where the surface is expected.
    HWY_NOINLINE void pick_layer(const Part& data, const Chart& q, const Leaves& leaves, F reach, M layered, Sheet& sheet,
                                 M& valid, M& exits) const
    {
        const CentralMap map(model_, data);
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
        sheet = {blend(layered, hn::Load(df, w), sheet.w), blend(layered, hn::Load(df, ws), sheet.ws),
                 blend(layered, hn::Load(df, wt), sheet.wt)};
        valid = hn::Or(valid, hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, is_valid))));
        exits = hn::Or(hn::AndNot(layered, exits), hn::RebindMask(df, hn::MaskFromVec(hn::Load(di, is_exit))));
    }

    /// Decides todo_[0, open) and drops what is free; returns how many are left.
    HWY_NOINLINE std::size_t settle(std::size_t open)
    {
        if (job_.layer == Layer::Three)
            for (std::size_t first = 0; first < open; first += hn::Lanes(df)) {
                const std::size_t count = std::min(open - first, hn::Lanes(df));
                HWY_ALIGN std::int32_t order[k_lanes];
                for (std::size_t i = 0; i < hn::Lanes(df); ++i) order[i] = todo_[first + std::min(i, count - 1)];
                const I at = hn::Load(di, order);
                const V3 p{hn::GatherIndex(df, queue_[0], at), hn::GatherIndex(df, queue_[1], at),
                           hn::GatherIndex(df, queue_[2], at)};
                const I place = hn::GatherIndex(di, queue_place_, at);
                const M mixed = hn::And(hn::FirstN(df, count), equal(hn::And(place, set_int(3)),
                                                                     set_int(static_cast<std::int32_t>(LocatorCellKind::Mixed))));
                if (!any(mixed)) continue;
                M inside = none(), certain = none();
                verdicts(p, place, mixed, inside, certain);
                HWY_ALIGN std::int32_t in[k_lanes], sure[k_lanes];
                hn::Store(hn::VecFromMask(di, hn::RebindMask(di, inside)), di, in);
                hn::Store(hn::VecFromMask(di, hn::RebindMask(di, certain)), di, sure);
                each_lane(mixed, [&](std::size_t i) {
                    queue_flags_[order[i]] = (in[i] != 0 ? k_inside : k_free) | (sure[i] != 0 ? k_certain : 0);
                });
            }
        std::size_t kept = 0;
        for (std::size_t k = 0; k < open; ++k) {
            const std::uint16_t i = todo_[k];
            std::int32_t& flags = queue_flags_[i];
            if ((flags & k_free) != 0) continue;
            if ((flags & k_inside) == 0) {
                const PointVerdict v = verdict_central(model_, queued_point(i), job_.layer);
                if (!v.inside) continue;
                flags = v.certain ? k_certain : 0;
            }
            todo_[kept++] = i;
        }
        return kept;
    }

    ProbeResult result_;
    LocatedPoints addressed_;  // whose places have to be read: their indices
    LocatedPoints located_;    // in places that are not free
    LowestPlanes lowest_planes_;
    std::size_t queued_ = 0;
    // What is queued: the point, its offset from its place's centre in cells, its foot on the first seed's plane, that seed's
    // reach.
    static constexpr std::size_t k_capacity = k_queue + 2 * Probe::k_cluster;
    float queue_[10][k_capacity];
    std::int32_t queue_point_[k_capacity], queue_place_[k_capacity], queue_flags_[k_capacity];
    std::int32_t queue_seed_[k_capacity];  // to be tried next
    std::int32_t queue_part_[k_capacity];  // whose chart that asks
    // What its chain has found so far: point, normal, depth.
    float best_[7][k_capacity];
    std::int16_t best_part_[k_capacity];
    bool best_by_plane_[k_capacity];
    std::uint16_t todo_[k_capacity], sorted_[k_capacity], kept_[k_capacity];
};

}  // namespace

ProbeResult run(const ProbeJob& job) { return ProbeKernel(job).run(); }

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(run);

ProbeResult run_probe(const ProbeJob& job) noexcept { return HWY_DYNAMIC_DISPATCH(run)(job); }

}  // namespace sqmap::query
#endif
