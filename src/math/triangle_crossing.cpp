// P. Guigue and O. Devillers, "Fast and robust triangle-triangle overlap test using orientation predicates", 2003.
#include "triangle_crossing.h"

#include <algorithm>

namespace sqmap {
namespace {

bool is_between(Vec2d p, Vec2d a, Vec2d b)
{
    return p.x >= std::min(a.x, b.x) && p.x <= std::max(a.x, b.x) && p.y >= std::min(a.y, b.y) && p.y <= std::max(a.y, b.y);
}

bool segments_meet(Vec2d p, Vec2d q, Vec2d a, Vec2d b)
{
    const int pa = orient2d(p, q, a), pb = orient2d(p, q, b), ap = orient2d(a, b, p), aq = orient2d(a, b, q);
    if (pa * pb < 0 && ap * aq < 0) return true;
    return (pa == 0 && is_between(a, p, q)) || (pb == 0 && is_between(b, p, q)) || (ap == 0 && is_between(p, a, b)) ||
           (aq == 0 && is_between(q, a, b));
}

/// True where some of the three are on one side and some on the other.
bool is_mixed(int ab, int bc, int ca) { return (ab > 0 || bc > 0 || ca > 0) && (ab < 0 || bc < 0 || ca < 0); }

/// A segment in the plane of the triangle.
bool meets_in_plane(Vec3d p, Vec3d q, const TriangleCorners& t)
{
    const int axis = open_axis(t);
    if (axis < 0) return false;
    const Vec2d s = projected(p, axis), e = projected(q, axis);
    const Vec2d a = projected(t.a, axis), b = projected(t.b, axis), c = projected(t.c, axis);
    const bool starts_inside = !is_mixed(orient2d(a, b, s), orient2d(b, c, s), orient2d(c, a, s));
    return starts_inside || segments_meet(s, e, a, b) || segments_meet(s, e, b, c) || segments_meet(s, e, c, a);
}

/// Sides of one triangle against the other one, whose orientations are computed when they are needed first: those of a side of
/// a about a side of b serve both.
class SidePairs {
public:
    SidePairs(const TriangleCorners& a, const TriangleCorners& b) : a_(a), b_(b) {}

    /// Side k of a meets b, or the other one's where is_b. above: on which side of the other's plane each corner is.
    bool meets(bool is_b, int k, const int above[3])
    {
        const int next = (k + 1) % 3;
        if (above[k] * above[next] > 0) return false;
        if (above[k] == 0 && above[next] == 0)
            return is_b ? meets_in_plane(b_[k], b_[next], a_) : meets_in_plane(a_[k], a_[next], b_);
        if (is_b) return !is_mixed(turn(0, k), turn(1, k), turn(2, k));
        return !is_mixed(turn(k, 0), turn(k, 1), turn(k, 2));
    }

private:
    int turn(int i, int j)
    {
        if (known_[i][j] == 2) known_[i][j] = orient3d(a_[i], a_[(i + 1) % 3], b_[j], b_[(j + 1) % 3]);
        return known_[i][j];
    }

    const TriangleCorners &a_, &b_;
    int known_[3][3] = {{2, 2, 2}, {2, 2, 2}, {2, 2, 2}};
};

bool is_beside(const int above[3])
{
    return (above[0] > 0 && above[1] > 0 && above[2] > 0) || (above[0] < 0 && above[1] < 0 && above[2] < 0);
}

}  // namespace

int open_axis(const TriangleCorners& t) noexcept
{
    for (int axis = 0; axis < 3; ++axis)
        if (orient2d(projected(t.a, axis), projected(t.b, axis), projected(t.c, axis)) != 0) return axis;
    return -1;
}

bool segment_meets(Vec3d p, Vec3d q, const TriangleCorners& t) noexcept
{
    const int sp = orient3d(t.a, t.b, t.c, p), sq = orient3d(t.a, t.b, t.c, q);
    if (sp * sq > 0) return false;
    if (sp == 0 && sq == 0) return meets_in_plane(p, q, t);
    return !is_mixed(orient3d(p, q, t.a, t.b), orient3d(p, q, t.b, t.c), orient3d(p, q, t.c, t.a));
}

Crossing crossing_of(const TriangleCorners& a, const TriangleCorners& b) noexcept
{
    int above_a[3], above_b[3];
    for (int k = 0; k < 3; ++k) above_b[k] = orient3d(a.a, a.b, a.c, b[k]);
    if (is_beside(above_b)) return {};
    for (int k = 0; k < 3; ++k) above_a[k] = orient3d(b.a, b.b, b.c, a[k]);
    if (is_beside(above_a)) return {};
    SidePairs pairs(a, b);
    Crossing crossing;
    for (int k = 0; k < 3; ++k) {
        if (pairs.meets(false, k, above_a)) crossing.sides_a = static_cast<std::uint8_t>(crossing.sides_a | 1u << k);
        if (pairs.meets(true, k, above_b)) crossing.sides_b = static_cast<std::uint8_t>(crossing.sides_b | 1u << k);
    }
    return crossing;
}

}  // namespace sqmap
