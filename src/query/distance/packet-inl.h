// Many points against the hierarchy at once: a node is visited with all points that may be near to it, a vector of them at a
// time.
#if defined(SQMAP_QUERY_PACKET_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_PACKET_INL_H
#undef SQMAP_QUERY_PACKET_INL_H
#else
#define SQMAP_QUERY_PACKET_INL_H
#endif

#include "math/triangles-inl.h"
#include "query/distance/hierarchy-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

/// Points side by side, each with the nearest triangle so far.
struct PointPacket {
    static constexpr std::size_t k_size = 2048, k_capacity = k_size + k_max_lanes;
    std::size_t count = 0;
    float x[k_capacity], y[k_capacity], z[k_capacity];
    float distance_sq[k_capacity];  ///< before a search: what is farther is not looked for
    float offset[3][k_capacity];    ///< from the point to the nearest of its triangle
    std::int32_t entry[k_capacity];
    std::uint32_t sides[k_capacity];  ///< bits of SeenSide
};

class PacketSearch : Hierarchy {
public:
    PacketSearch(const ModelView& model, PointPacket& points) : Hierarchy(model), points_(points) {}

    void run()
    {
        if (arrays_.groups.empty() || points_.count == 0) return;
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

    HWY_INLINE V3 load(const List& list, std::size_t i, I& index) const
    {
        index = hn::LoadU(di, list.index + i);
        // What is behind the end of a list repeats a point that there is.
        if (i + hn::Lanes(df) > list.count) index = blend(hn::FirstN(df, list.count - i), index, set_int(list.index[i]));
        return {hn::GatherIndex(df, points_.x, index), hn::GatherIndex(df, points_.y, index),
                hn::GatherIndex(df, points_.z, index)};
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
    /// Those of the level's list that go to a child.
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
            to.count += hn::CountTrue(df, taken);
        }
    }

