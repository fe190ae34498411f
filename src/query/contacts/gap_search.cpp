// Branch and bound over two trees of boxes (E. Larsen, S. Gottschalk, M. C. Lin, D. Manocha, "Fast proximity queries with swept
// sphere volumes", UNC TR99-018, 1999), sixteen boxes or triangles at a time in float. Besides the distance of their boxes, two
// things are as far apart as their gap along any direction: along that of the nearest pair so far, neighbours of this pair are
// seldom nearer.
#include "gap_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/contacts/gap_search.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/contacts/box_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Pairs by their gaps, in buckets of equal width up to a limit. Pairs of one bucket come out in no order, which costs a few more
/// visits; keeping a heap in order costs more, since the search never takes most pairs out.
class GapBuckets {
public:
    GapBuckets() { std::fill(std::begin(head_), std::end(head_), k_none); }
    /// @pre empty; limit > 0
    void set_limit(float limit) { per_gap_ = static_cast<float>(k_buckets) / limit; }
    [[nodiscard]] std::size_t space() const { return space_; }
    /// @pre there is space; a gap below the limit
    void push(const GapEntry& e)
    {
        const std::size_t bucket = std::min(k_buckets - 1, static_cast<std::size_t>(std::max(e.gap, 0.f) * per_gap_));
        std::uint16_t at = free_;
        if (at == k_none)
            at = used_++;
        else
            free_ = next_[at];
        --space_;
        entries_[at] = e;
        next_[at] = head_[bucket];
        head_[bucket] = at;
        filled_ |= std::uint64_t{1} << bucket;
    }
    /// Visits those that are nearer than a limit, from bucket to bucket; the limit may shrink and others be pushed meanwhile.
    /// Empty then.
    template <class Limit, class Visit>
    void drain(Limit&& limit, Visit&& visit)
    {
        while (filled_ != 0) {
            const auto bucket = static_cast<std::size_t>(std::countr_zero(filled_));
            const std::uint16_t at = head_[bucket];
            const GapEntry e = entries_[at];
            head_[bucket] = next_[at];
            if (head_[bucket] == k_none) filled_ &= ~(std::uint64_t{1} << bucket);
            next_[at] = free_;
            free_ = at;
            ++space_;
            if (e.gap < limit()) visit(e);
        }
    }

private:
    static constexpr std::size_t k_size = 4096, k_buckets = 64;
    static constexpr std::uint16_t k_none = 0xffff;
    GapEntry entries_[k_size];
    std::uint16_t next_[k_size];  ///< in the same bucket, or of those that were given back
    std::uint16_t head_[k_buckets];
    std::uint64_t filled_ = 0;  ///< buckets
    std::size_t space_ = k_size;
    std::uint16_t free_ = k_none, used_ = 0;
    float per_gap_ = 0;
};

template <std::size_t k_size>
class GapHeap {
public:
    /// Pushes in any order, then heap(). @pre there is space
    void add(const GapEntry& e) { entries_[count_++] = e; }
    void heap() { heap_gaps({entries_, count_}); }
    /// Visits those that are nearer than a limit, the nearest first; the limit may shrink meanwhile. Empty then.
    template <class Limit, class Visit>
    void drain(Limit&& limit, Visit&& visit)
    {
        while (count_ > 0 && entries_[0].gap < limit()) {
            pop_gap({entries_, count_});
            const GapEntry e = entries_[--count_];
            visit(e);
        }
        count_ = 0;
    }

private:
    GapEntry entries_[k_size];
    std::size_t count_ = 0;
};

