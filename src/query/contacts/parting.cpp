// Two triangles meet at the translations of one interval. At its ends, seen along the direction, a corner of one is on the other
// or two sides cross. The first translation that no interval holds is reached by going from the end of one to the end of the
// next.
#include "parting.h"

#include "candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::query {
namespace {

constexpr double k_never = std::numeric_limits<double>::infinity();

double cross_xy(Vec3d u, Vec3d v) { return u.x * v.y - u.y * v.x; }
double norm_xy(Vec3d v) { return norm(Vec3d{v.x, v.y, 0}); }

class RangeOfPair {
public:
    RangeOfPair(const TriangleCorners& a, const TriangleCorners& b, double near) : a_(a), b_(b), near_(near) {}

    MeetingRange find()
    {
        for (int i = 0; i < 3; ++i) {
            double z = 0;
            if (is_below(a_, b_[i], z)) add(z - b_[i].z, {{b_[i].x, b_[i].y, z}, Feature::Face, Feature::Vertex, 0, i});
            if (is_below(b_, a_[i], z)) add(a_[i].z - z, {a_[i], Feature::Vertex, Feature::Face, i, 0});
            for (int j = 0; j < 3; ++j) cross_sides(i, j);
        }
        return range_;
    }

private:
    using Touch = MeetingRange::Touch;

    void add(double t, const Touch& touch)
    {
        range_.low = std::min(range_.low, t);
        if (!(t > range_.high)) return;
        range_.high = t;
        range_.last = touch;
    }

    /// The height of a triangle at a position. Edge-on triangles are met by their sides alone.
    [[nodiscard]] bool is_below(const TriangleCorners& t, Vec3d p, double& z) const
    {
        double turn[3];
        const double area = cross_xy(t.b - t.a, t.c - t.a);
        if (area == 0) return false;
        for (int k = 0; k < 3; ++k) {
            const Vec3d side = t[(k + 1) % 3] - t[k];
            turn[k] = cross_xy(side, p - t[k]);
            if ((area > 0 ? turn[k] : -turn[k]) < -near_ * norm_xy(side)) return false;
        }
        z = (turn[1] * t.a.z + turn[2] * t.b.z + turn[0] * t.c.z) / area;
        z = std::clamp(z, std::min({t.a.z, t.b.z, t.c.z}), std::max({t.a.z, t.b.z, t.c.z}));
        return true;
    }

    /// Side i of a, side j of b.
    void cross_sides(int i, int j)
    {
        const Vec3d p = a_[i], p_end = a_[(i + 1) % 3], q = b_[j], q_end = b_[(j + 1) % 3];
        const Vec3d d = p_end - p, e = q_end - q, w = q - p;
        const double length_d = norm_xy(d), length_e = norm_xy(e), turn = cross_xy(d, e);
        if (std::abs(turn) <= 1e-12 * length_d * length_e) {
            touch_side(p, d, q, {{}, Feature::Edge, Feature::Vertex, i, j});
            touch_side(p, d, q_end, {{}, Feature::Edge, Feature::Vertex, i, (j + 1) % 3});
            touch_side(q, e, p, {p, Feature::Vertex, Feature::Edge, i, j});
            touch_side(q, e, p_end, {p_end, Feature::Vertex, Feature::Edge, (i + 1) % 3, j});
            return;
        }
        const double s = cross_xy(w, e) / turn, t = cross_xy(w, d) / turn;
        if (std::abs(s - 0.5) * length_d > 0.5 * length_d + near_ || std::abs(t - 0.5) * length_e > 0.5 * length_e + near_)
            return;
        const double on_d = std::clamp(s, 0., 1.), on_e = std::clamp(t, 0., 1.);
        add(p.z + on_d * d.z - (q.z + on_e * e.z), {p + on_d * d, Feature::Edge, Feature::Edge, i, j});
    }

