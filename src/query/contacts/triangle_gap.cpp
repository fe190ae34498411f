// E. Larsen, S. Gottschalk, M. C. Lin, D. Manocha, "Fast proximity queries with swept sphere volumes", UNC TR99-018, 1999: two
// sides whose nearest positions are seen past by both third corners are nearest of all. C. Ericson, Real-Time Collision
// Detection, 2005, 5.1.9: nearest positions of segments.
#include "triangle_gap.h"

#include "math/triangle.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace sqmap::query {
namespace {

/// The nearest positions of two segments.
TriangleGap gap_of_segments(Vec3d a, Vec3d da, Vec3d b, Vec3d db)
{
    const Vec3d r = a - b;
    const double aa = norm_sq(da), bb = norm_sq(db), ab = dot(da, db), ar = dot(da, r), br = dot(db, r);
    const double over = aa * bb - ab * ab;
    double s = over > 0 ? std::clamp((ab * br - ar * bb) / over, 0., 1.) : 0.;
    double t = bb > 0 ? (ab * s + br) / bb : 0.;
    if (!(t >= 0 && t <= 1)) {
        t = t > 1 ? 1. : 0.;
        s = aa > 0 ? std::clamp((ab * t - ar) / aa, 0., 1.) : 0.;
    }
    TriangleGap gap{a + s * da, b + t * db};
    gap.distance_sq = norm_sq(gap.on_b - gap.on_a);
    return gap;
}

}  // namespace

TriangleGap gap_of(const TriangleCorners& a, const TriangleCorners& b) noexcept
{
    TriangleGap best;
    best.distance_sq = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
        const Vec3d da = a[(i + 1) % 3] - a[i];
        for (int j = 0; j < 3; ++j) {
            const TriangleGap gap = gap_of_segments(a[i], da, b[j], b[(j + 1) % 3] - b[j]);
            if (!(gap.distance_sq < best.distance_sq)) continue;
            best = gap;
            const Vec3d v = gap.on_b - gap.on_a;
            if (dot(v, a[(i + 2) % 3] - gap.on_a) <= 0 && dot(v, b[(j + 2) % 3] - gap.on_b) >= 0) return best;
        }
    }
    const auto offer = [&](Vec3d on_a, Vec3d on_b) {
        if (const double d = norm_sq(on_b - on_a); d < best.distance_sq) best = {on_a, on_b, d};
    };
    for (int i = 0; i < 3; ++i) offer(a[i], closest_point_on_triangle(a[i], b.a, b.b, b.c));
    for (int j = 0; j < 3; ++j) offer(closest_point_on_triangle(b[j], a.a, a.b, a.c), b[j]);
    return best;
}

double gap_along(const TriangleCorners& a, const TriangleCorners& b, Vec3d direction, Vec3d about) noexcept
{
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int i = 0; i < 3; ++i) {
        high = std::max(high, dot(direction, a[i] - about));
        low = std::min(low, dot(direction, b[i] - about));
    }
    return low - high;
}

double certain_gap(const TriangleCorners& a, const TriangleCorners& b, const TriangleGap& gap) noexcept
{
    const Vec3d v = gap.on_b - gap.on_a;
    const double distance = std::sqrt(gap.distance_sq);
    if (!(distance > 0)) return 0;
    double largest = gap_along(a, b, v / distance, gap.on_a);
    if (largest >= distance * (1 - 1e-8)) return largest;
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j) {
            // The fourth of either is a side of the other triangle: with its own ones it gives that triangle's normal.
            const Vec3d side_a = i < 3 ? a[(i + 1) % 3] - a[i] : b.c - b.a, side_b = j < 3 ? b[(j + 1) % 3] - b[j] : a.c - a.a;
            const Vec3d unit = normalized(cross(side_a, side_b));
            if (norm_sq(unit) > 0.5) largest = std::max(largest, gap_along(a, b, dot(unit, v) < 0 ? -unit : unit, gap.on_a));
        }
    return largest;
}

Vec3d common_position(const TriangleCorners& a, const TriangleCorners& b, const Crossing& crossing) noexcept
{
    const bool of_a = crossing.sides_a != 0;
    const TriangleCorners &from = of_a ? a : b, &to = of_a ? b : a;
    const int k = std::countr_zero(of_a ? crossing.sides_a : crossing.sides_b);
    const Vec3d p = from[k], q = from[(k + 1) % 3], n = cross(to.b - to.a, to.c - to.a);
    const double height = dot(n, p - to.a), rise = height - dot(n, q - to.a);
    const double share = rise != 0 ? std::clamp(height / rise, 0., 1.) : 0.;
    return closest_point_on_triangle(p + share * (q - p), to.a, to.b, to.c);
}

}  // namespace sqmap::query
