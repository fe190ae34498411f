// The first touch of two bodies: the motion is halved while triangles are within its reach, down to pieces along which points
// move on chords; in these the elementary queries find the touch of triangles that are near each other.
#include "sqmap/query/first_touch.h"
#include "candidates.h"
#include "sqmap/query/clearance.h"
#include "sqmap/query/contacts.h"
#include "sqmap/query/swept.h"

#include "sqmap/math/rotation.h"

#include <algorithm>
#include <cmath>

namespace sqmap::query {
namespace {

/// A piece of the motion: positions of b's points in a's frame at both ends.
class MotionPiece {
public:
    /// sag: how far a point is off its chord at most.
    MotionPiece(const TriangleTree& a, const TriangleTree& b, const Affine (&ends)[2], double sag)
        : a_(a), b_(b), ends_{ends[0], ends[1]}, options_{.separation = sag, .until = 1}
    {
    }

    /// Share of the piece; nothing touches where it is 1 or later.
    [[nodiscard]] Touch touch() const { return found_; }

    bool take(std::span<const TrianglePair> pairs)
    {
        for (const TrianglePair& pair : pairs) {
            for (std::uint32_t k = 0; k < 3; ++k) {
                if (is_own_corner(b_, pair.b, k)) offer_vertex_of_b(pair, k);
                if (is_own_corner(a_, pair.a, k)) offer_vertex_of_a(pair, k);
            }
            for (std::uint32_t i = 0; i < 3; ++i)
                for (std::uint32_t j = 0; j < 3; ++j)
                    if (is_own_edge(a_, 3 * pair.a + i) && is_own_edge(b_, 3 * pair.b + j)) offer_edges(pair, i, j);
        }
        return options_.until > 0;
    }

private:
    // A vertex belongs to one of its triangles, an edge to one of its two: each is tested once against a triangle or an edge.
    static bool is_own_corner(const TriangleTree& tree, std::uint32_t t, std::uint32_t k)
    {
        return tree.half_edge_from(tree.triangle(t)[k]) == 3 * t + k;
    }
    static bool is_own_edge(const TriangleTree& tree, std::uint32_t half_edge) { return half_edge <= tree.twin(half_edge); }

    MovingPoint of_a(std::uint32_t t, std::uint32_t k) const
    {
        const Vec3d p = a_.point(a_.triangle(t)[k % 3]);
        return {p, p};
    }
    MovingPoint of_b(std::uint32_t t, std::uint32_t k) const
    {
        const Vec3d p = b_.point(b_.triangle(t)[k % 3]);
        return {apply(ends_[0], p), apply(ends_[1], p)};
    }
    void offer(const Touch& touch)
    {
        if (!touch.touches || (found_.touches && touch.time >= found_.time)) return;
        found_ = touch;
        options_.until = touch.time;
    }
    void offer_vertex_of_b(const TrianglePair& pair, std::uint32_t k)
    {
        const MovingPoint triangle[3] = {of_a(pair.a, 0), of_a(pair.a, 1), of_a(pair.a, 2)};
        offer(first_touch(of_b(pair.b, k), triangle, options_));
    }
    void offer_vertex_of_a(const TrianglePair& pair, std::uint32_t k)
    {
        const MovingPoint triangle[3] = {of_b(pair.b, 0), of_b(pair.b, 1), of_b(pair.b, 2)};
        offer(first_touch(of_a(pair.a, k), triangle, options_));
    }
    void offer_edges(const TrianglePair& pair, std::uint32_t i, std::uint32_t j)
    {
        const MovingPoint a[2] = {of_a(pair.a, i), of_a(pair.a, i + 1)}, b[2] = {of_b(pair.b, j), of_b(pair.b, j + 1)};
        offer(first_touch(a, b, options_));
    }

    const TriangleTree &a_, &b_;
    const Affine ends_[2];
    TouchOptions options_;
    Touch found_{};
};

/// How far a body's points are from its frame's origin at most.
double reach_from_origin(const TriangleTree& tree) { return norm(centre(tree.box())) + 0.5 * norm(size(tree.box())); }
double angle_between(const Pose& from, const Pose& to) { return norm(rotation_vector(to.rotation * transpose(from.rotation))); }

/// How b moves as a sees it; each moves as between() says, along a straight line and about its frame's origin.
struct Motion {
    double turn_a, turn_b;  ///< radians
    double bend;            ///< of a point's path, the greatest second derivative by the share of the motion
    double length;          ///< of a point's path, at most

