// The nearest of a model's triangles, sought through the hierarchy of boxes: sixteen boxes or triangles at a time for one point.
#if defined(SQMAP_QUERY_HIERARCHY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_HIERARCHY_INL_H
#undef SQMAP_QUERY_HIERARCHY_INL_H
#else
#define SQMAP_QUERY_HIERARCHY_INL_H
#endif

#include "math/lanes-inl.h"
#include "model/hierarchy.h"
#include "query/distance/distance_kernels.h"

#include "sqmap/model/model.h"

#include <bit>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;
using model::k_hierarchy_leaf;
using model::k_hierarchy_width;
using model::ModelView;

constexpr std::size_t k_row = 16;  // boxes or triangles at a time
constexpr float k_tie = 1.001f;    // squared distances up to which a triangle is as near, for all that float tells
constexpr float k_flat = 0.0025f;  // squared height over squared distance of what is seen too much from the side

/// From a point to the nearest point of a triangle.
struct ToTriangle {
    V3 offset;
    F distance_sq;
    F height;     // of the point above the plane, times the normal's length
    F normal_sq;  // squared length of that normal
};

HWY_INLINE V3 negated(const V3& v) { return {hn::Neg(v.x), hn::Neg(v.y), hn::Neg(v.z)}; }

HWY_INLINE V3 to_segment(const V3& from, const V3& along, F length_sq)
{
    const F t = hn::Div(hn::Neg(dot(from, along)), hn::Max(length_sq, set(1e-30f)));
    const F clamped = hn::Min(hn::Max(t, hn::Zero(df)), set(1.f));
    return {mul_add(clamped, along.x, from.x), mul_add(clamped, along.y, from.y), mul_add(clamped, along.z, from.z)};
}

/// a, b, c: corners, from the point.
HWY_INLINE ToTriangle to_triangle(const V3& a, const V3& b, const V3& c)
{
    const V3 ab = minus(b, a), ac = minus(c, a), bc = minus(c, b), ap = negated(a);
    const F bb = dot(ab, ab), cc = dot(ac, ac);
    ToTriangle out;
    const V3 n = cross(ab, ac);
    out.normal_sq = dot(n, n);
    out.height = dot(ap, n);
    const F v_n = dot(cross(ap, ac), n), w_n = dot(cross(ab, ap), n);
    const F inverse = hn::Div(set(1.f), hn::Max(out.normal_sq, set(1e-36f)));
    const F v = hn::Mul(v_n, inverse), w = hn::Mul(w_n, inverse), u = hn::Sub(hn::Sub(set(1.f), v), w);
    const M has_area = hn::Gt(out.normal_sq, hn::Max(hn::Mul(hn::Mul(bb, cc), set(1e-10f)), set(1e-34f)));
    const M above = hn::And(has_area, hn::Ge(hn::Min(hn::Min(u, v), w), hn::Zero(df)));
    V3 best = to_segment(a, ab, bb);
    F best_sq = dot(best, best);
    const auto offer = [&](const V3& offset) {
        const F d = dot(offset, offset);
        const M nearer = hn::Lt(d, best_sq);
        best_sq = blend(nearer, d, best_sq);
        best = blend(nearer, offset, best);
    };
    offer(to_segment(a, ac, cc));
    offer(to_segment(b, bc, dot(bc, bc)));
    const V3 face{mul_add(v, ab.x, mul_add(w, ac.x, a.x)), mul_add(v, ab.y, mul_add(w, ac.y, a.y)),
                  mul_add(v, ab.z, mul_add(w, ac.z, a.z))};
    out.offset = blend(above, face, best);
    out.distance_sq = blend(above, dot(face, face), best_sq);
    return out;
}

/// The nearest so far of one point, and what those that are as near within rounding say of the side.
struct NearestEntry {
    float distance_sq = INFINITY;
    Vec3f offset{};  // from the point to it
    std::int32_t entry = -1;
    std::uint32_t sides = 0;
};

class Hierarchy {
public:
    explicit Hierarchy(const ModelView& model)
        : model_(model), arrays_(model.distance), levels_(model::hierarchy_levels(model.distance.header.entries))
    {
        const float size = model.header.sphere[3];
        tie_ = 4e-12f * size * size;
        triangles_ = static_cast<std::uint32_t>(model.triangle_part.size());
    }

