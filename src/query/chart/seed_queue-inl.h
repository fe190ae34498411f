// Points whose nearest surface has to be sought in the charts, from the seeds of their locator cells.
#if defined(SQMAP_QUERY_CHART_SEED_QUEUE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_CHART_SEED_QUEUE_INL_H
#undef SQMAP_QUERY_CHART_SEED_QUEUE_INL_H
#else
#define SQMAP_QUERY_CHART_SEED_QUEUE_INL_H
#endif

#include "chart_search-inl.h"
#include "chart_verdict-inl.h"
#include "query/probe/contacts-inl.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Computes what is queued part after part, so that lanes are full: first each point by its first seed, which settles most, then
/// the rest by its verdict and, round by round, by every seed of its chain.
class SeedQueue {
public:
    static constexpr std::size_t k_size = 1024;

    SeedQueue(const LocatorLanes& locator, const ModelView& model, ContactWriter& contacts)
        : locator_(locator), model_(model), verdicts_(model), contacts_(contacts)
    {
    }

    /// A vector of points in cells that have seeds.
    struct Points {
        V3 p, offset;  // model space; from the cell's centre, in cells
        I cell, index;
        M inside;  // proven
    };

    std::size_t count() const { return count_; }

    HWY_NOINLINE void add(const Points& points, const LocatorLanes::SeedStart& start, M which)
    {
        const I flags = hn::Or(hn::IfThenElseZero(hn::RebindMask(di, points.inside), set_int(k_inside | k_certain)),
                               hn::IfThenElseZero(hn::RebindMask(di, start.single), set_int(k_single)));
        const auto& planes = start.planes;
        const std::size_t n = count_;
        const V3 foot{mul_add(planes.below, planes.normal.x, points.p.x), mul_add(planes.below, planes.normal.y, points.p.y),
                      mul_add(planes.below, planes.normal.z, points.p.z)};
        pack_rows(points.p, which, p_, n);
        pack_rows(points.offset, which, offset_, n);
        pack_rows(foot, which, foot_, n);
        pack(start.reach, which, reach_ + n);
        pack(points.cell, which, cell_ + n);
        pack(points.index, which, point_ + n);
        pack(start.chain, which, seed_ + n);
        pack(planes.part, which, part_ + n);
        pack(flags, which, flags_ + n);
        count_ += count_of(which);
    }

    /// Writes the contacts among what is queued, and empties the queue.
    HWY_NOINLINE void search()
    {
        for (std::size_t i = 0; i < count_; ++i) todo_[i] = static_cast<std::uint16_t>(i);
        std::size_t open = settle(round(count_, true));
        for (std::size_t k = 0; k < open; ++k) {
            const std::size_t i = todo_[k];
            best_depth_[i] = INFINITY;
            best_part_[i] = -1;
            part_[i] = static_cast<std::int32_t>(model::seed_part(seed(i)));
            kept_[k] = todo_[k];
        }
        const std::size_t kept = open;
        while (open > 0) open = round(open, false);
        for (std::size_t k = 0; k < kept; ++k) {
            const std::size_t i = kept_[k];
            if (best_by_plane_[i]) contacts_.count_unseen();
            write(i, best_part_[i], row(best_point_, i), row(best_normal_, i), best_depth_[i]);
        }
        count_ = 0;
    }

private:
    static constexpr std::size_t k_capacity = k_size + 2 * k_max_lanes;
    static constexpr int k_first_steps = 2;
    enum Flag : std::int32_t { k_certain = 1, k_inside = 2, k_free = 4, k_single = 8 };
    using Rows = float[3][k_capacity];

