// Many points against the hierarchy at once: a node is visited with all points that may be near to it, a vector of them at a
// time.
#if defined(SQMAP_QUERY_PACKET_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_PACKET_INL_H
#undef SQMAP_QUERY_PACKET_INL_H
#else
#define SQMAP_QUERY_PACKET_INL_H
#endif

#include "query/distance/child_order.h"
#include "query/distance/hierarchy-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

class PacketSearch : Hierarchy {
public:
    /// near, slack: as a Hierarchy takes them.
    PacketSearch(const ModelView& model, PointPacket& points, NearTriangles* near, float slack)
        : Hierarchy(model, near, slack), points_(points)
    {
    }

    void run()
    {
        List& all = lists_[0];
        for (std::size_t i = 0; i < points_.count; ++i) all.index[i] = static_cast<std::int32_t>(i);
        all.count = points_.count;
        seed(0, 0);
        visit(0, 0);
    }

private:
    struct List {
        std::size_t count = 0;
        std::int32_t index[PointPacket::k_capacity];
    };

    /// Points that go to a leaf.
    struct LeafList : List {
        float p[3][PointPacket::k_capacity];
    };

    HWY_INLINE V3 load(const List& list, std::size_t i, I& index) const
    {
        index = hn::LoadU(di, list.index + i);
        // Lanes beyond the end of a list repeat its last point.
        if (i + hn::Lanes(df) > list.count) index = blend(hn::FirstN(df, list.count - i), index, set_int(list.index[i]));
        return {hn::GatherIndex(df, points_.x, index), hn::GatherIndex(df, points_.y, index),
                hn::GatherIndex(df, points_.z, index)};
    }
    /// As load, from the list's copies of its points.
    static HWY_INLINE V3 load_copies(const LeafList& list, std::size_t i, I& index)
    {
        index = hn::LoadU(di, list.index + i);
        const V3 p{hn::LoadU(df, list.p[0] + i), hn::LoadU(df, list.p[1] + i), hn::LoadU(df, list.p[2] + i)};
        if (i + hn::Lanes(df) <= list.count) return p;
        // Memory beyond the end of a list was never written: squares of its numbers would overflow.
        const M there = hn::FirstN(df, list.count - i);
        index = blend(there, index, set_int(list.index[i]));
        return {blend(there, p.x, set(list.p[0][i])), blend(there, p.y, set(list.p[1][i])), blend(there, p.z, set(list.p[2][i]))};
    }
    static HWY_INLINE M within(const List& list, std::size_t i)
    {
        return hn::FirstN(df, std::min(list.count - i, hn::Lanes(df)));
    }

