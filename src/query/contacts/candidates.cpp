// Two trees of boxes against each other (S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH 1996, with boxes along the axes
// instead), sixteen boxes or triangles at a time in float. Everything is tested with a margin for what float rounds, so no pair
// that meets is lost; pairs that remain are decided elsewhere, exactly.
#include "candidates.h"

#include <algorithm>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "query/contacts/candidates.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "query/contacts/box_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sqmap::query::HWY_NAMESPACE {
namespace {

using namespace sqmap::HWY_NAMESPACE;

/// Planes of triangles: height of p = normal . p - offset, normal = e1 x e2.
struct Plane {
    V3 normal;
    F offset, sides, product;  // |e1| + |e2| and |e1| |e2|, at least

    static HWY_INLINE Plane of(const V3& a, const V3& b, const V3& c)
    {
        const V3 e1 = minus(b, a), e2 = minus(c, a);
        const F s1 = sum_of_sizes(e1), s2 = sum_of_sizes(e2);
        const V3 normal = cross(e1, e2);
        return {normal, dot(normal, a), hn::Add(s1, s2), hn::Mul(s1, s2)};
    }
};

/// Heights over a plane up to which float is not sure of the side. Moving every position by at most `error` changes a height by
/// at most 2 error (|e1||e2| + |e1||w| + |e2||w|), w from the plane's corner to p; rounding adds less than half of it, as error
/// is 1e-6 of all sizes: positions' products with the normal, 2 x 1.8e-7 of |e1||e2| and the sizes, and the normal, 6e-7 of it.
struct Sides {
    F low, high;

    /// width: of a box that holds the triangles of both leaves, all sides together.
    HWY_INLINE Sides(F offset, F sides, F product, F error_three, F width)
    {
        const F bound = hn::Mul(error_three, mul_add(sides, width, product));
        low = hn::Sub(offset, bound);
        high = hn::Add(offset, bound);
    }
    /// True where all three are surely on one side.
    HWY_INLINE M are_beside(const V3& normal, const V3& p, const V3& q, const V3& r) const
    {
        const F sp = dot(normal, p), sq = dot(normal, q), sr = dot(normal, r);
        return hn::Or(hn::Gt(hn::Min(sp, hn::Min(sq, sr)), high), hn::Lt(hn::Max(sp, hn::Max(sq, sr)), low));
    }
};

/// The slab of one leaf, wider by what positions of the other body may be off.
struct Slab {
    float normal[3] = {}, lo = 0, hi = 0;

    Slab() = default;
    Slab(const TriangleTree::SlabRow& row, std::size_t i, float margin)
        : normal{row.normal[0][i], row.normal[1][i], row.normal[2][i]}, lo(row.lo[i] - margin), hi(row.hi[i] + margin)
    {
    }
};
/// Bit t: triangle t is not beside the slab.
HWY_INLINE std::uint32_t in_slab(const CornerRow& corners, const Slab& slab)
{
    const V3 normal = set3(slab.normal);
    const F lo = set(slab.lo), hi = set(slab.hi);
    std::uint32_t beside = 0;
    for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
        const F p = dot(normal, at(corners.at[0], i)), q = dot(normal, at(corners.at[1], i)),
                r = dot(normal, at(corners.at[2], i));
        const M above = hn::Gt(hn::Min(p, hn::Min(q, r)), hi), below = hn::Lt(hn::Max(p, hn::Max(q, r)), lo);
        beside |= static_cast<std::uint32_t>(bits_of(hn::Or(above, below))) << i;
    }
    return ~beside & first_bits(k_row);
}

/// Boxes and planes of the triangles of a leaf.
struct LeafTests {
    BoxRow boxes;
    HWY_ALIGN_MAX float normal[3][k_row], offset[k_row], sides[k_row], product[k_row];

    /// Boxes larger by the margin.
    HWY_INLINE void put_boxes(const CornerRow& corners, F margin)
    {
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const V3 p = at(corners.at[0], i), q = at(corners.at[1], i), r = at(corners.at[2], i);
            const auto least = [&](F x, F y, F z) HWY_ATTR { return hn::Sub(hn::Min(x, hn::Min(y, z)), margin); };
            const auto greatest = [&](F x, F y, F z) HWY_ATTR { return hn::Add(hn::Max(x, hn::Max(y, z)), margin); };
            store({least(p.x, q.x, r.x), least(p.y, q.y, r.y), least(p.z, q.z, r.z)}, boxes.lo, i);
            store({greatest(p.x, q.x, r.x), greatest(p.y, q.y, r.y), greatest(p.z, q.z, r.z)}, boxes.hi, i);
        }
    }
    HWY_INLINE void put_planes(const CornerRow& corners)
    {
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const Plane plane = Plane::of(at(corners.at[0], i), at(corners.at[1], i), at(corners.at[2], i));
            store(plane.normal, normal, i);
            hn::StoreU(plane.offset, df, offset + i);
            hn::StoreU(plane.sides, df, sides + i);
            hn::StoreU(plane.product, df, product + i);
        }
    }
};