/// Lower bound of the distance of boxes, at most 1e18, whose square a float can still hold.
HWY_INLINE F distance_of(const V3& lo, const V3& hi, const OneBox& box)
{
    const F zero = hn::Zero(df);
    const F x = hn::Max(zero, hn::Max(hn::Sub(lo.x, box.hi.x), hn::Sub(box.lo.x, hi.x))),
            y = hn::Max(zero, hn::Max(hn::Sub(lo.y, box.hi.y), hn::Sub(box.lo.y, hi.y))),
            z = hn::Max(zero, hn::Max(hn::Sub(lo.z, box.hi.z), hn::Sub(box.lo.z, hi.z)));
    return hn::Min(set(1e18f), hn::Mul(set(1 - 1e-6f), hn::Sqrt(mul_add(x, x, mul_add(y, y, hn::Mul(z, z))))));
}
/// Distance of the farthest positions of two boxes, rounded up.
HWY_INLINE F farthest_of(const V3& lo, const V3& hi, const OneBox& box)
{
    const F x = hn::Max(hn::Sub(hi.x, box.lo.x), hn::Sub(box.hi.x, lo.x)),
            y = hn::Max(hn::Sub(hi.y, box.lo.y), hn::Sub(box.hi.y, lo.y)),
            z = hn::Max(hn::Sub(hi.z, box.lo.z), hn::Sub(box.hi.z, lo.z));
    return hn::Mul(set(1 + 1e-5f), hn::Sqrt(mul_add(x, x, mul_add(y, y, hn::Mul(z, z)))));
}

class GapSearch {
public:
    GapSearch(const PosedTrees& trees, const GapBound& bound, TakeNearest take, void* context)
        : trees_(trees),
          centres_error_(2 * trees.margin + 2e-6f * static_cast<float>(norm(trees.between) + trees.radius_a + trees.radius_b)),
          bound_(bound),
          take_(take),
          context_(context)
    {
    }

    void run()
    {
        descend();
        if (!(limit() > 0)) return;
        nodes_.set_limit(limit());
        for (std::size_t row = 0; row < trees_.b.groups.size(); ++row) {
            BoxRow boxes;
            move_boxes(trees_, trees_.b.groups[row], boxes);
            each_bit(first_bits(trees_.groups_b - row * k_row), [&](std::size_t i) HWY_ATTR {
                const OneBox box(boxes, i);
                const float low = low_of(trees_.b.groups[row], i);
                for (std::size_t other = 0; other < trees_.a.groups.size(); ++other) add_groups(other, box, low, row * k_row + i);
            });
        }
        drain();
    }

private:
    [[nodiscard]] float limit() const { return std::min(bound_.limit, farthest_); }