    static HWY_INLINE void pack_rows(const V3& v, M which, Rows& to, std::size_t at)
    {
        pack(v.x, which, to[0] + at);
        pack(v.y, which, to[1] + at);
        pack(v.z, which, to[2] + at);
    }
    static HWY_INLINE V3 gather(const Rows& from, I at)
    {
        return {hn::GatherIndex(df, from[0], at), hn::GatherIndex(df, from[1], at), hn::GatherIndex(df, from[2], at)};
    }
    static Vec3f row(const Rows& from, std::size_t i) { return {from[0][i], from[1][i], from[2][i]}; }

    model::Seed seed(std::size_t i) const { return model_.seeds[static_cast<std::size_t>(seed_[i])]; }

    /// A vector of what is queued: indices, the last of which is repeated.
    struct Batch {
        HWY_ALIGN std::int32_t order[k_lanes];
        std::size_t count;
        Batch(const std::uint16_t* from, std::size_t n) : count(n)
        {
            for (std::size_t i = 0; i < hn::Lanes(df); ++i) order[i] = from[std::min(i, n - 1)];
        }
        HWY_INLINE I at() const { return hn::Load(di, order); }
    };

    /// Surface points out of their lanes.
    struct Surfaces {
        HWY_ALIGN float point[3][k_lanes], normal[3][k_lanes], depth[k_lanes];
        Vec3f point_at(std::size_t i) const { return {point[0][i], point[1][i], point[2][i]}; }
        Vec3f normal_at(std::size_t i) const { return {normal[0][i], normal[1][i], normal[2][i]}; }
    };

    /// One seed for each of todo_[0, open), part after part. Returns how many need another.
    HWY_NOINLINE std::size_t round(std::size_t open, bool first_round)
    {
        std::uint16_t first[257] = {};
        for (std::size_t k = 0; k < open; ++k) ++first[part_[todo_[k]] + 1];
        for (std::size_t part = 0; part < model_.parts.size(); ++part)
            first[part + 1] = static_cast<std::uint16_t>(first[part + 1] + first[part]);
        for (std::size_t k = 0; k < open; ++k) sorted_[first[part_[todo_[k]]]++] = todo_[k];
        open_ = 0;
        for (std::size_t k = 0; k < open;) {
            const auto part = static_cast<std::size_t>(part_[sorted_[k]]);
            const std::size_t end = first[part];
            for (; k < end; k += hn::Lanes(df)) {
                const Batch batch(sorted_ + k, std::min(hn::Lanes(df), end - k));
                if (first_round)
                    try_first_seed(part, batch);
                else
                    try_next_seed(part, batch);
            }
            k = end;
        }
        return open_;
    }

    void keep_open(std::size_t i) { todo_[open_++] = static_cast<std::uint16_t>(i); }

    HWY_INLINE Surfaces surfaces(const V3& p, const Found& found, F depth) const
    {
        const M away = hn::AndNot(found.near, hn::Gt(depth, set(1e-4f * model_.header.sphere[3])));
        const F inverse = hn::Div(set(1.f), hn::Max(blend(away, depth, hn::Sqrt(dot(found.normal, found.normal))), set(1e-30f)));
        const V3 along = blend(away, found.offset, found.normal);
        Surfaces s;
        hn::Store(hn::Add(p.x, found.offset.x), df, s.point[0]);
        hn::Store(hn::Add(p.y, found.offset.y), df, s.point[1]);
        hn::Store(hn::Add(p.z, found.offset.z), df, s.point[2]);
        hn::Store(hn::Mul(along.x, inverse), df, s.normal[0]);
        hn::Store(hn::Mul(along.y, inverse), df, s.normal[1]);
        hn::Store(hn::Mul(along.z, inverse), df, s.normal[2]);
        hn::Store(depth, df, s.depth);
        return s;
    }