    /// One point. nearest.distance_sq: what is farther is not looked for.
    HWY_NOINLINE void search(Vec3f p, NearestEntry& nearest) const
    {
        struct Waiting {
            float distance_sq;
            std::uint32_t level, node;  // in its level
        };
        Waiting stack[model::k_max_hierarchy_levels * k_hierarchy_width];
        std::size_t size = 0;
        if (arrays_.groups.empty()) return;
        stack[size++] = {0.f, 0, 0};
        HWY_ALIGN float distance_sq[k_row];
        while (size > 0) {
            const Waiting at = stack[--size];
            const float reach = tie_above(nearest.distance_sq);
            if (at.distance_sq > reach) continue;
            if (at.level == levels_.count) {
                visit_leaves(p, at.node, reach, nearest);
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
    }

    /// Squared distances up to which a triangle is as near, for all that float tells.
    float tie_above(float distance_sq) const { return distance_sq * k_tie + tie_; }

protected:
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

    /// Leaves of a group, side by side.
    struct Cylinders {
        HWY_ALIGN float centre[3][k_row];
        HWY_ALIGN float axis[3][k_row];
        HWY_ALIGN float height[k_row], radius[k_row];
    };
    static HWY_INLINE F codes(const std::uint8_t* at)
    {
        return to_float(hn::PromoteTo(di, hn::LoadU(hn::Rebind<std::uint8_t, DF>(), at)));
    }
    HWY_INLINE Cylinders decode(const model::HierarchyGroup& g) const
    {
        Cylinders out;
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            for (int k = 0; k < 3; ++k)
                hn::Store(mul_add(codes(g.centre[k] + i), set(g.step), set(g.origin[k])), df, out.centre[k] + i);
            const F one = set(1.f), unit = set(2.f / 255.f);
            const F x = hn::Sub(hn::Mul(codes(g.axis[0] + i), unit), one), y = hn::Sub(hn::Mul(codes(g.axis[1] + i), unit), one);
            const F z = hn::Sub(hn::Sub(one, hn::Abs(x)), hn::Abs(y)), fold = hn::Max(hn::Neg(z), hn::Zero(df));
            const V3 n{hn::Sub(x, hn::CopySign(fold, x)), hn::Sub(y, hn::CopySign(fold, y)), z};
            const F inverse = hn::Div(one, hn::Sqrt(dot(n, n)));
            hn::Store(hn::Mul(n.x, inverse), df, out.axis[0] + i);
            hn::Store(hn::Mul(n.y, inverse), df, out.axis[1] + i);
            hn::Store(hn::Mul(n.z, inverse), df, out.axis[2] + i);
            hn::Store(hn::Mul(codes(g.height + i), set(g.height_step)), df, out.height + i);
            hn::Store(hn::Mul(codes(g.radius + i), set(g.radius_step)), df, out.radius + i);
        }
        return out;
    }
    /// Squared distance to cylinders; 0 within them.
    static HWY_INLINE F to_cylinder(const V3& from_centre, const V3& axis, F height, F radius)
    {
        const F along = dot(from_centre, axis), zero = hn::Zero(df);
        const F beside = hn::Sqrt(hn::Max(hn::Sub(dot(from_centre, from_centre), hn::Mul(along, along)), zero));
        const F up = hn::Max(hn::Sub(hn::Abs(along), height), zero), out = hn::Max(hn::Sub(beside, radius), zero);
        return mul_add(up, up, hn::Mul(out, out));
    }
    std::uint32_t leaves_of(std::uint32_t group) const
    {
        return std::min<std::uint32_t>(k_hierarchy_width, model::leaf_count(arrays_.header.entries) - group * k_hierarchy_width);
    }

    /// Leaves of a group, the nearest two at a time.
    HWY_INLINE void visit_leaves(Vec3f p, std::uint32_t group, float limit, NearestEntry& nearest) const
    {
        const std::uint32_t first = group * k_hierarchy_width;
        const Cylinders cylinders = decode(arrays_.groups[group]);
        HWY_ALIGN float distance_sq[k_row];
        std::uint32_t near = 0;
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const V3 d{hn::Sub(set(p.x), hn::Load(df, cylinders.centre[0] + i)),
                       hn::Sub(set(p.y), hn::Load(df, cylinders.centre[1] + i)),
                       hn::Sub(set(p.z), hn::Load(df, cylinders.centre[2] + i))};
            const V3 axis{hn::Load(df, cylinders.axis[0] + i), hn::Load(df, cylinders.axis[1] + i),
                          hn::Load(df, cylinders.axis[2] + i)};
            const F d_sq = to_cylinder(d, axis, hn::Load(df, cylinders.height + i), hn::Load(df, cylinders.radius + i));
            hn::Store(d_sq, df, distance_sq + i);
            near |= bits(hn::Le(d_sq, set(limit))) << i;
        }
        near &= (1u << leaves_of(group)) - 1;
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
            const float reach = tie_above(nearest.distance_sq);
            if (best_sq > reach) return;
            const bool two = second_sq <= reach;
            near &= ~(1u << best);
            if (two) near &= ~(1u << second);
            measure(p, first + best, two ? first + second : first + best, nearest);
        }
    }

    const float* corner(std::uint32_t entry, std::uint32_t k) const
    {
        if (entry >= triangles_) return model_.pieces.data() + 9 * std::size_t{entry - triangles_} + 3 * k;
        return model_.vertices.data() + 3 * std::size_t{model::triangle_vertex(model_, entry, k)};
    }
    std::uint32_t entry_at(std::size_t i) const
    {
        return arrays_.entries16.empty() ? arrays_.entries32[i] : arrays_.entries16[i];
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
    HWY_NOINLINE void measure(Vec3f p, std::uint32_t leaf, std::uint32_t other, NearestEntry& nearest) const
    {
        Corners corners;
        std::uint32_t entries[k_row];
        for (std::size_t i = 0; i < k_row; ++i) {
            entries[i] = entry_at((i < k_hierarchy_leaf ? leaf : other) * k_hierarchy_leaf + i % k_hierarchy_leaf);
            put_corners(entries[i], i, corners);
        }
        HWY_ALIGN float distance_sq[k_row], offset[3][k_row];
        std::uint32_t flat = 0, outside = 0;
        float least = INFINITY;
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            V3 v[3];
            for (int k = 0; k < 3; ++k) v[k] = minus(corner_lanes(corners, k, i), {set(p.x), set(p.y), set(p.z)});
            const ToTriangle t = to_triangle(v[0], v[1], v[2]);
            hn::Store(t.distance_sq, df, distance_sq + i);
            hn::Store(t.offset.x, df, offset[0] + i);
            hn::Store(t.offset.y, df, offset[1] + i);
            hn::Store(t.offset.z, df, offset[2] + i);
            flat |= bits(hn::Le(hn::Mul(t.height, t.height), hn::Mul(hn::Mul(set(k_flat), t.distance_sq), t.normal_sq))) << i;
            outside |= bits(hn::Gt(t.height, hn::Zero(df))) << i;
            least = std::min(least, hn::GetLane(hn::MinOfLanes(df, t.distance_sq)));
        }
        const float reach = tie_above(std::min(least, nearest.distance_sq));
        std::uint32_t level = 0;
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df))
            level |= bits(hn::Le(hn::Load(df, distance_sq + i), set(reach))) << i;
        if (level == 0) return;
        if (tie_above(least) < nearest.distance_sq) nearest.sides = 0;
        if ((level & flat) != 0) nearest.sides |= k_seen_unclear;
        if ((level & outside) != 0) nearest.sides |= k_seen_outside;
        if ((level & ~outside) != 0) nearest.sides |= k_seen_inside;
        if (!(least < nearest.distance_sq)) return;
        std::size_t i = 0;
        while (i + 1 < k_row && distance_sq[i] != least) ++i;
        nearest.distance_sq = least;
        nearest.entry = static_cast<std::int32_t>(entries[i]);
        nearest.offset = {offset[0][i], offset[1][i], offset[2][i]};
    }

    const ModelView& model_;
    const model::DistanceArrays<model::ArrayView>& arrays_;
    model::HierarchyLevels levels_;
    std::uint32_t triangles_;
    float tie_;
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
