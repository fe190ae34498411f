// Vectors of points against the triangles of a candidate list: which is nearest, and what it says of the side.
#if defined(SQMAP_QUERY_EXACT_NEAREST_TRIANGLES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SQMAP_QUERY_EXACT_NEAREST_TRIANGLES_INL_H
#undef SQMAP_QUERY_EXACT_NEAREST_TRIANGLES_INL_H
#else
#define SQMAP_QUERY_EXACT_NEAREST_TRIANGLES_INL_H
#endif

#include "math/triangles-inl.h"
#include "model/candidate_lists.h"
#include "sqmap/model/model.h"

#include <bit>

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

/// The nearest triangles so far of a vector of points, and what those that are as near within rounding say of the side.
struct Nearest {
    F distance_sq;
    V3 offset;  // from the point to it
    I triangle;
    M outside, inside, unclear;
};

/// A list's triangles, read and prepared block after block.
class NearestTriangles {
public:
    explicit NearestTriangles(const model::ModelView& model) : model_(model)
    {
        const float size = model.header.sphere[3];
        tie_ = 4e-12f * size * size;
    }

    /// Reads a list, as a whole if there is space for it, and prepares it if one block holds it.
    void start(const model::CandidateList& list)
    {
        is_read_ = list.count <= k_read;
        is_short_ = list.count <= TriangleBlock::k_max;
        if (is_read_) read(list, 0, list.count);
        if (is_short_) prepare(triangle_, list.count);
    }
    /// The nearest of the list that was started.
    HWY_INLINE Nearest find(const V3& p, const model::CandidateList& list)
    {
        const F zero = hn::Zero(df);
        Nearest nearest{set(1e30f), {zero, zero, zero}, hn::Zero(di), none(), none(), none()};
        if (is_short_) {
            search(p, triangle_, list.count, nearest);
            return nearest;
        }
        for (std::uint32_t k = 0; k < list.count; k += TriangleBlock::k_max) {
            const auto n = std::min<std::uint32_t>(list.count - k, TriangleBlock::k_max);
            if (!is_read_) read(list, k, n);
            const std::int32_t* block = is_read_ ? triangle_ + k : triangle_;
            prepare(block, n);
            search(p, block, n, nearest);
        }
        return nearest;
    }

private:
    static constexpr std::size_t k_read = 1024;  // triangles of a list that are read at once

    /// Fills up the last vector.
    void read(const model::CandidateList& list, std::uint32_t first, std::uint32_t count)
    {
        list.read(first, count, triangle_);
        for (std::size_t k = 0; k < k_lanes; ++k) triangle_[count + k] = triangle_[count - 1];
    }

    HWY_NOINLINE void prepare(const std::int32_t* triangles, std::uint32_t count)
    {
        for (std::uint32_t k = 0; k < count; k += static_cast<std::uint32_t>(hn::Lanes(df))) {
            const I t = hn::LoadU(di, triangles + k), t3 = hn::Add(hn::Add(t, t), t);
            I corner[3];
            if (model_.triangles16.empty()) {
                for (int j = 0; j < 3; ++j) corner[j] = gather_word(model_.triangles32.data() + j, t3);
            } else {
                const I one_two = gather_pair(model_.triangles16.data(), t3);
                corner[0] = low(one_two);
                corner[1] = high(one_two);
                corner[2] = high(gather_pair(model_.triangles16.data() + 1, t3));
            }
            V3 v[3];
            for (int j = 0; j < 3; ++j) {
                const I at = hn::Add(hn::Add(corner[j], corner[j]), corner[j]);
                const float* vertices = model_.vertices.data();
                v[j] = {hn::GatherIndex(df, vertices, at), hn::GatherIndex(df, vertices + 1, at),
                        hn::GatherIndex(df, vertices + 2, at)};
            }
            block_.put(k, v[0], v[1], v[2]);
        }
    }

    /// Bounds first, without a branch; then what they leave.
    HWY_NOINLINE void search(const V3& p, const std::int32_t* triangles, std::uint32_t count, Nearest& nearest) const
    {
        HWY_ALIGN float lower[TriangleBlock::k_max][k_lanes];
        F upper = nearest.distance_sq;
        for (std::uint32_t k = 0; k < count; ++k) {
            const TriangleBlock::Position q = block_.position(k, p);
            hn::Store(q.lower_sq, df, lower[k]);
            // The foot, or else a corner.
            upper = hn::Min(upper, blend(q.above, q.lower_sq, dot(q.ap, q.ap)));
        }
        const F reach = tie_above(upper);
        std::uint64_t near = 0;
        for (std::uint32_t k = 0; k < count; ++k)
            near |= std::uint64_t{any(hn::Le(hn::Load(df, lower[k]), reach)) ? 1u : 0u} << k;
        Nearest best = nearest;
        for (; near != 0; near &= near - 1) {
            const auto k = static_cast<std::uint32_t>(std::countr_zero(near));
            const TriangleBlock::Position q = block_.position(k, p);
            const F tie = tie_above(best.distance_sq);
            F edge_sq;
            const V3 to_edge = block_.to_edges(k, q, edge_sq);
            const V3 to_face = block_.to_face(k, q);
            const V3 offset = blend(q.above, to_face, to_edge);
            const F distance_sq = blend(q.above, dot(to_face, to_face), edge_sq);
            // Only triangles near this point count, so that an answer does not depend on its neighbours.
            const M near_this = hn::Le(hn::Load(df, lower[k]), reach);
            const M level = hn::And(near_this, hn::Le(distance_sq, tie));
            // Clearly nearer than what was found before, whose side is forgotten.
            const M fresh = hn::And(near_this, hn::Lt(tie_above(distance_sq), best.distance_sq));
            // In the plane of a triangle, or without area, it says nothing of the side.
            const M in_plane = hn::Lt(hn::Mul(q.height, q.height), hn::Mul(set(0.0025f), distance_sq));
            const M outside = hn::Gt(q.height, hn::Zero(df));
            best.unclear = hn::Or(hn::AndNot(fresh, best.unclear), hn::And(level, in_plane));
            best.outside = hn::Or(hn::AndNot(fresh, best.outside), hn::And(level, outside));
            best.inside = hn::Or(hn::AndNot(fresh, best.inside), hn::AndNot(outside, level));
            // A tie goes to the triangle with the highest number, so the order of the list does not matter.
            const I triangle = set_int(triangles[k]);
            const M after = hn::RebindMask(df, hn::Gt(triangle, best.triangle));
            const M nearer = hn::And(
                near_this, hn::Or(hn::Lt(distance_sq, best.distance_sq), hn::And(hn::Eq(distance_sq, best.distance_sq), after)));
            best.distance_sq = blend(nearer, distance_sq, best.distance_sq);
            best.offset = blend(nearer, offset, best.offset);
            best.triangle = blend(nearer, triangle, best.triangle);
        }
        nearest = best;
    }

    /// Squared distances up to which a triangle is as near, for all that float tells.
    HWY_INLINE F tie_above(F distance_sq) const { return mul_add(distance_sq, set(1.02f), set(tie_)); }

    const model::ModelView& model_;
    float tie_;  // what rounding adds to a squared distance
    bool is_read_ = false, is_short_ = false;
    TriangleBlock block_;
    std::int32_t triangle_[k_read + k_lanes];  // of a list, or of a block of one that is longer
};

}  // namespace
}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
