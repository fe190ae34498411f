// The nearest of a model's triangles, sought through the hierarchy of boxes: sixteen boxes or triangles at a time for one point.
#if defined(SQMAP_QUERY_HIERARCHY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_HIERARCHY_INL_H
#undef SQMAP_QUERY_HIERARCHY_INL_H
#else
#define SQMAP_QUERY_HIERARCHY_INL_H
#endif

#include "model/hierarchy.h"
#include "query/distance/distance_kernels.h"
#include "query/distance/triangle_frames-inl.h"

#include "sqmap/model/model.h"

#include <algorithm>
#include <bit>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;
using model::k_hierarchy_leaf;
using model::k_hierarchy_width;
using model::ModelView;

constexpr std::size_t k_row = 16;  // boxes or triangles at a time
constexpr float k_tie = 1.001f;    // squared distances up to which a triangle is as near, for all that float tells
/// Points side by side, each with the nearest triangle so far. Answers depend on neither the order of the search nor its vectors:
/// of triangles as near the one that comes first counts, and sides are least distances of those that see the point so.
struct PointPacket {
    static constexpr std::size_t k_capacity = k_searched_at_once + k_max_lanes;
    std::size_t count = 0;
    float x[k_capacity], y[k_capacity], z[k_capacity];
    float distance_sq[k_capacity];   ///< before a search: what is farther is not looked for
    std::uint32_t slot[k_capacity];  ///< of the nearest among the entries
    float outside_sq[k_capacity], inside_sq[k_capacity], unclear_sq[k_capacity];

    void put(std::size_t i, Vec3f p)
    {
        x[i] = p.x;
        y[i] = p.y;
        z[i] = p.z;
        distance_sq[i] = outside_sq[i] = inside_sq[i] = unclear_sq[i] = k_far_sq;
        slot[i] = k_no_slot;
    }
    /// The first in the hierarchy counts of triangles as near.
    void offer(std::size_t i, float d_sq, std::uint32_t of)
    {
        if (d_sq > distance_sq[i] || (d_sq == distance_sq[i] && of > slot[i])) return;
        distance_sq[i] = d_sq;
        slot[i] = of;
    }
    static constexpr float k_far_sq = 1e30f;
    static constexpr std::uint32_t k_no_slot = 0xffffffffu;
};

/// Leaves out what is farther than the reach.
inline void drop_far(NearTriangles& near, float reach_sq)
{
    std::uint32_t left = 0;
    for (std::uint32_t i = 0; i < near.count; ++i) {
        near.leaves[left] = near.leaves[i];
        near.least_sq[left] = near.least_sq[i];
        left += near.least_sq[i] <= reach_sq ? 1 : 0;
    }
    near.count = left;
}
/// Remembers a leaf, with the chosen of its triangles and the least squared distance of these; beyond reach_sq nothing counts any
/// more.
inline void remember(NearTriangles& near, std::uint32_t leaf, std::uint32_t triangles, float least_sq, float reach_sq)
{
    if (near.count >= NearTriangles::k_capacity) {
        if (near.count == NearTriangles::k_too_many) return;
        drop_far(near, reach_sq);
        if (near.count == NearTriangles::k_capacity) {
            near.count = NearTriangles::k_too_many;
            return;
        }
    }
    near.leaves[near.count] = leaf << 8 | triangles;
    near.least_sq[near.count++] = least_sq;
}

class Hierarchy {
public:
    explicit Hierarchy(const ModelView& model) : Hierarchy(model, nullptr, 0) {}
    /// near: where to remember, for each point of a packet, what is within slack of the nearest, model units; null: nowhere.
    Hierarchy(const ModelView& model, NearTriangles* near, float slack)
        : model_(model),
          arrays_(model.distance),
          levels_(model::hierarchy_levels(model.distance.header.entries)),
          near_(near),
          slack_(slack)
    {
        const float size = model.header.sphere[3];
        tie_ = 4e-12f * size * size;
        triangles_ = static_cast<std::uint32_t>(model.triangle_part.size());
    }

