// E. Welzl, "Smallest enclosing disks (balls and ellipsoids)", 1991, on few points: B. Gaertner, "Fast and robust smallest
// enclosing balls", 1999, adds the farthest point again and again until none is outside.
#include "collider/searches.h"

#include <algorithm>
#include <cmath>
#include <list>
#include <vector>

namespace sqmap::collider {
namespace {

/// The smallest ball with all given points on its surface; of points that are affinely dependent, that of those before.
struct Support4 {
    std::array<Vec3d, 4> points{};
    int count = 0;

    [[nodiscard]] Sphere ball() const
    {
        if (count == 0) return {{}, -1};
        if (count == 1) return {points[0], 0};
        // centre = p0 + sum_i l_i d_i with 2 d_i . centre' = |d_i|^2: Gram's system by elimination.
        const int n = count - 1;
        double a[3][4] = {};
        double scale = 0;
        Vec3d d[3];
        for (int i = 0; i < n; ++i) d[i] = points[i + 1] - points[0];
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) a[i][j] = 2 * dot(d[i], d[j]);
            a[i][3] = norm_sq(d[i]);
            scale = std::max(scale, a[i][3]);
        }
        for (int c = 0; c < n; ++c) {
            int pivot = c;
            for (int r = c + 1; r < n; ++r)
                if (std::abs(a[r][c]) > std::abs(a[pivot][c])) pivot = r;
            if (!(std::abs(a[pivot][c]) > 1e-13 * scale)) return Support4{points, count - 1}.ball();
            for (int k = 0; k < 4; ++k) std::swap(a[c][k], a[pivot][k]);
            for (int r = 0; r < n; ++r) {
                if (r == c) continue;
                const double f = a[r][c] / a[c][c];
                for (int k = 0; k < 4; ++k) a[r][k] -= f * a[c][k];
            }
        }
        Vec3d offset{};
        for (int i = 0; i < n; ++i) offset += a[i][3] / a[i][i] * d[i];
        return {points[0] + offset, norm(offset)};
    }
};

using List = std::list<Vec3d>;

Sphere smallest(List& points, const List::iterator end, const Support4& support)
{
    Sphere ball = support.ball();
    if (support.count == 4) return ball;
    for (auto it = points.begin(); it != end;) {
        const auto here = it++;
        if (ball.radius >= 0 && norm(*here - ball.centre) <= ball.radius * (1 + 1e-12)) continue;
        Support4 more = support;
        more.points[static_cast<std::size_t>(more.count++)] = *here;
        ball = smallest(points, here, more);
        points.splice(points.begin(), points, here);
    }
    return ball;
}

}  // namespace

Sphere least_ball(std::span<const Vec3d> points_far)
{
    // About one of them: beside large coordinates the tests of small distances would fail.
    const Vec3d origin = points_far.empty() ? Vec3d{} : points_far[0];
    std::vector<Vec3d> points;
    for (const Vec3d& p : points_far) points.push_back(p - origin);
    constexpr int k_max_pivots = 200;  // each grows the ball, and a dozen suffice as a rule
    List pivots;
    Sphere ball{points.empty() ? Vec3d{} : points[0], 0};
    for (int i = 0; i < k_max_pivots; ++i) {
        double farthest_sq = -1;
        Vec3d pivot{};
        for (const Vec3d& p : points)
            if (const double d = norm_sq(p - ball.centre); d > farthest_sq) {
                farthest_sq = d;
                pivot = p;
            }
        const double farthest = std::sqrt(std::max(0.0, farthest_sq));
        const bool is_held = farthest <= ball.radius * (1 + 1e-10);
        ball.radius = std::max(ball.radius, farthest);
        if (is_held || farthest_sq <= 0) break;
        pivots.push_front(pivot);
        ball = smallest(pivots, pivots.end(), {});
    }
    double radius_sq = 0;
    for (const Vec3d& p : points) radius_sq = std::max(radius_sq, norm_sq(p - ball.centre));
    ball.radius = std::sqrt(radius_sq);
    ball.centre += origin;
    return ball;
}

}  // namespace sqmap::collider