/// A leaf of either body, and which of its triangles the other leaf may meet.
struct NearLeaf {
    const CornerRow& corners;
    const LeafTests& tests;
    std::uint32_t near;
};

/// Triangles of a leaf of b, moved.
struct MovedLeaf {
    CornerRow corners;
    LeafTests tests;
    BoxRow all;  // one box, in its first element
    Slab slab;
};

class CandidateSearch {
public:
    CandidateSearch(const CandidateJob& job, TakePairs take, void* context) : job_(job), take_(take), context_(context) {}

    void run()
    {
        const OneBox box_a(job_.box_a);
        for (std::size_t row = 0; row < job_.b.groups.size() && !ended_; ++row) {
            BoxRow moved;
            move_boxes(job_, job_.b.groups[row], moved);
            const std::uint32_t near = overlapping(moved, box_a) & first_bits(job_.groups_b - row * k_row);
            each_bit(near, [&](std::size_t i) HWY_ATTR {
                if (!ended_) visit_group(row * k_row + i, OneBox(moved, i));
            });
        }
        flush();
    }

private:
    static constexpr std::size_t k_buffer = 512;

    /// A group of b's leaves.
    HWY_NOINLINE void visit_group(std::size_t group, const OneBox& box)
    {
        is_moved_ = 0;
        bool has_boxes = false;
        for (std::size_t row = 0; row < job_.a.groups.size() && !ended_; ++row) {
            const std::uint32_t near = overlapping(job_.a.groups[row], box) & first_bits(job_.groups_a - row * k_row);
            if (near == 0) continue;
            if (!has_boxes) move_boxes(job_, job_.b.leaves[group], leaf_boxes_);
            has_boxes = true;
            each_bit(near, [&](std::size_t i) HWY_ATTR {
                const std::size_t other = row * k_row + i;
                const BoxRow& leaves = job_.a.leaves[other];
                const std::uint32_t near_a = overlapping(leaves, box) & first_bits(job_.leaves_a - other * k_row);
                if (near_a == 0) return;
                const std::uint32_t near_b =
                    overlapping(leaf_boxes_, OneBox(job_.a.groups[row], i)) & first_bits(job_.leaves_b - group * k_row);
                each_bit(near_b, [&](std::size_t b) HWY_ATTR {
                    const std::uint32_t boxes = near_a & overlapping(leaves, OneBox(leaf_boxes_, b));
                    if (boxes == 0) return;
                    each_bit(boxes & ~beside_slabs(job_.a.slabs[other], b),
                             [&](std::size_t a) { visit_leaves(other, a, group, b); });
                });
            });
        }
    }