    /// One point of a packet.
    HWY_NOINLINE void search(PointPacket& points, std::size_t point) const
    {
        const Vec3f p{points.x[point], points.y[point], points.z[point]};
        Nearest nearest;
        struct Waiting {
            float distance_sq;
            std::uint32_t level, node;  // in its level
        };
        Waiting stack[model::k_max_hierarchy_levels * k_hierarchy_width];
        std::size_t size = 0;
        stack[size++] = {0.f, 0, 0};
        HWY_ALIGN float distance_sq[k_row];
        while (size > 0) {
            const Waiting at = stack[--size];
            const float reach = reach_above(nearest.distance_sq);
            if (at.distance_sq > reach) continue;
            if (at.level == levels_.count) {
                visit_leaves(p, point, at.node, reach, nearest);
                continue;
            }
            std::uint32_t near = box_distances(p, at.level, at.node, reach, distance_sq);
            const std::size_t bottom = size;
            for (; near != 0; near &= near - 1) {
                const auto i = static_cast<std::uint32_t>(std::countr_zero(near));
                std::size_t slot = size++;
                for (; slot > bottom && stack[slot - 1].distance_sq < distance_sq[i]; --slot) stack[slot] = stack[slot - 1];
                stack[slot] = {distance_sq[i], at.level + 1, at.node * k_hierarchy_width + i};
            }
        }
        points.distance_sq[point] = nearest.distance_sq;
        points.slot[point] = nearest.slot;
        points.outside_sq[point] = nearest.outside_sq;
        points.inside_sq[point] = nearest.inside_sq;
        points.unclear_sq[point] = nearest.unclear_sq;
    }

    /// Calls visit(leaf) for the leaves whose boxes are within reach of a point; it returns the reach from then on.
    template <class Visit>
    HWY_INLINE void each_leaf(Vec3f p, float reach, Visit&& visit) const
    {
        struct Waiting {
            float distance_sq;
            std::uint32_t level, node;  // in its level
        };
        Waiting stack[model::k_max_hierarchy_levels * k_hierarchy_width];
        std::size_t size = 0;
        stack[size++] = {0.f, 0, 0};
        HWY_ALIGN float distance_sq[k_row];
        while (size > 0) {
            const Waiting at = stack[--size];
            if (at.distance_sq > reach * reach) continue;
            if (at.level == levels_.count) {
                for (std::uint32_t near = leaf_distances(p, at.node, reach * reach, distance_sq); near != 0; near &= near - 1) {
                    const auto i = static_cast<std::uint32_t>(std::countr_zero(near));
                    if (distance_sq[i] <= reach * reach) reach = visit(at.node * k_hierarchy_width + i);
                }
                continue;
            }
            for (std::uint32_t near = box_distances(p, at.level, at.node, reach * reach, distance_sq); near != 0;
                 near &= near - 1) {
                const auto i = static_cast<std::uint32_t>(std::countr_zero(near));
                stack[size++] = {distance_sq[i], at.level + 1, at.node * k_hierarchy_width + i};
            }
        }
    }

    /// A vector of the answers of a packet's points, from first on.
    HWY_INLINE void finish(const PointPacket& points, std::size_t first, NearestSurface* found) const
    {
        const std::size_t count = std::min(points.count - first, hn::Lanes(df));
        Corners corners;
        std::uint32_t entries[k_lanes];
        for (std::size_t i = 0; i < hn::Lanes(df); ++i) {
            const std::uint32_t slot = points.slot[first + std::min(i, count - 1)];
            entries[i] = entry_at(slot == PointPacket::k_no_slot ? 0 : slot);
            put_corners(entries[i], i, corners);
        }
        TriangleFrames frames;
        frames.put(0, corner_lanes(corners, 0, 0), corner_lanes(corners, 1, 0), corner_lanes(corners, 2, 0));
        const V3 p{hn::LoadU(df, points.x + first), hn::LoadU(df, points.y + first), hn::LoadU(df, points.z + first)};
        const TriangleFrames::Foot foot = frames.foot_each(0, p);
        const V3 offset = frames.offset_each(0, foot, frames.see_each(0, foot));
        const F distance_sq = hn::LoadU(df, points.distance_sq + first), as_near = mul_add(distance_sq, set(k_tie), set(tie_));
        const auto side = [&](const float* least_sq, SeenSide bit) HWY_ATTR {
            const M seen = hn::Le(hn::LoadU(df, least_sq + first), as_near);
            return hn::IfThenElseZero(hn::RebindMask(di, seen), set_int(static_cast<std::int32_t>(bit)));
        };
        const I sides = hn::Or(side(points.unclear_sq, k_seen_unclear),
                               hn::Or(side(points.outside_sq, k_seen_outside), side(points.inside_sq, k_seen_inside)));
        HWY_ALIGN float values[4][k_lanes];
        HWY_ALIGN std::int32_t seen[k_lanes];
        hn::Store(offset.x, df, values[0]);
        hn::Store(offset.y, df, values[1]);
        hn::Store(offset.z, df, values[2]);
        hn::Store(hn::Sqrt(distance_sq), df, values[3]);
        hn::Store(sides, di, seen);
        for (std::size_t i = 0; i < count; ++i)
            found[i] = {{values[0][i], values[1][i], values[2][i]},
                        values[3][i],
                        points.slot[first + i] == PointPacket::k_no_slot ? -1 : static_cast<std::int32_t>(entries[i]),
                        static_cast<std::uint32_t>(seen[i])};
    }