    /// The box of a row that is nearest to a position, of the first `count`.
    static HWY_NOINLINE void offer_nearest(const BoxRow& row, std::size_t count, const float* from, std::size_t first,
                                           std::pair<float, std::size_t>& nearest)
    {
        OneBox box(row, 0);
        box.lo = box.hi = set3(from);
        float distance[k_row];
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df))
            hn::StoreU(distance_of(at(row.lo, i), at(row.hi, i), box), df, distance + i);
        for (std::size_t i = 0; i < std::min(count, k_row); ++i)
            if (distance[i] < nearest.first) nearest = {distance[i], first + i};
    }
    /// The leaf that a position is likely to be nearest to.
    static std::size_t likely_leaf(const TriangleTree::Columns& tree, std::size_t groups, std::size_t leaves, const float* from)
    {
        constexpr std::pair<float, std::size_t> k_none{std::numeric_limits<float>::infinity(), 0};
        std::pair<float, std::size_t> group = k_none, leaf = k_none;
        for (std::size_t row = 0; row < tree.groups.size(); ++row)
            offer_nearest(tree.groups[row], groups - row * k_row, from, row * k_row, group);
        const std::size_t first = group.second * k_row;
        leaf.second = first;
        offer_nearest(tree.leaves[group.second], leaves - first, from, first, leaf);
        return leaf.second;
    }
    /// From one nearest position to the other body's to a pair that is nearest about there: a bound that is seldom far off.
    void descend()
    {
        constexpr int k_steps = 12;
        std::size_t a = 0, b = likely_leaf(trees_.b, trees_.groups_b, trees_.leaves_b, bound_.nearest_b);
        for (int step = 0; step < k_steps && limit() >= 0; ++step) {
            const std::size_t next_a = likely_leaf(trees_.a, trees_.groups_a, trees_.leaves_a, bound_.nearest_a);
            const std::size_t next_b = step == 0 ? b : likely_leaf(trees_.b, trees_.groups_b, trees_.leaves_b, bound_.nearest_b);
            if (step > 0 && next_a == a && next_b == b) return;
            a = next_a;
            b = next_b;
            visit_leaves(a, b);
        }
    }

    /// The greatest of a's box i, and the least of b's, along the direction.
    HWY_INLINE F high_of(const BoxRow& row, std::size_t i) const
    {
        const float* d = bound_.direction_a;
        const auto side = [&](int k) HWY_ATTR { return hn::LoadU(df, (d[k] > 0 ? row.hi : row.lo)[k] + i); };
        return mul_add(set(d[0]), side(0), mul_add(set(d[1]), side(1), hn::Mul(set(d[2]), side(2))));
    }
    float low_of(const BoxRow& row, std::size_t i) const
    {
        float sum = 0;
        for (int k = 0; k < 3; ++k) sum += bound_.direction_b[k] * (bound_.direction_b[k] > 0 ? row.lo : row.hi)[k][i];
        return sum;
    }

    /// Gaps of 16 things of a from one of b, and bit i where the i-th may hold something nearer. Low: of b along the direction.
    struct RowGaps {
        float gap[k_row];
        std::uint32_t near = 0;
    };
    HWY_INLINE void set_gaps(RowGaps& out, std::size_t i, F distance, F high, F low) const
    {
        const F along = hn::Sub(low, high);
        const F gap = hn::Max(distance, hn::Add(set(bound_.along_between), along));
        hn::StoreU(gap, df, out.gap + i);
        const M near = hn::And(hn::Lt(gap, set(limit())), hn::Lt(along, set(bound_.along_limit)));
        out.near |= static_cast<std::uint32_t>(bits_of(near)) << i;
    }

    HWY_NOINLINE void add_groups(std::size_t row_a, const OneBox& box, float low, std::size_t group_b)
    {
        const BoxRow& row = trees_.a.groups[row_a];
        RowGaps gaps;
        F farthest = set(std::numeric_limits<float>::infinity());
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const V3 lo = at(row.lo, i), hi = at(row.hi, i);
            set_gaps(gaps, i, distance_of(lo, hi, box), high_of(row, i), set(low));
            farthest = hn::Min(farthest, farthest_of(lo, hi, box));
        }
        // Each box holds a triangle, so the nearest two are no farther apart than the farthest corners of two boxes, rounded up.
        farthest_ = std::min(farthest_, hn::GetLane(hn::MinOfLanes(df, farthest)) + trees_.margin);
        each_bit(gaps.near & first_bits(trees_.groups_a - row_a * k_row), [&](std::size_t i) {
            nodes_.push({gaps.gap[i], static_cast<std::uint32_t>(row_a * k_row + i), static_cast<std::uint32_t>(group_b)});
            if (nodes_.space() == 0) drain();
        });
    }
    void drain()
    {
        nodes_.drain([this] { return limit(); },
                     [this](const GapEntry& e) {
                         if ((e.a & GapEntry::k_leaves) != 0)
                             visit_leaves(e.a & ~GapEntry::k_leaves, e.b);
                         else
                             visit_groups(e.a, e.b);
                     });
    }

    HWY_NOINLINE void visit_groups(std::size_t group_a, std::size_t group_b)
    {
        const BoxRow &leaves_a = trees_.a.leaves[group_a], &leaves_b = trees_.b.leaves[group_b];
        BoxRow boxes_b;
        move_boxes(trees_, leaves_b, boxes_b);
        const bool is_crowded = nodes_.space() < k_row * k_row;  // then depth first
        const OneBox box_a(trees_.a.groups[group_a / k_row], group_a % k_row);
        std::uint32_t near_b = 0;
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const F distance = distance_of(at(boxes_b.lo, i), at(boxes_b.hi, i), box_a);
            near_b |= static_cast<std::uint32_t>(bits_of(hn::Lt(distance, set(limit())))) << i;
        }
        each_bit(near_b & first_bits(trees_.leaves_b - group_b * k_row), [&](std::size_t b) HWY_ATTR {
            const OneBox box(boxes_b, b);
            const F low = set(low_of(leaves_b, b));
            RowGaps gaps;
            for (std::size_t i = 0; i < k_row; i += hn::Lanes(df))
                set_gaps(gaps, i, distance_of(at(leaves_a.lo, i), at(leaves_a.hi, i), box), high_of(leaves_a, i), low);
            each_bit(gaps.near & first_bits(trees_.leaves_a - group_a * k_row), [&](std::size_t a) {
                const GapEntry e{gaps.gap[a], static_cast<std::uint32_t>(group_a * k_row + a),
                                 static_cast<std::uint32_t>(group_b * k_row + b)};
                if (is_crowded)
                    leaves_.add(e);
                else
                    nodes_.push({e.gap, e.a | GapEntry::k_leaves, e.b});
            });
        });
        if (!is_crowded) return;
        leaves_.heap();
        leaves_.drain([this] { return limit(); }, [this](const GapEntry& e) { visit_leaves(e.a, e.b); });
    }

    /// Triangles of a leaf of b: boxes in a's frame, and the least along the direction.
    struct NearLeaf {
        CornerRow corners;
        BoxRow boxes;
        float low[k_row];
    };
    HWY_NOINLINE void move_leaf(const CornerRow& from, NearLeaf& to) const
    {
        const F error = set(trees_.margin);
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            V3 p[3];
            F low[3];
            for (std::size_t k = 0; k < 3; ++k) {
                const V3 corner = at(from.at[k], i);
                p[k] = moved(trees_, corner);
                store(p[k], to.corners.at[k], i);
                low[k] = row_dot(bound_.direction_b, corner);
            }
            store({hn::Sub(least(p[0].x, p[1].x, p[2].x), error), hn::Sub(least(p[0].y, p[1].y, p[2].y), error),
                   hn::Sub(least(p[0].z, p[1].z, p[2].z), error)},
                  to.boxes.lo, i);
            store({hn::Add(greatest(p[0].x, p[1].x, p[2].x), error), hn::Add(greatest(p[0].y, p[1].y, p[2].y), error),
                   hn::Add(greatest(p[0].z, p[1].z, p[2].z), error)},
                  to.boxes.hi, i);
            hn::StoreU(least(low[0], low[1], low[2]), df, to.low + i);
        }
    }
    /// Bit i: triangle i is as near to the box of a's leaf as a triangle in there has to be. Rounding keeps the order, so none is
    /// left out that is near to one of them.
    std::uint32_t near_leaf(std::size_t leaf_a, const NearLeaf& leaf) const
    {
        const BoxRow& row = trees_.a.leaves[leaf_a / k_row];
        const OneBox box(row, leaf_a % k_row);
        std::uint32_t near = 0;
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const F distance = distance_of(at(leaf.boxes.lo, i), at(leaf.boxes.hi, i), box);
            near |= static_cast<std::uint32_t>(bits_of(hn::Lt(distance, set(limit())))) << i;
        }
        return near;
    }
    /// Raises gaps of triangles from i on to those along the lines of their centres, which of small triangles far apart are
    /// hardly less than their distances: boxes gain as much as triangles are large.
    HWY_NOINLINE void look_along_centres(RowGaps& gaps, std::size_t i, const CornerRow& a, const CornerRow& b,
                                         std::size_t of_b) const
    {
        const V3 p[3] = {at(a.at[0], i), at(a.at[1], i), at(a.at[2], i)};
        const auto corner = [&](std::size_t k) HWY_ATTR {
            return V3{set(b.at[k][0][of_b]), set(b.at[k][1][of_b]), set(b.at[k][2][of_b])};
        };
        const V3 q[3] = {corner(0), corner(1), corner(2)};
        const auto sum = [](const V3(&of)[3]) HWY_ATTR {
            return V3{hn::Add(of[0].x, hn::Add(of[1].x, of[2].x)), hn::Add(of[0].y, hn::Add(of[1].y, of[2].y)),
                      hn::Add(of[0].z, hn::Add(of[1].z, of[2].z))};
        };
        const V3 v = minus(sum(q), sum(p));
        const F inverse = hn::Div(set(1.f), hn::Sqrt(hn::Max(dot(v, v), set(1e-30f))));
        const F low = least(dot(v, q[0]), dot(v, q[1]), dot(v, q[2])), high = greatest(dot(v, p[0]), dot(v, p[1]), dot(v, p[2]));
        const F box_gap = hn::LoadU(df, gaps.gap + i), along = hn::Sub(hn::Mul(hn::Sub(low, high), inverse), set(centres_error_));
        // Products overflow where triangles lie very far apart; then only the distance of their boxes is known.
        const F gap = blend(hn::And(hn::Gt(along, box_gap), hn::Lt(along, set(1e18f))), along, box_gap);
        hn::StoreU(gap, df, gaps.gap + i);
        const std::uint32_t far = static_cast<std::uint32_t>(bits_of(hn::Ge(gap, set(limit())))) << i;
        gaps.near &= ~far;
    }
    static HWY_INLINE F least(F a, F b, F c) { return hn::Min(a, hn::Min(b, c)); }
    static HWY_INLINE F greatest(F a, F b, F c) { return hn::Max(a, hn::Max(b, c)); }

    HWY_NOINLINE void visit_leaves(std::size_t leaf_a, std::size_t leaf_b)
    {
        NearLeaf other;
        move_leaf(trees_.b.corners[leaf_b], other);
        const std::uint32_t near_b = near_leaf(leaf_a, other) & first_bits(trees_.triangles_b - leaf_b * k_row);
        if (near_b == 0) return;
        const CornerRow& corners = trees_.a.corners[leaf_a];
        BoxRow boxes;
        float high[k_row];
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const V3 p = at(corners.at[0], i), q = at(corners.at[1], i), r = at(corners.at[2], i);
            store({least(p.x, q.x, r.x), least(p.y, q.y, r.y), least(p.z, q.z, r.z)}, boxes.lo, i);
            store({greatest(p.x, q.x, r.x), greatest(p.y, q.y, r.y), greatest(p.z, q.z, r.z)}, boxes.hi, i);
            const float* d = bound_.direction_a;
            hn::StoreU(greatest(row_dot(d, p), row_dot(d, q), row_dot(d, r)), df, high + i);
        }
        each_bit(near_b, [&](std::size_t b) HWY_ATTR {
            const OneBox box(other.boxes, b);
            RowGaps gaps;
            for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
                set_gaps(gaps, i, distance_of(at(boxes.lo, i), at(boxes.hi, i), box), hn::LoadU(df, high + i), set(other.low[b]));
                if ((gaps.near >> i) != 0) look_along_centres(gaps, i, corners, other.corners, b);
            }
            each_bit(gaps.near & first_bits(trees_.triangles_a - leaf_a * k_row), [&](std::size_t a) {
                triangles_.add({gaps.gap[a], static_cast<std::uint32_t>(leaf_a * k_row + a),
                                static_cast<std::uint32_t>(leaf_b * k_row + b)});
            });
        });
        triangles_.heap();
        triangles_.drain([this] { return limit(); },
                         [this](const GapEntry& e) {
                             bound_ = take_(context_, {trees_.a.numbers[e.a], trees_.b.numbers[e.b]});
                         });
    }

    const PosedTrees& trees_;
    const float centres_error_;  ///< by which rounding may raise a gap along the line of two centres
    GapBound bound_;
    TakeNearest take_;
    void* context_;
    float farthest_ = std::numeric_limits<float>::infinity();
    GapBuckets nodes_;  // groups and leaves
    GapHeap<k_row * k_row> leaves_, triangles_;
};

}  // namespace

void run_gap_search(const PosedTrees& trees, const GapBound& bound, TakeNearest take, void* context)
{
    GapSearch(trees, bound, take, context).run();
}

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(run_gap_search);

void search_gap(const PosedTrees& trees, const GapBound& bound, TakeNearest take, void* context) noexcept
{
    HWY_DYNAMIC_DISPATCH(run_gap_search)(trees, bound, take, context);
}

}  // namespace sqmap::query
#endif
