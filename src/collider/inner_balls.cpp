#include "collider/inner_balls.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

namespace sqmap::collider {

namespace {

constexpr std::size_t k_tests = 10'000'000;  ///< of pieces in balls, for each cover
constexpr std::size_t k_least_centres = 500;

}  // namespace

double reach_of(const GridPiece& piece, Vec3d from)
{
    double reach_sq = 0;
    for (const Vec3d& p : piece.corners) reach_sq = std::max(reach_sq, norm_sq(p - from));
    return std::sqrt(reach_sq);
}

InnerBalls::InnerBalls(const std::vector<GridPiece>& pieces, const mesh::Solid& solid, std::vector<Vec3d> inner) : pieces_(pieces)
{
    double first_step = 0;
    for (const GridPiece& piece : pieces) {
        inner.push_back(piece.middle);
        radii_.push_back(reach_of(piece, piece.middle));
        first_step = std::max(first_step, radii_.back());
    }
    // Spread over all of them, in whatever order they are.
    constexpr double k_golden = 0.6180339887498949;
    const std::size_t wanted = std::min(inner.size(), std::max(k_tests / pieces.size(), k_least_centres));
    for (std::size_t i = 0; i < wanted; ++i) {
        const double share = k_golden * static_cast<double>(i) - std::floor(k_golden * static_cast<double>(i));
        const Vec3d& p = inner[static_cast<std::size_t>(share * static_cast<double>(inner.size()))];
        if (solid.inside(p)) centres_.push_back(deepest_near(solid, p, first_step));
    }
}

/// Walks away from the surface to about the medial axis, where balls protrude least.
InnerBalls::Centre InnerBalls::deepest_near(const mesh::Solid& solid, Vec3d p, double step)
{
    const double last_step = step / 64;
    mesh::ClosestPoint nearest = solid.bvh().closest_point(p);
    while (step > last_step && nearest.distance > 0) {
        const Vec3d next = p + step / nearest.distance * (p - nearest.point);
        const mesh::ClosestPoint there = solid.bvh().closest_point(next);
        if (there.distance > nearest.distance && solid.inside(next)) {
            p = next;
            nearest = there;
        } else {
            step *= 0.5;
        }
    }
    return {p, nearest.distance};
}

BitSet InnerBalls::held_by(const Centre& c, double protrusion) const
{
    BitSet held(pieces_.size());
    const double radius = c.depth + protrusion;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        const double distance_sq = norm_sq(pieces_[i].middle - c.at), surely = radius - radii_[i];
        if (distance_sq > radius * radius) continue;
        if ((surely > 0 && distance_sq <= surely * surely) || reach_of(pieces_[i], c.at) <= radius) held.add(i);
    }
    return held;
}

std::vector<Cluster> InnerBalls::cover(double protrusion, std::size_t count) const
{
    std::vector<BitSet> held;
    std::priority_queue<std::pair<std::size_t, std::size_t>> balls;  // how many pieces a ball may still add, and which ball
    for (const Centre& c : centres_) {
        held.push_back(held_by(c, protrusion));
        balls.emplace(held.back().count(), held.size() - 1);
    }
    BitSet left(pieces_.size());
    for (std::size_t i = 0; i < pieces_.size(); ++i) left.add(i);
    std::vector<Cluster> clusters;
    while (left.count() > 0) {
        if (balls.empty() || clusters.size() == count) return {};
        const std::size_t ball = balls.top().second;
        balls.pop();
        const std::size_t more = held[ball].count_in(left);
        if (more == 0) continue;
        if (!balls.empty() && more < balls.top().first) {
            balls.emplace(more, ball);
            continue;
        }
        Cluster& cluster = clusters.emplace_back(Cluster{.pieces = held[ball].common(left)});
        cluster.ball = {centres_[ball].at, centres_[ball].depth + protrusion};
        left.remove(held[ball]);
    }
    return clusters;
}

}  // namespace sqmap::collider