    /// Squared distances up to which a triangle is as near, for all that float tells.
    float tie_above(float distance_sq) const { return distance_sq * k_tie + tie_; }
    /// Squared distances up to which boxes and triangles are looked at.
    float reach_above(float distance_sq) const
    {
        if (near_ == nullptr) return tie_above(distance_sq);
        const float reach = std::sqrt(distance_sq) + slack_;
        return reach * reach;
    }
    /// The entry in one of the leaves.
    std::uint32_t entry_at(std::size_t i) const
    {
        return arrays_.entries16.empty() ? arrays_.entries32[i] : arrays_.entries16[i];
    }

protected:
    /// The nearest triangle of one point, as a packet has it.
    struct Nearest {
        float distance_sq = PointPacket::k_far_sq;
        std::uint32_t slot = PointPacket::k_no_slot;
        float outside_sq = PointPacket::k_far_sq, inside_sq = PointPacket::k_far_sq, unclear_sq = PointPacket::k_far_sq;
    };

    /// Which of a node's boxes are within reach.
    HWY_INLINE std::uint32_t box_distances(Vec3f p, std::uint32_t level, std::uint32_t node, float reach, float* out) const
    {
        const model::HierarchyNode& n = node_at(level, node);
        const float over = 1.f / n.step;
        const F px = set((p.x - n.origin[0]) * over), py = set((p.y - n.origin[1]) * over), pz = set((p.z - n.origin[2]) * over);
        const F step_sq = set(n.step * n.step), limit = set(reach);
        std::uint32_t near = 0;
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const F dx = beyond(n, 0, i, px), dy = beyond(n, 1, i, py), dz = beyond(n, 2, i, pz);
            const F d = hn::Mul(mul_add(dx, dx, mul_add(dy, dy, hn::Mul(dz, dz))), step_sq);
            hn::Store(d, df, out + i);
            near |= bits(hn::Le(d, limit)) << i;
        }
        return near & ((1u << children_of(level, node)) - 1);
    }
    const model::HierarchyNode& node_at(std::uint32_t level, std::uint32_t node) const
    {
        return arrays_.nodes[levels_.first[level] + node];
    }
    std::uint32_t children_of(std::uint32_t level, std::uint32_t node) const
    {
        return std::min<std::uint32_t>(k_hierarchy_width, levels_.children[level] - node * k_hierarchy_width);
    }
    static HWY_INLINE F beyond(const model::HierarchyNode& node, int axis, std::size_t i, F p)
    {
        const hn::Rebind<std::uint8_t, DF> d8;
        const F lo = to_float(hn::PromoteTo(di, hn::LoadU(d8, node.lo[axis] + i))),
                hi = to_float(hn::PromoteTo(di, hn::LoadU(d8, node.hi[axis] + i)));
        return hn::Max(hn::Max(hn::Sub(lo, p), hn::Sub(p, hi)), hn::Zero(df));
    }
    static HWY_INLINE std::uint32_t bits(M mask)
    {
        HWY_ALIGN std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(df, mask, bytes);
        return bytes[0] | std::uint32_t{bytes[1]} << 8;
    }

    /// Boxes of a group's leaves, side by side.
    struct LeafBoxes {
        HWY_ALIGN float centre[3][k_row];
        HWY_ALIGN float axis[3][3][k_row];
        HWY_ALIGN float extent[3][k_row];
    };
    static HWY_INLINE F codes(const std::uint8_t* at)
    {
        return to_float(hn::PromoteTo(di, hn::LoadU(hn::Rebind<std::uint8_t, DF>(), at)));
    }
    /// See model::decode_axis and model::box_axes.
    HWY_INLINE void decode(const model::HierarchyGroup& g, LeafBoxes& out) const
    {
        const F one = set(1.f), unit = set(2.f / 255.f);
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            for (int k = 0; k < 3; ++k)
                hn::Store(mul_add(codes(g.centre[k] + i), set(g.step), set(g.origin[k])), df, out.centre[k] + i);
            const F x = hn::Sub(hn::Mul(codes(g.normal[0] + i), unit), one),
                    y = hn::Sub(hn::Mul(codes(g.normal[1] + i), unit), one);
            const F z = hn::Sub(hn::Sub(one, hn::Abs(x)), hn::Abs(y)), fold = hn::Max(hn::Neg(z), hn::Zero(df));
            const V3 raw{hn::Sub(x, hn::CopySign(fold, x)), hn::Sub(y, hn::CopySign(fold, y)), z};
            const V3 n = scaled(hn::Div(one, hn::Sqrt(dot(raw, raw))), raw);
            const F sign = hn::CopySign(one, n.z), a = hn::Div(set(-1.f), hn::Add(sign, n.z));
            const F xa = hn::Mul(n.x, a), b = hn::Mul(xa, n.y);
            const V3 first{mul_add(hn::Mul(sign, n.x), xa, one), hn::Mul(sign, b), hn::Neg(hn::Mul(sign, n.x))};
            const V3 second{b, mul_add(hn::Mul(n.y, n.y), a, sign), hn::Neg(n.y)};
            const F t = hn::Mul(codes(g.turn + i), set(1.f / 255.f)), over = hn::Div(one, mul_add(t, t, one));
            const F cosine = hn::Mul(hn::Sub(one, hn::Mul(t, t)), over), sine = hn::Mul(hn::Add(t, t), over);
            const V3 axes[3] = {n, minus_scaled(scaled(cosine, first), hn::Neg(sine), second),
                                minus_scaled(scaled(cosine, second), sine, first)};
            for (int k = 0; k < 3; ++k) {
                hn::Store(axes[k].x, df, out.axis[k][0] + i);
                hn::Store(axes[k].y, df, out.axis[k][1] + i);
                hn::Store(axes[k].z, df, out.axis[k][2] + i);
            }
            hn::Store(hn::Mul(codes(g.height + i), set(g.height_step)), df, out.extent[0] + i);
            for (int k = 0; k < 2; ++k) hn::Store(hn::Mul(codes(g.width[k] + i), set(g.width_step)), df, out.extent[k + 1] + i);
        }
    }
    /// Squared distance to boxes; 0 within them. get(values): of a row.
    template <class Get>
    static HWY_INLINE F to_box(const LeafBoxes& boxes, const V3& p, Get&& get)
    {
        const V3 d = minus(p, {get(boxes.centre[0]), get(boxes.centre[1]), get(boxes.centre[2])});
        F beyond[3];
        for (int k = 0; k < 3; ++k) {
            const F along = dot(d, {get(boxes.axis[k][0]), get(boxes.axis[k][1]), get(boxes.axis[k][2])});
            beyond[k] = hn::Max(hn::Sub(hn::Abs(along), get(boxes.extent[k])), hn::Zero(df));
        }
        return dot({beyond[0], beyond[1], beyond[2]}, {beyond[0], beyond[1], beyond[2]});
    }
    std::uint32_t leaves_of(std::uint32_t group) const
    {
        return std::min<std::uint32_t>(k_hierarchy_width, model::leaf_count(arrays_.header.entries) - group * k_hierarchy_width);
    }

    /// Which of a group's leaves are within reach.
    HWY_INLINE std::uint32_t leaf_distances(Vec3f p, std::uint32_t group, float limit, float* out) const
    {
        LeafBoxes boxes;
        decode(arrays_.groups[group], boxes);
        std::uint32_t near = 0;
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const F d_sq =
                to_box(boxes, {set(p.x), set(p.y), set(p.z)}, [i](const float* row) HWY_ATTR { return hn::Load(df, row + i); });
            hn::Store(d_sq, df, out + i);
            near |= bits(hn::Le(d_sq, set(limit))) << i;
        }
        return near & ((1u << leaves_of(group)) - 1);
    }

    /// Leaves of a group, the nearest two at a time.
    HWY_INLINE void visit_leaves(Vec3f p, std::size_t point, std::uint32_t group, float limit, Nearest& nearest) const
    {
        const std::uint32_t first = group * k_hierarchy_width;
        HWY_ALIGN float distance_sq[k_row];
        std::uint32_t near = leaf_distances(p, group, limit, distance_sq);
        while (near != 0) {
            std::uint32_t best = 0, second = 0;
            float best_sq = INFINITY, second_sq = INFINITY;
            for (std::uint32_t left = near; left != 0; left &= left - 1) {
                const auto i = static_cast<std::uint32_t>(std::countr_zero(left));
                const float d = distance_sq[i];
                if (d < best_sq) {
                    second = best;
                    second_sq = best_sq;
                    best = i;
                    best_sq = d;
                } else if (d < second_sq) {
                    second = i;
                    second_sq = d;
                }
            }
            const float reach = reach_above(nearest.distance_sq);
            if (best_sq > reach) return;
            const bool two = second_sq <= reach;
            near &= ~(1u << best);
            if (two) near &= ~(1u << second);
            measure(p, point, first + best, two ? first + second : first + best, nearest);
        }
    }

    const float* corner(std::uint32_t entry, std::uint32_t k) const
    {
        if (entry >= triangles_) return model_.pieces.data() + 9 * std::size_t{entry - triangles_} + 3 * k;
        return model_.vertices.data() + 3 * std::size_t{model::triangle_vertex(model_, entry, k)};
    }

    /// Corners of a row of triangles, four floats each. Reading past an array's last value is safe: something always follows it
    /// in a parsed model's blob.
    struct Corners {
        HWY_ALIGN float at[3][4 * k_row];
    };
    HWY_INLINE void put_corners(std::uint32_t entry, std::size_t i, Corners& corners) const
    {
        for (std::uint32_t k = 0; k < 3; ++k) std::memcpy(&corners.at[k][4 * i], corner(entry, k), 4 * sizeof(float));
    }
    static HWY_INLINE V3 corner_lanes(const Corners& corners, int k, std::size_t i)
    {
        V3 v;
        F unused;
        hn::LoadInterleaved4(df, &corners.at[k][4 * i], v.x, v.y, v.z, unused);
        return v;
    }

    /// The triangles of two leaves against the point.
    HWY_NOINLINE void measure(Vec3f p, std::size_t point, std::uint32_t leaf, std::uint32_t other, Nearest& nearest) const
    {
        Corners corners;
        std::uint32_t slots[k_row];
        for (std::size_t i = 0; i < k_row; ++i) {
            slots[i] =
                static_cast<std::uint32_t>((i < k_hierarchy_leaf ? leaf : other) * k_hierarchy_leaf + i % k_hierarchy_leaf);
            put_corners(entry_at(slots[i]), i, corners);
        }
        const F far = set(PointPacket::k_far_sq);
        HWY_ALIGN float distance_sq[k_row];
        float least = PointPacket::k_far_sq;
        const V3 at{set(p.x), set(p.y), set(p.z)};
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            TriangleFrames frames;
            frames.put(0, corner_lanes(corners, 0, i), corner_lanes(corners, 1, i), corner_lanes(corners, 2, i));
            const TriangleFrames::Foot foot = frames.foot_each(0, at);
            const TriangleFrames::Seen s = frames.see_each(0, foot);
            hn::Store(s.distance_sq, df, distance_sq + i);
            const M outside = hn::Gt(foot.height, hn::Zero(df));
            const auto lower = [&](float& value, F by) HWY_ATTR { value = std::min(value, hn::GetLane(hn::MinOfLanes(df, by))); };
            lower(least, s.distance_sq);
            lower(nearest.outside_sq, blend(outside, s.distance_sq, far));
            lower(nearest.inside_sq, blend(outside, far, s.distance_sq));
            lower(nearest.unclear_sq, blend(s.flat, s.distance_sq, far));
        }
        if (near_ != nullptr) {
            const float reach = reach_above(std::min(least, nearest.distance_sq));
            remember_leaf(point, leaf, distance_sq, reach);
            if (other != leaf) remember_leaf(point, other, distance_sq + k_hierarchy_leaf, reach);
        }
        if (!(least <= nearest.distance_sq)) return;
        std::uint32_t slot = least < nearest.distance_sq ? PointPacket::k_no_slot : nearest.slot;
        for (std::size_t i = 0; i < k_row; ++i)
            if (distance_sq[i] == least) slot = std::min(slot, slots[i]);
        nearest.distance_sq = least;
        nearest.slot = slot;
    }

    /// distance_sq: of the leaf's triangles.
    void remember_leaf(std::size_t point, std::uint32_t leaf, const float* distance_sq, float reach_sq) const
    {
        const float least_sq = *std::min_element(distance_sq, distance_sq + k_hierarchy_leaf);
        if (!(least_sq <= reach_sq)) return;
        std::uint32_t triangles = 0;
        for (std::uint32_t k = 0; k < k_hierarchy_leaf; ++k) triangles |= distance_sq[k] <= reach_sq ? 1u << k : 0u;
        remember(near_[point], leaf, triangles, least_sq, reach_sq);
    }

    const ModelView& model_;
    const model::DistanceArrays<model::ArrayView>& arrays_;
    model::HierarchyLevels levels_;
    NearTriangles* near_;
    float slack_;
    std::uint32_t triangles_;
    float tie_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