    /// The surface by the first seed, where it is sure to be the nearest; that surface tells the side as well.
    HWY_NOINLINE void try_first_seed(std::size_t part, const Batch& batch)
    {
        const I at = batch.at();
        const V3 p = gather(p_, at), foot = gather(foot_, at);
        const M active = hn::FirstN(df, batch.count);
        const Found found = ChartSearch(model_, part).approach({p, foot, foot}, active, k_first_steps);
        const F depth = hn::Sqrt(found.distance_sq);
        const Surfaces s = surfaces(p, found, depth);
        const M single = hn::RebindMask(df, hn::Ne(hn::And(hn::GatherIndex(di, flags_, at), set_int(k_single)), hn::Zero(di)));
        const F enough = hn::GatherIndex(df, reach_, at);
        const M settled = hn::And(hn::And(active, found.near), hn::Or(single, hn::Le(depth, enough)));
        HWY_ALIGN std::int32_t in[k_lanes], done[k_lanes];
        hn::Store(hn::VecFromMask(di, hn::RebindMask(di, found.inside)), di, in);
        hn::Store(hn::VecFromMask(di, hn::RebindMask(di, settled)), di, done);
        for (std::size_t i = 0; i < batch.count; ++i) {
            const auto k = static_cast<std::size_t>(batch.order[i]);
            if (done[i] == 0)
                keep_open(k);
            else if (in[i] != 0 || (flags_[k] & k_inside) != 0)
                write(k, static_cast<std::int32_t>(part), s.point_at(i), s.normal_at(i), s.depth[i]);
        }
    }

    /// The surface by the next seed of a chain; the nearest of all counts.
    HWY_NOINLINE void try_next_seed(std::size_t part, const Batch& batch)
    {
        const I at = batch.at();
        const V3 p = gather(p_, at), offset = gather(offset_, at);
        const auto* words = reinterpret_cast<const std::uint32_t*>(model_.seeds.data());
        const I index = hn::GatherIndex(di, seed_, at), word = hn::Add(index, index);
        const auto planes = locator_.seed_planes(gather_word(words, word), gather_word(words + 1, word), offset);
        const F below_plane = hn::Max(planes.below, hn::Zero(df));
        const V3 start{mul_add(planes.below, planes.normal.x, p.x), mul_add(planes.below, planes.normal.y, p.y),
                       mul_add(planes.below, planes.normal.z, p.z)};
        const auto foot_of_centre = [&](F v, F off, F n) {
            return mul_add(planes.length, n, hn::Sub(v, hn::Mul(off, set(model_.locator.cell))));
        };
        const V3 origin{foot_of_centre(p.x, offset.x, planes.normal.x), foot_of_centre(p.y, offset.y, planes.normal.y),
                        foot_of_centre(p.z, offset.z, planes.normal.z)};
        Found found = ChartSearch(model_, part).approach({p, start, origin}, hn::FirstN(df, batch.count), k_approach_steps);
        // A chart may show no surface about its seed. The seed's plane then answers, unless another seed finds a surface.
        const M lost = hn::Eq(found.distance_sq, set(INFINITY));
        found.offset = blend(lost, times(planes.normal, {below_plane, below_plane, below_plane}), found.offset);
        found.normal = blend(lost, planes.normal, found.normal);
        found.distance_sq = blend(lost, hn::Mul(below_plane, below_plane), found.distance_sq);
        HWY_ALIGN std::int32_t by_planes[k_lanes];
        hn::Store(hn::VecFromMask(di, hn::RebindMask(di, lost)), di, by_planes);
        keep_nearest(part, batch, surfaces(p, found, hn::Sqrt(found.distance_sq)), by_planes);
    }