    /// A corner on a side that is parallel to its own, or is seen as a point. touch: of which triangle the corner is.
    void touch_side(Vec3d from, Vec3d d, Vec3d corner, Touch touch)
    {
        const bool is_of_a = touch.feature_a == Feature::Vertex;
        const auto meet = [&](Vec3d on_side) {
            touch.on_a = is_of_a ? corner : on_side;
            add(is_of_a ? corner.z - on_side.z : on_side.z - corner.z, touch);
        };
        const Vec3d w = corner - from;
        const double length = norm_xy(d);
        if (length <= near_) {
            if (norm_xy(w) > near_ + length) return;
            meet(from);
            meet(from + d);
            return;
        }
        const double along = (w.x * d.x + w.y * d.y) / length;
        if (std::abs(cross_xy(d, w)) > near_ * length || along < -near_ || along > length + near_) return;
        meet(from + std::clamp(along / length, 0., 1.) * d);
    }

    const TriangleCorners &a_, &b_;
    const double near_;
    MeetingRange range_{k_never, -k_never, {}};
};

}  // namespace

MeetingRange meeting_range(const TriangleCorners& a, const TriangleCorners& b, double near) noexcept
{
    return RangeOfPair(a, b, near).find();
}

PartingSearch::PartingSearch(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a, Vec3d direction,
                             SeparatingWorkspace& workspace) noexcept
    : a_{a, workspace.a_, a.columns().corners.size(), a.columns().leaves.size()},
      b_{b, workspace.b_, b.columns().corners.size(), b.columns().leaves.size()},
      b_in_a_(b_in_a),
      direction_(direction)
{
    const double sizes = norm(size(a.box())) + norm(size(b.box()));
    near_ = 1e-12 * sizes;
    gap_ = 2e-9 * sizes;
    const Vec3d beside = std::abs(direction.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d u = normalized(cross(beside, direction));
    const Vec3d axes[3] = {u, cross(direction, u), direction};
    const Vec3d middle = centre(a.box());
    Affine from_middle{};
    from_middle.shift = -middle;
    prepare(a_, from_middle, axes);
    prepare(b_, {b_in_a.linear, b_in_a.shift - middle}, axes);
    find_pieces(a_);
    find_pieces(b_);
}

void PartingSearch::prepare(Mesh& m, const Affine& map, const Vec3d (&axes)[3])
{
    for (std::size_t i = 0; i < m.tree.points(); ++i) {
        const Vec3d p = apply(map, m.tree.point(i));
        m.space.points[i] = {dot(axes[0], p), dot(axes[1], p), dot(axes[2], p)};
    }
    constexpr Range k_none{{k_never, k_never, k_never}, {-k_never, -k_never, -k_never}};
    const auto hold = [](Range& r, Vec3d lo, Vec3d hi) {
        for (int k = 0; k < 3; ++k) {
            r.lo[k] = std::min(r.lo[k], lo[k]);
            r.hi[k] = std::max(r.hi[k], hi[k]);
        }
    };
    std::fill_n(m.space.groups.begin(), m.groups, k_none);
    const std::span<const std::uint32_t> numbers = m.tree.columns().numbers;
    for (std::size_t leaf = 0; leaf < m.leaves; ++leaf) {
        Range& r = m.space.leaves[leaf];
        r = k_none;
        const std::size_t end = std::min((leaf + 1) * TriangleTree::k_leaf, m.tree.size());
        for (std::size_t slot = leaf * TriangleTree::k_leaf; slot < end; ++slot)
            for (const std::uint32_t v : m.tree.triangle(numbers[slot])) hold(r, m.space.points[v], m.space.points[v]);
        hold(m.space.groups[leaf / TriangleTree::k_group], r.lo, r.hi);
    }
}

void PartingSearch::find_pieces(Mesh& m)
{
    SeparatingWorkspace::Side& s = m.space;
    s.piece_count = 0;
    std::fill_n(s.is_reached.begin(), m.tree.size(), std::uint8_t{0});
    for (std::uint32_t first = 0; first < m.tree.size(); ++first) {
        if (s.is_reached[first] != 0) continue;
        s.pieces[s.piece_count++] = m.tree.triangle(first)[0];
        std::size_t count = 0;
        s.stack[count++] = first;
        s.is_reached[first] = 1;
        while (count > 0) {
            const std::uint32_t t = s.stack[--count];
            for (std::uint32_t k = 0; k < 3; ++k)
                if (const std::uint32_t next = m.tree.twin(3 * t + k) / 3; s.is_reached[next] == 0) {
                    s.is_reached[next] = 1;
                    s.stack[count++] = next;
                }
        }
    }
}

TriangleCorners PartingSearch::corners(const Mesh& m, std::uint32_t t) const
{
    const ProbeTriangle& v = m.tree.triangle(t);
    return {m.space.points[v[0]], m.space.points[v[1]], m.space.points[v[2]]};
}

template <class Test, class Visit>
void PartingSearch::each_pair(Test&& test, Visit&& visit)
{
    const auto meets = [&](const Range& a, const Range& b) {
        return a.lo.x <= b.hi.x + near_ && b.lo.x <= a.hi.x + near_ && a.lo.y <= b.hi.y + near_ && b.lo.y <= a.hi.y + near_ &&
               test(a.lo.z - b.hi.z, a.hi.z - b.lo.z);
    };
    const auto numbers_a = a_.tree.columns().numbers, numbers_b = b_.tree.columns().numbers;
    const auto box_of = [](const TriangleCorners& t) {
        Range r{t.a, t.a};
        for (const Vec3d p : {t.b, t.c})
            for (int k = 0; k < 3; ++k) {
                r.lo[k] = std::min(r.lo[k], p[k]);
                r.hi[k] = std::max(r.hi[k], p[k]);
            }
        return r;
    };
    constexpr std::size_t k_leaf = TriangleTree::k_leaf, k_group = TriangleTree::k_group;
    const auto visit_leaves = [&](std::size_t i, std::size_t j) {
        const Range &leaf_a = a_.space.leaves[i], &leaf_b = b_.space.leaves[j];
        for (std::size_t s = i * k_leaf; s < std::min((i + 1) * k_leaf, a_.tree.size()); ++s) {
            const TriangleCorners a = corners(a_, numbers_a[s]);
            const Range range_a = box_of(a);
            if (!meets(range_a, leaf_b)) continue;
            for (std::size_t t = j * k_leaf; t < std::min((j + 1) * k_leaf, b_.tree.size()); ++t) {
                const TriangleCorners b = corners(b_, numbers_b[t]);
                if (const Range range_b = box_of(b); meets(range_a, range_b) && meets(leaf_a, range_b)) visit(a, b);
            }
        }
    };
    for (std::size_t ga = 0; ga < a_.groups; ++ga)
        for (std::size_t gb = 0; gb < b_.groups; ++gb) {
            if (!meets(a_.space.groups[ga], b_.space.groups[gb])) continue;
            for (std::size_t i = ga * k_group; i < std::min((ga + 1) * k_group, a_.leaves); ++i) {
                if (!meets(a_.space.leaves[i], b_.space.groups[gb])) continue;
                for (std::size_t j = gb * k_group; j < std::min((gb + 1) * k_group, b_.leaves); ++j)
                    if (meets(a_.space.leaves[i], b_.space.leaves[j])) visit_leaves(i, j);
            }
        }
}

void PartingSearch::leave_meetings(double& t)
{
    for (double before = -1; t > before;) {
        before = t;
        each_pair([&](double low, double high) { return high > t && low <= t + gap_; },
                  [&](const TriangleCorners& a, const TriangleCorners& b) {
                      const MeetingRange range = meeting_range(a, b, near_);
                      if (range.low <= t + gap_ && range.high > t) t = range.high;
                  });
    }
}

double PartingSearch::next_meeting(double t)
{
    double next = k_never;
    each_pair([&](double low, double high) { return low < next && high > t; },
              [&](const TriangleCorners& a, const TriangleCorners& b) {
                  const MeetingRange range = meeting_range(a, b, near_);
                  if (range.low > t && range.low < next) next = range.low;
              });
    return next;
}

bool PartingSearch::has_inside(const Mesh& outer, Vec3d p) const
{
    const auto numbers = outer.tree.columns().numbers;
    int winding = 0;
    for (std::size_t leaf = 0; leaf < outer.leaves; ++leaf) {
        const Range& r = outer.space.leaves[leaf];
        if (p.x < r.lo.x || p.x > r.hi.x || p.y < r.lo.y || p.y > r.hi.y || r.hi.z < p.z) continue;
        const std::size_t end = std::min((leaf + 1) * TriangleTree::k_leaf, outer.tree.size());
        for (std::size_t slot = leaf * TriangleTree::k_leaf; slot < end; ++slot) {
            const TriangleCorners t = corners(outer, numbers[slot]);
            // Half-open sides: of triangles about an edge or a corner that is exactly above one is taken.
            int turns = 0;
            for (int k = 0; k < 3; ++k) {
                const Vec3d from = t[k], to = t[(k + 1) % 3];
                const bool rises = from.y <= p.y && p.y < to.y, falls = to.y <= p.y && p.y < from.y;
                if (!rises && !falls) continue;
                const int side = orient2d({from.x, from.y}, {to.x, to.y}, {p.x, p.y});
                turns += rises && side > 0 ? 1 : (falls && side < 0 ? -1 : 0);
            }
            if (turns == 0) continue;
            const double area = cross_xy(t.b - t.a, t.c - t.a);
            const double z =
                t.a.z + (cross_xy(p - t.a, t.c - t.a) * (t.b.z - t.a.z) + cross_xy(t.b - t.a, p - t.a) * (t.c.z - t.a.z)) / area;
            if (z > p.z) winding += turns;
        }
    }
    return winding > 0;
}

bool PartingSearch::is_contained(double t)
{
    const Vec3d by{0, 0, t};
    for (const std::uint32_t i : std::span(b_.space.pieces).first(b_.space.piece_count))
        if (has_inside(a_, b_.space.points[i] + by)) return true;
    for (const std::uint32_t i : std::span(a_.space.pieces).first(a_.space.piece_count))
        if (has_inside(b_, a_.space.points[i] - by)) return true;
    return false;
}

bool PartingSearch::is_free(double t) const
{
    struct Check {
        const TriangleTree &a, &b;
        Affine move;
        bool meets = false;
    } check{a_.tree, b_.tree, {b_in_a_.linear, b_in_a_.shift + t * direction_}};
    const CandidateJob job(check.a, check.b, check.move);
    find_candidates(
        job,
        [](void* context, std::span<const TrianglePair> pairs) noexcept {
            Check& c = *static_cast<Check*>(context);
            for (const TrianglePair& pair : pairs) {
                const ProbeTriangle &v = c.a.triangle(pair.a), &w = c.b.triangle(pair.b);
                c.meets =
                    crossing_of({c.a.point(v[0]), c.a.point(v[1]), c.a.point(v[2])},
                                {apply(c.move, c.b.point(w[0])), apply(c.move, c.b.point(w[1])), apply(c.move, c.b.point(w[2]))})
                        .meets();
                if (c.meets) return false;
            }
            return true;
        },
        &check);
    return !check.meets;
}

bool PartingSearch::run(double& distance) noexcept
{
    constexpr int k_max_gaps = 100000, k_max_doubts = 16;
    double t = 0;
    int doubts = 0;
    slack_ = 8 * near_;
    for (int gap = 0; gap < k_max_gaps; ++gap) {
        leave_meetings(t);
        if (is_contained(t + 0.5 * gap_)) {
            t = next_meeting(t);
            if (!(t < k_never)) return false;
            continue;
        }
        if (is_free(t + 0.5 * gap_)) {
            distance = t;
            return true;
        }
        // Exact predicates see triangles meet that were rounded away.
        t += gap_;
        slack_ += gap_;
        if (++doubts == k_max_doubts) return false;
    }
    return false;
}

}  // namespace sqmap::query