    Motion(const Body& a, const Pose& to_a, const Body& b, const Pose& to_b)
        : turn_a(angle_between(a.pose, to_a)), turn_b(angle_between(b.pose, to_b))
    {
        const double reach = reach_from_origin(b.probe->triangles());
        const Vec3d first = b.pose.translation - a.pose.translation, last = to_b.translation - to_a.translation;
        // In a's frame, which turns, a point has the acceleration of its own turn, that of Coriolis and the centrifugal one.
        const double speed = turn_b * reach + norm(last - first), farthest = std::max(norm(first), norm(last)) + reach;
        bend = turn_b * turn_b * reach + 2 * turn_a * speed + turn_a * turn_a * farthest;
        length = speed + turn_a * farthest;
    }
    /// Pieces within which paths are straight to a thousandth of the motion where the surfaces approach at 8 degrees: in one of n
    /// pieces a path leaves its chord by bend / (8 n^2).
    [[nodiscard]] int straight_pieces() const
    {
        if (turn_a == 0) return 1 + static_cast<int>(std::ceil(std::sqrt(1000 * turn_b)));
        return 1 + static_cast<int>(std::ceil(std::sqrt(1000 * bend / length)));
    }
    /// How far a point leaves the chord of its path within a share of the motion, at most.
    [[nodiscard]] double sag(double share) const { return bend / 8 * share * share * (1 + 1e-6); }
};

/// Searches the motion for its first touch, earliest first, in pieces of equal duration.
class MotionSearch {
public:
    MotionSearch(const Body& a, const Pose& to_a, const Body& b, const Pose& to_b)
        : a_(a),
          b_(b),
          to_a_(to_a),
          to_b_(to_b),
          tree_a_(a.probe->triangles()),
          tree_b_(b.probe->triangles()),
          motion_(a, to_a, b, to_b),
          middle_(centre(tree_b_.box())),
          radius_(0.5 * norm(size(tree_b_.box())))
    {
        // A piece in which points move farther than triangles are long pairs each triangle with too many others.
        const double step = triangle_size(tree_a_) + triangle_size(tree_b_);
        const double short_pieces = step > 0 ? std::ceil(motion_.length / step) : 1;
        pieces_ = std::max(motion_.straight_pieces(), static_cast<int>(std::clamp(short_pieces, 1., k_max_pieces)));
    }

    BodyTouch run()
    {
        search(0, pieces_);
        return found_;
    }

private:
    static constexpr double k_max_pieces = 4096;

    static double triangle_size(const TriangleTree& tree)
    {
        return norm(size(tree.box())) / std::sqrt(static_cast<double>(tree.size()));
    }
    Affine b_in_a_at(int piece) const
    {
        const double share = static_cast<double>(piece) / pieces_;
        return b_in_a({a_.model, a_.probe, between(a_.pose, to_a_, share)}, {b_.model, b_.probe, between(b_.pose, to_b_, share)});
    }
    /// How far a point of b is from where it is at the first of two ends at most: the middle moves and the box turns.
    double reach(const Affine (&ends)[2], double share) const
    {
        const double turn = (motion_.turn_a + motion_.turn_b) * share;
        return norm(apply(ends[1], middle_) - apply(ends[0], middle_)) + radius_ * turn + 2 * motion_.sag(share);
    }
    /// True where a touch was found in pieces from first to before last.
    bool search(int first, int last)
    {
        const Affine ends[2] = {b_in_a_at(first), b_in_a_at(last)};
        const double share = static_cast<double>(last - first) / pieces_;
        const CandidateJob job(tree_a_, tree_b_, ends[0], reach(ends, share));
        if (last - first == 1) return search_piece(first, job, ends, share);
        bool is_near = false;
        const auto note = [](void* self, std::span<const TrianglePair> pairs) noexcept {
            *static_cast<bool*>(self) |= !pairs.empty();
            return pairs.empty();
        };
        find_candidates(job, note, &is_near);
        if (!is_near) return false;
        const int half = first + (last - first) / 2;
        return search(first, half) || search(half, last);
    }
    bool search_piece(int first, const CandidateJob& job, const Affine (&ends)[2], double share)
    {
        MotionPiece piece(tree_a_, tree_b_, ends, motion_.sag(share));
        const auto take = [](void* self, std::span<const TrianglePair> pairs) noexcept {
            return static_cast<MotionPiece*>(self)->take(pairs);
        };
        find_candidates(job, take, &piece);
        if (!piece.touch().touches) return false;
        found_ = {true, std::max((first + piece.touch().time) / pieces_ - 1e-12, 0.), k_ok};
        return true;
    }

    const Body &a_, &b_;
    const Pose &to_a_, &to_b_;
    const TriangleTree &tree_a_, &tree_b_;
    Motion motion_;
    Vec3d middle_;
    double radius_;
    int pieces_;
    BodyTouch found_{};
};

}  // namespace

BodyTouch first_touch(const Body& a, const Body& b, const Pose& to) noexcept { return first_touch(a, a.pose, b, to); }

BodyTouch first_touch(const Body& a, const Pose& to_a, const Body& b, const Pose& to_b) noexcept
{
    if (!is_finite(a.pose) || !is_finite(b.pose) || !is_finite(to_a) || !is_finite(to_b)) return {true, 0, k_not_finite};
    if (!has_triangles(a) || !has_triangles(b)) return {false, 1, k_no_triangles};
    // Squares of longer ways are infinite.
    const auto is_far = [](const Pose& from, const Pose& to) { return !(norm(to.translation - from.translation) < 1e150); };
    if (is_far(a.pose, b.pose) || is_far(to_a, to_b)) return {true, 0, k_not_finite};
    if (is_within(a, b, 0)) return {true, 0, k_ok};
    return MotionSearch(a, to_a, b, to_b).run();
}

}  // namespace sqmap::query