    void keep_nearest(std::size_t part, const Batch& batch, const Surfaces& s, const std::int32_t* by_planes)
    {
        for (std::size_t i = 0; i < batch.count; ++i) {
            const auto k = static_cast<std::size_t>(batch.order[i]);
            const bool by_plane = by_planes[i] != 0;
            if (best_part_[k] < 0 || (best_by_plane_[k] && !by_plane) ||
                (best_by_plane_[k] == by_plane && s.depth[i] < best_depth_[k])) {
                best_by_plane_[k] = by_plane;
                best_part_[k] = static_cast<std::int16_t>(part);
                for (int j = 0; j < 3; ++j) {
                    best_point_[j][k] = s.point[j][i];
                    best_normal_[j][k] = s.normal[j][i];
                }
                best_depth_[k] = s.depth[i];
            }
            const model::Seed tried = seed(k);
            const float enough = model_.locator.cell * (model::k_seed_reach_step * static_cast<float>(model::seed_reach(tried)));
            if (model::is_last_seed(tried) || (!by_plane && s.depth[i] <= enough)) continue;
            ++seed_[k];
            part_[k] = static_cast<std::int32_t>(model::seed_part(seed(k)));
            keep_open(k);
        }
    }

    /// Finds the side of the points todo_[0, open) and drops those that are free; returns how many are left.
    HWY_NOINLINE std::size_t settle(std::size_t open)
    {
        for (std::size_t first = 0; first < open; first += hn::Lanes(df)) {
            const Batch batch(todo_ + first, std::min(open - first, hn::Lanes(df)));
            const I cell = hn::GatherIndex(di, cell_, batch.at());
            const M lanes = hn::FirstN(df, batch.count), mixed = LocatorLanes::is_kind(cell, LocatorCellKind::Mixed, lanes),
                    ambiguous = LocatorLanes::is_kind(cell, LocatorCellKind::Ambiguous, lanes),
                    decided = hn::Or(mixed, ambiguous);
            if (!any(decided)) continue;
            M inside = none(), certain = none();
            const V3 p = gather(p_, batch.at());
            if (any(mixed)) verdicts_.by_lists(p, cell, mixed, inside, certain);
            if (any(ambiguous)) {
                I answering;
                const VerdictLanes v = verdicts_.by_all(p, ambiguous, answering, [](std::size_t, VerdictLanes&) {});
                inside = hn::Or(inside, v.inside);
                certain = hn::Or(certain, v.certain);
            }
            HWY_ALIGN std::int32_t in[k_lanes], sure[k_lanes];
            hn::Store(hn::VecFromMask(di, hn::RebindMask(di, inside)), di, in);
            hn::Store(hn::VecFromMask(di, hn::RebindMask(di, certain)), di, sure);
            each_lane(decided, [&](std::size_t i) {
                flags_[batch.order[i]] = (in[i] != 0 ? k_inside : k_free) | (sure[i] != 0 ? k_certain : 0);
            });
        }
        std::size_t kept = 0;
        for (std::size_t k = 0; k < open; ++k)
            if ((flags_[todo_[k]] & k_free) == 0) todo_[kept++] = todo_[k];
        return kept;
    }

    void write(std::size_t i, std::int32_t part, Vec3f point, Vec3f normal, float depth)
    {
        contacts_.write({point, normal, depth, static_cast<std::uint32_t>(point_[i]), static_cast<std::int16_t>(part),
                         (flags_[i] & k_certain) != 0, k_ok});
    }

    const LocatorLanes& locator_;
    const ModelView& model_;
    const ChartVerdicts verdicts_;
    ContactWriter& contacts_;
    std::size_t count_ = 0, open_ = 0;  // queued; of todo_
    Rows p_, offset_;                   // model space; from the cell's centre, in cells
    Rows foot_;                         // on the first seed's plane
    float reach_[k_capacity];           // of the first seed
    std::int32_t point_[k_capacity], cell_[k_capacity], flags_[k_capacity];
    std::int32_t seed_[k_capacity];  // to be tried next
    std::int32_t part_[k_capacity];  // whose chart is searched
    // The nearest surface that the seeds of each point's chain have found so far.
    Rows best_point_, best_normal_;
    float best_depth_[k_capacity];
    std::int16_t best_part_[k_capacity];
    bool best_by_plane_[k_capacity];
    std::uint16_t todo_[k_capacity], sorted_[k_capacity], kept_[k_capacity];
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