    /// Which of a node's children each point of the level's list goes to.
    static HWY_INLINE I child_bit(std::uint32_t c) { return set_int(static_cast<std::int32_t>(1u << c)); }
    std::uint32_t chosen_by_some(std::uint32_t level) const
    {
        I all = hn::Zero(di);
        const List& list = lists_[level];
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df))
            all = hn::Or(all, hn::IfThenElseZero(hn::RebindMask(di, within(list, i)), hn::LoadU(di, children_[level] + i)));
        HWY_ALIGN std::int32_t bits[k_lanes];
        hn::Store(all, di, bits);
        std::uint32_t children = 0;
        for (std::size_t i = 0; i < hn::Lanes(df); ++i) children |= static_cast<std::uint32_t>(bits[i]);
        return children;
    }
    /// The points of the level's list that descend to a child.
    HWY_INLINE void take(std::uint32_t level, std::uint32_t c, List& to) const
    {
        const List& list = lists_[level];
        const I bit = child_bit(c);
        to.count = 0;
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
            const M taken =
                hn::And(within(list, i), hn::Not(equal(hn::And(hn::LoadU(di, children_[level] + i), bit), hn::Zero(di))));
            if (!any(taken)) continue;
            pack(hn::LoadU(di, list.index + i), taken, to.index + to.count);
            to.count += count_of(taken);
        }
    }

    /// Lets each point's search begin at the nearest corners of a leaf: that whose middle is nearest, level by level.
    HWY_NOINLINE void seed(std::uint32_t level, std::uint32_t node)
    {
        if (level == levels_.count) {
            LeafBoxes boxes;
            decode(arrays_.groups[node], boxes);
            choose_nearest(level, leaves_of(node), [&](std::uint32_t c) HWY_ATTR {
                return V3{set(boxes.centre[0][c]), set(boxes.centre[1][c]), set(boxes.centre[2][c])};
            });
        } else {
            const model::HierarchyNode& n = node_at(level, node);
            choose_nearest(level, children_of(level, node), [&](std::uint32_t c) HWY_ATTR {
                const auto middle = [&](int k) {
                    return set(n.origin[k] + n.step * (0.5f * static_cast<float>(n.lo[k][c] + n.hi[k][c])));
                };
                return V3{middle(0), middle(1), middle(2)};
            });
        }
        for (std::uint32_t left = chosen_by_some(level); left != 0; left &= left - 1) {
            const auto c = static_cast<std::uint32_t>(std::countr_zero(left));
            List& next = level == levels_.count ? leaf_list_[0] : lists_[level + 1];
            take(level, c, next);
            if (level == levels_.count)
                seed_corners(node * k_hierarchy_width + c, next);
            else
                seed(level + 1, node * k_hierarchy_width + c);
        }
    }

    /// middle(c): of a child.
    template <class Middle>
    HWY_INLINE void choose_nearest(std::uint32_t level, std::uint32_t count, Middle&& middle)
    {
        const List& list = lists_[level];
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
            I index;
            const V3 p = load(list, i, index);
            F least = set(INFINITY);
            I best = hn::Zero(di);
            for (std::uint32_t c = 0; c < count; ++c) {
                const V3 d = minus(p, middle(c));
                const F d_sq = dot(d, d);
                const M nearer = hn::Lt(d_sq, least);
                least = blend(nearer, d_sq, least);
                best = blend(nearer, child_bit(c), best);
            }
            hn::StoreU(best, di, children_[level] + i);
        }
    }

    /// No farther than the nearest of some corners of a leaf.
    HWY_NOINLINE void seed_corners(std::uint32_t leaf, const List& list)
    {
        Vec3f corners[k_hierarchy_leaf];
        for (std::size_t k = 0; k < k_hierarchy_leaf; ++k)
            corners[k] = model::vec3(corner(entry_at(leaf * k_hierarchy_leaf + k), 0));
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
            I index;
            const V3 p = load(list, i, index);
            F least = hn::GatherIndex(df, points_.distance_sq, index);
            for (const Vec3f& q : corners) {
                const V3 d = minus(p, {set(q.x), set(q.y), set(q.z)});
                // A little more, so that the triangle there is found as nearer.
                least = hn::Min(least, tie_above_lanes(dot(d, d)));
            }
            HWY_ALIGN std::int32_t at[k_lanes];
            HWY_ALIGN float values[k_lanes];
            hn::Store(index, di, at);
            hn::Store(least, df, values);
            each_lane(within(list, i), [&](std::size_t lane) { points_.distance_sq[at[lane]] = values[lane]; });
        }
    }

    /// The points of a list in scratch, moved and scaled, with what their triangles are within.
    HWY_INLINE void put_points(const List& list, Vec3f origin, float scale)
    {
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
            I index;
            const V3 p = scaled(set(scale), minus(load(list, i, index), {set(origin.x), set(origin.y), set(origin.z)}));
            hn::StoreU(p.x, df, near_points_[0] + i);
            hn::StoreU(p.y, df, near_points_[1] + i);
            hn::StoreU(p.z, df, near_points_[2] + i);
            const F reach = reach_above_lanes(hn::GatherIndex(df, points_.distance_sq, index));
            hn::StoreU(hn::Mul(reach, set(scale * scale)), df, near_points_[3] + i);
        }
    }
    /// Boxes of a node's children, side by side, in the node's steps from its origin.
    struct NodeBoxes {
        HWY_ALIGN float lo[3][k_row];
        HWY_ALIGN float hi[3][k_row];

        HWY_INLINE explicit NodeBoxes(const model::HierarchyNode& n)
        {
            for (int k = 0; k < 3; ++k)
                for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
                    hn::Store(codes(n.lo[k] + i), df, lo[k] + i);
                    hn::Store(codes(n.hi[k] + i), df, hi[k] + i);
                }
        }
    };
    using Hierarchy::to_box;
    template <class Get>
    static HWY_INLINE F to_box(const NodeBoxes& boxes, const V3& p, Get&& get)
    {
        const auto beyond = [&](F v, int k) HWY_ATTR {
            return hn::Max(hn::Max(hn::Sub(get(boxes.lo[k]), v), hn::Sub(v, get(boxes.hi[k]))), hn::Zero(df));
        };
        const V3 d{beyond(p.x, 0), beyond(p.y, 1), beyond(p.z, 2)};
        return dot(d, d);
    }

    /// From a point to the boxes of all children.
    template <class Boxes>
    static HWY_INLINE void put_distances(const Boxes& boxes, const V3& p, float* distance_sq)
    {
        for (std::size_t c = 0; c < k_row; c += hn::Lanes(df))
            hn::Store(to_box(boxes, p, [c](const float* row) HWY_ATTR { return hn::Load(df, row + c); }), df, distance_sq + c);
    }
    /// A point of a list, put there as scratch.
    HWY_INLINE V3 point_at(std::size_t i) const
    {
        return {set(near_points_[0][i]), set(near_points_[1][i]), set(near_points_[2][i])};
    }
    /// Distances of the children from where the list's points are: neighbours follow one another, so that the one in the middle
    /// says it.
    template <class Boxes>
    HWY_INLINE void put_distances(std::uint32_t level, const Boxes& boxes, float* distance_sq) const
    {
        put_distances(boxes, point_at(lists_[level].count / 2), distance_sq);
    }

    /// Which children are within reach of each of these points. Before a vector of points is tested, what is near to none of them
    /// is left out: children are farther from a point than from its neighbour by at most what these are apart. size: of the
    /// boxes' coordinates.
    template <class Boxes>
    HWY_INLINE void choose_near(std::uint32_t level, std::uint32_t count, const Boxes& boxes, float size)
    {
        const List& list = lists_[level];
        HWY_ALIGN float distance_sq[k_row];
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
            const V3 p{hn::LoadU(df, near_points_[0] + i), hn::LoadU(df, near_points_[1] + i),
                       hn::LoadU(df, near_points_[2] + i)};
            const F reach_sq = hn::LoadU(df, near_points_[3] + i);
            const V3 first = point_at(i), apart = minus(p, first);
            const F within_all = hn::MaxOfLanes(df, hn::Add(hn::Sqrt(dot(apart, apart)), hn::Sqrt(reach_sq)));
            const F sum = hn::Add(hn::Add(hn::Abs(first.x), hn::Abs(first.y)), hn::Add(hn::Abs(first.z), set(size)));
            // Rounding takes a little more.
            const F limit = mul_add(within_all, set(1.0001f), hn::Mul(sum, set(4 * k_box_rounding)));
            const F limit_sq = hn::Mul(limit, limit);
            put_distances(boxes, first, distance_sq);
            std::uint32_t left = 0;
            for (std::size_t c = 0; c < k_row; c += hn::Lanes(df))
                left |= bits(hn::Not(hn::Gt(hn::Load(df, distance_sq + c), limit_sq))) << c;
            I children = hn::Zero(di);
            for (left &= (1u << count) - 1; left != 0; left &= left - 1) {
                const auto c = static_cast<std::uint32_t>(std::countr_zero(left));
                const F d_sq = to_box(boxes, p, [c](const float* row) HWY_ATTR { return set(row[c]); });
                children = hn::Or(children, hn::IfThenElseZero(hn::RebindMask(di, hn::Le(d_sq, reach_sq)), child_bit(c)));
            }
            hn::StoreU(children, di, children_[level] + i);
        }
    }

    HWY_NOINLINE void visit(std::uint32_t level, std::uint32_t node)
    {
        if (level == levels_.count) {
            visit_group(level, node);
            return;
        }
        const model::HierarchyNode& n = node_at(level, node);
        put_points(lists_[level], model::vec3(n.origin), 1.f / n.step);
        const NodeBoxes boxes(n);
        choose_near(level, children_of(level, node), boxes, 3 * 255.f);
        HWY_ALIGN float distance_sq[k_row];
        put_distances(level, boxes, distance_sq);
        for (const std::uint32_t c : ChildOrder(distance_sq, chosen_by_some(level))) {
            take(level, c, lists_[level + 1]);
            visit(level + 1, node * k_hierarchy_width + c);
        }
    }

    HWY_NOINLINE void visit_group(std::uint32_t level, std::uint32_t group)
    {
        LeafBoxes boxes;
        decode(arrays_.groups[group], boxes);
        put_points(lists_[level], {0, 0, 0}, 1.f);
        const float* sphere = model_.header.sphere;
        choose_near(level, leaves_of(group), boxes,
                    std::abs(sphere[0]) + std::abs(sphere[1]) + std::abs(sphere[2]) + 3 * sphere[3]);
        HWY_ALIGN float distance_sq[k_row];
        put_distances(level, boxes, distance_sq);
        // Two neighbours share a vector of triangles.
        const std::uint32_t chosen = chosen_by_some(level);
        std::uint32_t pairs = 0;
        for (std::uint32_t c = 0; c < k_row; c += 2) {
            const std::uint32_t pair = chosen >> c & 3u;
            if (pair == 2 || (pair == 3 && distance_sq[c + 1] < distance_sq[c])) distance_sq[c] = distance_sq[c + 1];
            if (pair != 0) pairs |= 1u << c;
        }
        for (const std::uint32_t c : ChildOrder(distance_sq, pairs)) {
            for (std::uint32_t k = 0; k < 2; ++k) {
                leaf_list_[k].count = 0;
                if ((chosen >> (c + k) & 1u) != 0) take_near(level, boxes, c + k, leaf_list_[k]);
            }
            if (leaf_list_[0].count + leaf_list_[1].count > 0) measure_leaves(group * k_hierarchy_width + c);
        }
    }

    /// The points of the level's list that descend to a leaf and are still within reach of it: earlier leaves may have brought
    /// their surfaces nearer.
    HWY_INLINE void take_near(std::uint32_t level, const LeafBoxes& boxes, std::uint32_t c, LeafList& to) const
    {
        const List& list = lists_[level];
        const I bit = child_bit(c);
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
            M taken = hn::And(within(list, i), hn::Not(equal(hn::And(hn::LoadU(di, children_[level] + i), bit), hn::Zero(di))));
            if (!any(taken)) continue;
            const I index = blend(taken, hn::LoadU(di, list.index + i), hn::Zero(di));
            const V3 p{hn::LoadU(df, near_points_[0] + i), hn::LoadU(df, near_points_[1] + i),
                       hn::LoadU(df, near_points_[2] + i)};
            const F d_sq = to_box(boxes, p, [c](const float* row) HWY_ATTR { return set(row[c]); });
            taken = hn::And(taken, hn::Le(d_sq, reach_above_lanes(hn::GatherIndex(df, points_.distance_sq, index))));
            if (!any(taken)) continue;
            pack(index, taken, to.index + to.count);
            pack(p.x, taken, to.p[0] + to.count);
            pack(p.y, taken, to.p[1] + to.count);
            pack(p.z, taken, to.p[2] + to.count);
            to.count += count_of(taken);
        }
    }

    /// The triangles of two neighbouring leaves against the points that may be near to each.
    HWY_NOINLINE void measure_leaves(std::uint32_t leaf)
    {
        const std::size_t first = leaf_list_[0].count > 0 ? 0 : 1, end = leaf_list_[1].count > 0 ? 2 : 1;
        prepare(leaf + static_cast<std::uint32_t>(first), (end - first) * k_hierarchy_leaf);
        for (std::size_t k = first; k < end; ++k) {
            const std::size_t block = (k - first) * k_hierarchy_leaf;
            measure(leaf_list_[k], block, static_cast<std::uint32_t>((leaf + k) * k_hierarchy_leaf));
        }
    }

    HWY_INLINE void prepare(std::uint32_t leaf, std::size_t n)
    {
        Corners corners;
        for (std::size_t i = 0; i < n; ++i) put_corners(entry_at(leaf * k_hierarchy_leaf + i), i, corners);
        for (std::size_t i = 0; i < n; i += hn::Lanes(df))
            frames_.put(i, corner_lanes(corners, 0, i), corner_lanes(corners, 1, i), corner_lanes(corners, 2, i));
    }

    HWY_INLINE F tie_above_lanes(F distance_sq) const { return mul_add(distance_sq, set(k_tie), set(tie_)); }
    HWY_INLINE F reach_above_lanes(F distance_sq) const
    {
        if (near_ == nullptr) return tie_above_lanes(distance_sq);
        const F reach = hn::Add(hn::Sqrt(distance_sq), set(slack_));
        return hn::Mul(reach, reach);
    }

    /// A leaf's triangles, from `first` in the block and from `slot` among the entries.
    HWY_INLINE void measure(const LeafList& list, std::size_t first, std::uint32_t slot)
    {
        if (near_ == nullptr)
            measure_sides(list, first, slot);
        else
            measure_near(list, first, slot);
    }

    /// As measure, with the triangles that are near.
    HWY_INLINE void measure_near(const LeafList& list, std::size_t first, std::uint32_t slot)
    {
        const auto leaf = slot / static_cast<std::uint32_t>(k_hierarchy_leaf);
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
            I index;
            const V3 p = load_copies(list, i, index);
            F least = set(PointPacket::k_far_sq);
            I nearest = hn::Zero(di);
            F each_sq[k_hierarchy_leaf];
            for (std::size_t k = 0; k < k_hierarchy_leaf; ++k) {
                each_sq[k] = frames_.see_one(first + k, frames_.foot_one(first + k, p)).distance_sq;
                nearest = blend(hn::Lt(each_sq[k], least), set_int(static_cast<std::int32_t>(k)), nearest);
                least = hn::Min(least, each_sq[k]);
            }
            const F before = hn::GatherIndex(df, points_.distance_sq, index);
            const M changed = hn::And(within(list, i), hn::Le(least, reach_above_lanes(before)));
            if (!any(changed)) continue;
            const F reach = reach_above_lanes(hn::Min(before, least));
            I triangles = hn::Zero(di);
            for (std::uint32_t k = 0; k < k_hierarchy_leaf; ++k) {
                const M is_near = hn::Le(each_sq[k], reach);
                triangles = hn::Or(triangles, hn::IfThenElseZero(hn::RebindMask(di, is_near), child_bit(k)));
            }
            HWY_ALIGN std::int32_t at[k_lanes], bits[k_lanes], which[k_lanes];
            HWY_ALIGN float least_sq[k_lanes], reach_sq[k_lanes];
            hn::Store(index, di, at);
            hn::Store(triangles, di, bits);
            hn::Store(nearest, di, which);
            hn::Store(least, df, least_sq);
            hn::Store(reach, df, reach_sq);
            each_lane(changed, [&](std::size_t lane) {
                const auto point = static_cast<std::size_t>(at[lane]);
                remember(near_[point], leaf, static_cast<std::uint32_t>(bits[lane]), least_sq[lane], reach_sq[lane]);
                points_.offer(point, least_sq[lane], slot + static_cast<std::uint32_t>(which[lane]));
            });
        }
    }

    /// As measure, with the side that each point is seen from.
    HWY_INLINE void measure_sides(const LeafList& list, std::size_t first, std::uint32_t slot)
    {
        const F far = set(PointPacket::k_far_sq);
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
            I index;
            const V3 p = load_copies(list, i, index);
            F least = far, outside_sq = far, inside_sq = far, unclear_sq = far;
            I nearest = hn::Zero(di);
            for (std::size_t k = 0; k < k_hierarchy_leaf; ++k) {
                const TriangleFrames::Foot foot = frames_.foot_one(first + k, p);
                const TriangleFrames::Seen s = frames_.see_one(first + k, foot);
                const M outside = hn::Gt(foot.height, hn::Zero(df)), nearer = hn::Lt(s.distance_sq, least);
                nearest = blend(nearer, set_int(static_cast<std::int32_t>(k)), nearest);
                least = hn::Min(least, s.distance_sq);
                outside_sq = hn::Min(outside_sq, blend(outside, s.distance_sq, far));
                inside_sq = hn::Min(inside_sq, blend(outside, far, s.distance_sq));
                unclear_sq = hn::Min(unclear_sq, blend(s.flat, s.distance_sq, far));
            }
            const M changed =
                hn::And(within(list, i), hn::Le(least, tie_above_lanes(hn::GatherIndex(df, points_.distance_sq, index))));
            if (!any(changed)) continue;
            HWY_ALIGN std::int32_t at[k_lanes], which[k_lanes];
            HWY_ALIGN float values[4][k_lanes];
            hn::Store(index, di, at);
            hn::Store(nearest, di, which);
            hn::Store(least, df, values[0]);
            hn::Store(outside_sq, df, values[1]);
            hn::Store(inside_sq, df, values[2]);
            hn::Store(unclear_sq, df, values[3]);
            each_lane(changed, [&](std::size_t lane) {
                const std::int32_t point = at[lane];
                points_.offer(static_cast<std::size_t>(point), values[0][lane], slot + static_cast<std::uint32_t>(which[lane]));
                points_.outside_sq[point] = std::min(points_.outside_sq[point], values[1][lane]);
                points_.inside_sq[point] = std::min(points_.inside_sq[point], values[2][lane]);
                points_.unclear_sq[point] = std::min(points_.unclear_sq[point], values[3][lane]);
            });
        }
    }

    static constexpr std::size_t k_levels = model::k_max_hierarchy_levels + 1;

    PointPacket& points_;
    List lists_[k_levels];
    LeafList leaf_list_[2];
    std::int32_t children_[k_levels][PointPacket::k_capacity];  // a bit for each child that a point of the level's list goes to
    float near_points_[4][PointPacket::k_capacity];
    TriangleFrames frames_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