    /// Lets each point's search begin at the nearest corners of a leaf: that whose box's middle is nearest, level by level.
    HWY_NOINLINE void seed(std::uint32_t level, std::uint32_t node)
    {
        if (level == levels_.count) {
            const Cylinders cylinders = decode(arrays_.groups[node]);
            choose_nearest(level, leaves_of(node), [&](std::uint32_t c) HWY_ATTR { return centre(cylinders, c); });
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
                // A little more, so that the triangle there is nearer, for all rounding.
                least = hn::Min(least, mul_add(dot(d, d), set(k_tie), set(tie_)));
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
            const F reach = tie_above_lanes(hn::GatherIndex(df, points_.distance_sq, index));
            hn::StoreU(hn::Mul(reach, set(scale * scale)), df, near_points_[3] + i);
        }
    }
    /// Which children are within reach of each of these points; squared_distance(c, points).
    template <class SquaredDistance>
    HWY_INLINE void choose_near(std::uint32_t level, std::uint32_t count, SquaredDistance&& squared_distance)
    {
        const List& list = lists_[level];
        std::int32_t* children = children_[level];
        for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) hn::StoreU(hn::Zero(di), di, children + i);
        for (std::uint32_t c = 0; c < count; ++c) {
            const I bit = child_bit(c);
            const auto distance_sq = squared_distance(c);
            for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
                const F d_sq = distance_sq(
                    {hn::LoadU(df, near_points_[0] + i), hn::LoadU(df, near_points_[1] + i), hn::LoadU(df, near_points_[2] + i)});
                const M near = hn::Le(d_sq, hn::LoadU(df, near_points_[3] + i));
                hn::StoreU(hn::Or(hn::LoadU(di, children + i), hn::IfThenElseZero(hn::RebindMask(di, near), bit)), di,
                           children + i);
            }
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
        choose_near(level, children_of(level, node), [&](std::uint32_t c) HWY_ATTR {
            return [&n, c](const V3& p) HWY_ATTR {
                const auto beyond = [&](F v, int k) HWY_ATTR {
                    return hn::Max(hn::Max(hn::Sub(set(n.lo[k][c]), v), hn::Sub(v, set(n.hi[k][c]))), hn::Zero(df));
                };
                const V3 d{beyond(p.x, 0), beyond(p.y, 1), beyond(p.z, 2)};
                return dot(d, d);
            };
        });
        for (std::uint32_t left = chosen_by_some(level); left != 0; left &= left - 1) {
            const auto c = static_cast<std::uint32_t>(std::countr_zero(left));
            take(level, c, lists_[level + 1]);
            visit(level + 1, node * k_hierarchy_width + c);
        }
    }

    HWY_NOINLINE void visit_group(std::uint32_t level, std::uint32_t group)
    {
        const Cylinders cylinders = decode(arrays_.groups[group]);
        put_points(lists_[level], {0, 0, 0}, 1.f);
        const std::uint32_t leaves = leaves_of(group);
        choose_near(level, leaves, [&](std::uint32_t c) HWY_ATTR {
            const V3 middle = centre(cylinders, c);
            const V3 axis{set(cylinders.axis[0][c]), set(cylinders.axis[1][c]), set(cylinders.axis[2][c])};
            const F height = set(cylinders.height[c]), radius = set(cylinders.radius[c]);
            return [=](const V3& p) HWY_ATTR { return to_cylinder(minus(p, middle), axis, height, radius); };
        });
        const std::uint32_t chosen = chosen_by_some(level);
        for (std::uint32_t c = 0; c < leaves; c += 2) {
            if ((chosen >> c & 3u) == 0) continue;
            for (std::uint32_t k = 0; k < 2; ++k) {
                leaf_list_[k].count = 0;
                if ((chosen >> (c + k) & 1u) != 0) take(level, c + k, leaf_list_[k]);
            }
            measure_leaves(group * k_hierarchy_width + c);
        }
    }

    static HWY_INLINE V3 centre(const Cylinders& cylinders, std::uint32_t c)
    {
        return {set(cylinders.centre[0][c]), set(cylinders.centre[1][c]), set(cylinders.centre[2][c])};
    }

    /// The triangles of two neighbouring leaves against the points that may be near to each.
    HWY_NOINLINE void measure_leaves(std::uint32_t leaf)
    {
        const std::size_t first = leaf_list_[0].count > 0 ? 0 : 1, end = leaf_list_[1].count > 0 ? 2 : 1;
        std::uint32_t entries[2 * k_hierarchy_leaf];
        prepare(leaf + static_cast<std::uint32_t>(first), (end - first) * k_hierarchy_leaf, entries);
        for (std::size_t k = first; k < end; ++k) {
            const List& list = leaf_list_[k];
            const std::size_t block = (k - first) * k_hierarchy_leaf;
            for (std::size_t i = 0; i < list.count; i += hn::Lanes(df)) {
                I index;
                const V3 p = load(list, i, index);
                measure(p, index, {block, entries + block}, within(list, i));
            }
        }
    }

    HWY_NOINLINE void prepare(std::uint32_t leaf, std::size_t n, std::uint32_t* entries)
    {
        Corners corners;
        for (std::size_t i = 0; i < n; ++i) entries[i] = entry_at(leaf * k_hierarchy_leaf + i);
        for (std::size_t i = 0; i < k_row; ++i) put_corners(entries[std::min(i, n - 1)], i, corners);
        for (std::size_t i = 0; i < n; i += hn::Lanes(df)) {
            V3 v[3];
            for (int k = 0; k < 3; ++k) v[k] = corner_lanes(corners, k, i);
            block_.put(i, v[0], v[1], v[2]);
        }
    }

    HWY_INLINE F tie_above_lanes(F distance_sq) const { return mul_add(distance_sq, set(k_tie), set(tie_)); }

    /// Eight triangles of the block, and what they are.
    struct Leaf {
        std::size_t first;
        const std::uint32_t* entries;
    };
    /// What a vector of points knows of its nearest triangles.
    struct Lanes {
        F distance_sq;
        V3 offset;
        I entry, sides;
    };

    HWY_INLINE void measure(const V3& p, I index, const Leaf& leaf, M lanes)
    {
        Lanes now;
        now.distance_sq = hn::GatherIndex(df, points_.distance_sq, index);
        const F reach = tie_above_lanes(now.distance_sq);
        std::uint32_t near = 0;
        for (std::size_t k = 0; k < k_hierarchy_leaf; ++k)
            near |= (any(hn::And(lanes, hn::Le(block_.position(leaf.first + k, p).lower_sq, reach))) ? 1u : 0u) << k;
        if (near == 0) return;
        now.sides = hn::GatherIndex(di, reinterpret_cast<const std::int32_t*>(points_.sides), index);
        now.offset = {hn::Zero(df), hn::Zero(df), hn::Zero(df)};
        now.entry = hn::Zero(di);
        const Lanes before = now;
        for (; near != 0; near &= near - 1) {
            const auto k = static_cast<std::size_t>(std::countr_zero(near));
            measure_triangle(p, leaf.first + k, leaf.entries[k], reach, now);
        }
        const M improved = hn::And(lanes, hn::Lt(now.distance_sq, before.distance_sq));
        write(now, index, improved, hn::And(lanes, hn::Or(improved, hn::Not(equal(now.sides, before.sides)))));
    }

    HWY_INLINE void measure_triangle(const V3& p, std::size_t at, std::uint32_t entry, F reach, Lanes& now) const
    {
        const TriangleBlock::Position q = block_.position(at, p);
        F edge_sq;
        const V3 to_edge = block_.to_edges(at, q, edge_sq);
        const V3 to_face = block_.to_face(at, q);
        const V3 to = blend(q.above, to_face, to_edge);
        const F distance_sq = blend(q.above, dot(to_face, to_face), edge_sq);
        // What other lanes need is nothing to this one: answers do not depend on how many there are.
        const M needed = hn::Le(q.lower_sq, reach);
        const M level = hn::And(needed, hn::Le(distance_sq, tie_above_lanes(now.distance_sq)));
        // Clearly nearer than what was found before, whose side is forgotten.
        const M fresh = hn::And(needed, hn::Lt(tie_above_lanes(distance_sq), now.distance_sq));
        // In the plane of a triangle, or without area, it says nothing of the side.
        const M flat = hn::Le(hn::Mul(q.height, q.height), hn::Mul(set(k_flat), distance_sq));
        const M outside = hn::Gt(q.height, hn::Zero(df));
        const auto flag = [](M m, SeenSide bit) HWY_ATTR {
            return hn::IfThenElseZero(hn::RebindMask(di, m), set_int(static_cast<std::int32_t>(bit)));
        };
        const I seen =
            hn::Or(flag(hn::And(level, flat), k_seen_unclear),
                   hn::Or(flag(hn::And(level, outside), k_seen_outside), flag(hn::AndNot(outside, level), k_seen_inside)));
        now.sides = hn::Or(blend(fresh, hn::Zero(di), now.sides), seen);
        const M nearer = hn::And(needed, hn::Lt(distance_sq, now.distance_sq));
        now.distance_sq = blend(nearer, distance_sq, now.distance_sq);
        now.offset = blend(nearer, to, now.offset);
        now.entry = blend(nearer, set_int(static_cast<std::int32_t>(entry)), now.entry);
    }

    HWY_INLINE void write(const Lanes& now, I index, M improved, M changed)
    {
        if (!any(changed)) return;
        HWY_ALIGN std::int32_t at[k_lanes], entry[k_lanes], sides[k_lanes];
        HWY_ALIGN float values[4][k_lanes];
        hn::Store(index, di, at);
        hn::Store(now.entry, di, entry);
        hn::Store(now.sides, di, sides);
        hn::Store(now.distance_sq, df, values[0]);
        hn::Store(now.offset.x, df, values[1]);
        hn::Store(now.offset.y, df, values[2]);
        hn::Store(now.offset.z, df, values[3]);
        each_lane(changed, [&](std::size_t i) { points_.sides[at[i]] = static_cast<std::uint32_t>(sides[i]); });
        each_lane(improved, [&](std::size_t i) {
            points_.distance_sq[at[i]] = values[0][i];
            for (int k = 0; k < 3; ++k) points_.offset[k][at[i]] = values[k + 1][i];
            points_.entry[at[i]] = entry[i];
        });
    }

    static constexpr std::size_t k_levels = model::k_max_hierarchy_levels + 1;

    PointPacket& points_;
    List lists_[k_levels], leaf_list_[2];
    std::int32_t children_[k_levels][PointPacket::k_capacity];  // a bit for each child that a point of the level's list goes to
    float near_points_[4][PointPacket::k_capacity];
    TriangleBlock block_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