    /// Bit i: box b of the leaves that are visited is beside slab i of the row.
    HWY_INLINE std::uint32_t beside_slabs(const TriangleTree::SlabRow& slabs, std::size_t b) const
    {
        V3 middle, extent;
        F* const m[] = {&middle.x, &middle.y, &middle.z};
        F* const e[] = {&extent.x, &extent.y, &extent.z};
        for (int k = 0; k < 3; ++k) {
            const float lo = leaf_boxes_.lo[k][b], hi = leaf_boxes_.hi[k][b];
            *m[k] = set(0.5f * (lo + hi));
            *e[k] = set(0.5f * (hi - lo));
        }
        std::uint32_t bits = 0;
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const V3 normal = at(slabs.normal, i);
            const F height = dot(normal, middle), reach = dot({hn::Abs(normal.x), hn::Abs(normal.y), hn::Abs(normal.z)}, extent);
            const M above = hn::Gt(hn::Sub(height, reach), hn::LoadU(df, slabs.hi + i)),
                    below = hn::Lt(hn::Add(height, reach), hn::LoadU(df, slabs.lo + i));
            bits |= static_cast<std::uint32_t>(bits_of(hn::Or(above, below))) << i;
        }
        return bits;
    }

    const MovedLeaf& moved_leaf(std::size_t group, std::size_t i)
    {
        MovedLeaf& leaf = moved_[i];
        if ((is_moved_ >> i & 1u) != 0) return leaf;
        is_moved_ |= 1u << i;
        move_leaf(job_.b.corners[group * k_row + i], leaf);
        move_slab(Slab(job_.b.slabs[group], i, job_.margin), leaf.slab);
        return leaf;
    }
    void move_slab(const Slab& slab, Slab& to) const
    {
        float along = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const float* r = job_.rotation + 3 * k;
            to.normal[k] = r[0] * slab.normal[0] + r[1] * slab.normal[1] + r[2] * slab.normal[2];
            along += to.normal[k] * job_.shift[k];
        }
        to.lo = slab.lo + along;
        to.hi = slab.hi + along;
    }
    HWY_NOINLINE void move_leaf(const CornerRow& from, MovedLeaf& to) const
    {
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df))
            for (std::size_t k = 0; k < 3; ++k) store(moved(job_, at(from.at[k], i)), to.corners.at[k], i);
        to.tests.put_boxes(to.corners, set(job_.margin));
        to.tests.put_planes(to.corners);
        for (int k = 0; k < 3; ++k) {
            F least = hn::LoadU(df, to.tests.boxes.lo[k]), greatest = hn::LoadU(df, to.tests.boxes.hi[k]);
            for (std::size_t i = hn::Lanes(df); i < k_row; i += hn::Lanes(df)) {
                least = hn::Min(least, hn::LoadU(df, to.tests.boxes.lo[k] + i));
                greatest = hn::Max(greatest, hn::LoadU(df, to.tests.boxes.hi[k] + i));
            }
            to.all.lo[k][0] = hn::GetLane(hn::MinOfLanes(df, least));
            to.all.hi[k][0] = hn::GetLane(hn::MaxOfLanes(df, greatest));
        }
    }

    /// Triangles of a leaf of a against those of a leaf of b.
    HWY_NOINLINE void visit_leaves(std::size_t group_a, std::size_t a, std::size_t group_b, std::size_t b)
    {
        const MovedLeaf& other = moved_leaf(group_b, b);
        const std::size_t leaf_a = group_a * k_row + a, leaf_b = group_b * k_row + b;
        std::uint32_t near_b =
            overlapping(other.tests.boxes, OneBox(job_.a.leaves[group_a], a)) & first_bits(job_.triangles_b - leaf_b * k_row);
        if (near_b == 0) return;
        near_b &= in_slab(other.corners, Slab(job_.a.slabs[group_a], a, job_.margin));
        if (near_b == 0) return;
        const CornerRow& corners = job_.a.corners[leaf_a];
        std::uint32_t near_a = in_slab(corners, other.slab) & first_bits(job_.triangles_a - leaf_a * k_row);
        if (near_a == 0) return;
        LeafTests tests;
        tests.put_boxes(corners, set(0));
        near_a &= overlapping(tests.boxes, OneBox(other.all, 0));
        if (near_a == 0) return;
        tests.put_planes(corners);
        const float width = joint_width(job_.a.leaves[group_a], a, other.all);
        const NearLeaf of_a{corners, tests, near_a}, of_b{other.corners, other.tests, near_b};
        // The smaller side one by one, the other in the lanes; pairs are handed over in the same order either way.
        std::uint32_t pairs[k_row];
        if (std::popcount(near_b) <= std::popcount(near_a)) {
            compare(of_a, of_b, width, pairs);
        } else {
            std::uint32_t turned[k_row];
            compare(of_b, of_a, width, turned);
            each_bit(near_b, [&](std::size_t t) { pairs[t] = 0; });
            each_bit(near_a, [&](std::size_t s) { each_bit(turned[s], [&](std::size_t t) { pairs[t] |= 1u << s; }); });
        }
        each_bit(near_b,
                 [&](std::size_t t) { each_bit(pairs[t], [&](std::size_t s) { add(leaf_a * k_row + s, leaf_b * k_row + t); }); });
    }

    /// found[t], of each near triangle t of the second leaf: which near ones of the first it may meet.
    HWY_NOINLINE void compare(const NearLeaf& first, const NearLeaf& second, float joint_width,
                              std::uint32_t (&found)[k_row]) const
    {
        const F error = set(3 * job_.error), width = set(joint_width);
        each_bit(second.near, [&](std::size_t t) { found[t] = 0; });
        for (std::size_t i = 0; i < k_row; i += hn::Lanes(df)) {
            const std::uint32_t near = first.near >> i & first_bits(hn::Lanes(df));
            if (near == 0) continue;
            const LeafTests &f = first.tests, &s = second.tests;
            const V3 p = at(first.corners.at[0], i), q = at(first.corners.at[1], i), r = at(first.corners.at[2], i);
            const V3 lo = at(f.boxes.lo, i), hi = at(f.boxes.hi, i), normal = at(f.normal, i);
            const Sides beside(hn::LoadU(df, f.offset + i), hn::LoadU(df, f.sides + i), hn::LoadU(df, f.product + i), error,
                               width);
            each_bit(second.near, [&](std::size_t t) HWY_ATTR {
                M left = overlapping(lo, hi, OneBox(s.boxes, t));
                if ((bits_of(left) & near) == 0) return;
                if (job_.has_planes) {
                    const auto corner = [&](std::size_t k) HWY_ATTR {
                        const auto& c = second.corners.at[k];
                        return V3{set(c[0][t]), set(c[1][t]), set(c[2][t])};
                    };
                    left = hn::AndNot(beside.are_beside(normal, corner(0), corner(1), corner(2)), left);
                    if ((bits_of(left) & near) == 0) return;
                    const Sides other(set(s.offset[t]), set(s.sides[t]), set(s.product[t]), error, width);
                    left = hn::AndNot(other.are_beside({set(s.normal[0][t]), set(s.normal[1][t]), set(s.normal[2][t])}, p, q, r),
                                      left);
                }
                found[t] |= (static_cast<std::uint32_t>(bits_of(left)) & near) << i;
            });
        }
    }

    /// The sides of the box about two boxes, all together; the boxes hold what rounding takes already.
    static float joint_width(const BoxRow& row, std::size_t i, const BoxRow& other)
    {
        float sum = 0;
        for (int k = 0; k < 3; ++k) sum += std::max(row.hi[k][i], other.hi[k][0]) - std::min(row.lo[k][i], other.lo[k][0]);
        return 1.0001f * sum;
    }

    void add(std::size_t slot_a, std::size_t slot_b)
    {
        const TrianglePair pair{job_.a.numbers[slot_a], job_.b.numbers[slot_b]};
        fetch(job_.a, pair.a);
        fetch(job_.b, pair.b);
        buffer_[buffered_++] = pair;
        if (buffered_ == k_buffer) flush();
    }
    /// Judging a pair reads its triangles and their neighbours, from far memory where other bodies came between.
    static void fetch(const TriangleTree::Columns& tree, std::uint32_t triangle)
    {
        hwy::Prefetch(tree.triangles + triangle);
        hwy::Prefetch(tree.twins + 3 * std::size_t{triangle});
    }
    void flush()
    {
        if (buffered_ > 0 && !ended_) ended_ = !take_(context_, std::span(buffer_, buffered_));
        buffered_ = 0;
    }

    const CandidateJob& job_;
    TakePairs take_;
    void* context_;
    bool ended_ = false;
    std::size_t buffered_ = 0;
    std::uint32_t is_moved_ = 0;  // bit i: moved_[i] is of the group that is visited
    BoxRow leaf_boxes_;
    MovedLeaf moved_[k_row];
    TrianglePair buffer_[k_buffer];
};

}  // namespace

