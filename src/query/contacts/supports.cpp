// The corners of the overlap of two convex faces are corners of either over the other and crossings of their sides.
#include "supports.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sqmap::query {
namespace {

constexpr double k_rounding = 1e-9;   // of the sizes: positions as near to a side count as within
constexpr double k_opposed = -0.966;  // cosine of 165 degrees
constexpr double k_deepest = 0.125;   // of a side's length

struct Solid {
    const TriangleTree& tree;
    const Affine* move;  // null: its points stay

    [[nodiscard]] Vec3d point(std::uint32_t t, std::uint32_t k) const
    {
        const Vec3d p = tree.point(tree.triangle(t)[k % 3]);
        return move == nullptr ? p : apply(*move, p);
    }
    [[nodiscard]] Vec3d normal(std::uint32_t t) const
    {
        const Vec3d p = point(t, 0);
        return normalized(cross(point(t, 1) - p, point(t, 2) - p));
    }
    template <class Visit>
    void each_sharp(std::uint32_t t, Visit&& visit) const
    {
        for (std::uint32_t k = 0; k < 3; ++k)
            if ((tree.sharp(t) >> k & 1u) != 0) visit(k);
    }
};

/// A side of a triangle.
struct Edge {
    std::uint32_t triangle, corner;
    Vec3d from, to;
};
Edge edge_of(const Solid& solid, std::uint32_t t, std::uint32_t k) { return {t, k, solid.point(t, k), solid.point(t, k + 1)}; }

class Supports {
public:
    Supports(const Solid& bearing, const Solid& resting, TakeSupport take, void* context)
        : bearing_(bearing), resting_(resting), take_(take), context_(context)
    {
    }

    /// Sides of the resting solid's triangle over the bearing one's and its neighbours.
    void find(std::uint32_t bearing, std::uint32_t resting)
    {
        if (resting_.tree.sharp(resting) == 0) return;
        look(bearing, resting);
        bearing_.each_sharp(bearing, [&](std::uint32_t k) { look(bearing_.tree.twin(3 * bearing + k) / 3, resting); });
    }

private:
    void look(std::uint32_t face, std::uint32_t resting)
    {
        face_ = face;
        normal_ = bearing_.normal(face);
        for (std::uint32_t k = 0; k < 3; ++k) corner_[k] = bearing_.point(face, k);
        resting_.each_sharp(resting, [&](std::uint32_t k) {
            const Vec3d own = resting_.normal(resting), beside = resting_.normal(resting_.tree.twin(3 * resting + k) / 3);
            const Vec3d opposed = dot(normal_, own) < dot(normal_, beside) ? own : beside;
            if (dot(normal_, opposed) > k_opposed) return;
            along_ = normalized(normal_ - opposed);
            const Edge edge = edge_of(resting_, resting, k);
            add_corner(edge, k, edge.from);
            add_corner(edge, (k + 1) % 3, edge.to);
            if (resting_.move == nullptr) return;  // crossings are found once
            bearing_.each_sharp(face, [&](std::uint32_t i) { add_crossing(edge_of(bearing_, face, i), edge); });
        });
    }

    void add_corner(const Edge& edge, std::uint32_t corner, Vec3d p)
    {
        const double depth = dot(normal_, corner_[0] - p) / dot(normal_, along_);
        const Vec3d over = p + depth * along_;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const Vec3d side = corner_[(k + 1) % 3] - corner_[k];
            if (!(dot(cross(normal_, side), over - corner_[k]) >= -k_rounding * norm_sq(side))) return;
        }
        Separation s;
        s.on_b = p;
        s.feature_b = Feature::Vertex;
        s.corner_b = static_cast<int>(corner);
        give(s, depth, norm(edge.to - edge.from), {face_, edge.triangle});
    }

    void add_crossing(const Edge& a, const Edge& b)
    {
        const Vec3d da = a.to - a.from, db = b.to - b.from, w = b.from - a.from;
        const double turn = dot(along_, cross(da, db)), length_a = norm(da), length_b = norm(db);
        if (!(std::abs(turn) > k_rounding * length_a * length_b)) return;
        const double at_a = dot(along_, cross(w, db)) / turn, at_b = dot(along_, cross(w, da)) / turn;
        // Near an end the corner there is a support.
        if (std::min({at_a, at_b, 1 - at_a, 1 - at_b}) < k_rounding) return;
        Separation s;
        s.on_b = b.from + at_b * db;
        s.feature_a = s.feature_b = Feature::Edge;
        s.corner_a = static_cast<int>(a.corner);
        s.corner_b = static_cast<int>(b.corner);
        give(s, dot(along_, a.from + at_a * da - s.on_b), std::min(length_a, length_b), {a.triangle, b.triangle});
    }

    /// s is of the bearing solid as though it were a.
    void give(Separation& s, double depth, double length, TrianglePair triangles)
    {
        if (!(depth >= -k_rounding * length && depth <= k_deepest * length)) return;
        s.depth = std::max(depth, 0.);
        s.normal = along_;
        s.on_a = s.on_b + s.depth * along_;
        if (bearing_.move != nullptr) {
            std::swap(s.on_a, s.on_b);
            std::swap(s.feature_a, s.feature_b);
            std::swap(s.corner_a, s.corner_b);
            std::swap(triangles.a, triangles.b);
            s.normal = -s.normal;
        }
        take_(context_, {s, triangles.a, triangles.b});
    }

    const Solid &bearing_, &resting_;
    TakeSupport take_;
    void* context_;
    std::uint32_t face_ = 0;
    Vec3d normal_{}, corner_[3];
    Vec3d along_{};  // the mean of both faces' directions: they share the same area whichever is said to bear the other
};

}  // namespace

void find_supports(const TriangleTree& a, const TriangleTree& b, const Affine& b_in_a, const TrianglePair& meeting,
                   TakeSupport take, void* context) noexcept
{
    const Solid first{a, nullptr}, second{b, &b_in_a};
    Supports(first, second, take, context).find(meeting.a, meeting.b);
    Supports(second, first, take, context).find(meeting.b, meeting.a);
}

}  // namespace sqmap::query