void search_candidates(const CandidateJob& job, TakePairs take, void* context) { CandidateSearch(job, take, context).run(); }

}  // namespace sqmap::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sqmap::query {

HWY_EXPORT(search_candidates);

PosedTrees::PosedTrees(const TriangleTree& tree_a, const TriangleTree& tree_b, const Affine& b_in_a) noexcept
    : a(tree_a.columns()),
      b(tree_b.columns()),
      leaves_a(a.corners.size()),
      leaves_b(b.corners.size()),
      triangles_a(tree_a.size()),
      triangles_b(tree_b.size()),
      between(apply(b_in_a, centre(tree_b.box())) - centre(tree_a.box())),
      radius_a(0.5 * norm(size(tree_a.box()))),
      radius_b(0.5 * norm(size(tree_b.box())))
{
    groups_a = a.leaves.size();
    groups_b = b.leaves.size();
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) rotation[3 * i + j] = static_cast<float>(b_in_a.linear.row[i][j]);
        shift[i] =
            static_cast<float>(std::clamp(between[i], -1e30, 1e30));  // farther away nothing is found by coordinates in float
    }
    // Seven roundings of at most 2^-24 of a position's size each lie between a point and its moved coordinate; a rotation that is
    // not one to the last bit adds as little.
    error = static_cast<float>(1e-6 * (2 * (radius_a + radius_b) + norm(between)));
    margin = 3 * error;
}

CandidateJob::CandidateJob(const TriangleTree& tree_a, const TriangleTree& tree_b, const Affine& b_in_a, double reach) noexcept
    : PosedTrees(tree_a, tree_b, b_in_a),
      is_far(!(norm(between) <= (radius_a + radius_b + reach) * (1 + 1e-6)))  // also where a number overflows
{
    const Vec3d middle_a = centre(tree_a.box());
    box_a = {cast<float>(tree_a.box().lo - middle_a), cast<float>(tree_a.box().hi - middle_a)};
    margin += static_cast<float>(reach * (1 + 1e-6));
    has_planes = reach == 0;
}

void find_candidates(const CandidateJob& job, TakePairs take, void* context) noexcept
{
    if (!job.is_far) HWY_DYNAMIC_DISPATCH(search_candidates)(job, take, context);
}

}  // namespace sqmap::query
#endif
