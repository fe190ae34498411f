// S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH 1996 (separating axes); D. Gregorius, "The separating axis test between
// convex polyhedra", GDC 2013 (which pairs of edges support each other).
#include "separating_axes.h"

#include "math/triangle.h"
#include "parting.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::query {
namespace {

constexpr double k_deepest_beside_end = 4;  ///< depth of two edges, in distances to the nearest end of one

constexpr double k_beside = 0.02;  ///< sine up to which a direction beside a face counts as outwards

/// Parameters of the nearest positions of two lines; false where they are parallel within rounding.
bool nearest_on_lines(Vec3d w, Vec3d da, Vec3d db, double& s, double& t)
{
    const Vec3d n = cross(da, db);
    const double nn = norm_sq(n);
    if (!(nn > 1e-24 * norm_sq(da) * norm_sq(db))) return false;
    s = dot(cross(w, db), n) / nn;
    t = dot(cross(w, da), n) / nn;
    return true;
}

struct Range {
    double low, high;
    int at_low, at_high;  // corners
};
Range range_along(Vec3d axis, const TriangleCorners& t)
{
    const double v[3] = {dot(axis, t.a), dot(axis, t.b), dot(axis, t.c)};
    const auto low = static_cast<int>(std::min_element(v, v + 3) - v), high = static_cast<int>(std::max_element(v, v + 3) - v);
    return {v[low], v[high], low, high};
}

/// The directions that may separate two triangles.
class Directions {
public:
    Directions(const TriangleCorners& a, const TriangleCorners& b)
        : a_(a),
          b_(b),
          normal_a_(normalized(cross(a.b - a.a, a.c - a.a))),
          normal_b_(normalized(cross(b.b - b.a, b.c - b.a))),
          size_(norm(a.b - a.a) + norm(a.c - a.a) + norm(b.b - b.a) + norm(b.c - b.a))
    {
    }

    /// outwards: only directions that leave a's outer side and enter b's. False where there is none.
    bool find(bool outwards)
    {
        try_axis(normal_a_, outwards, -1, -1);
        try_axis(-normal_b_, outwards, -2, -2);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                const Vec3d da = a_[(i + 1) % 3] - a_[i], db = b_[(j + 1) % 3] - b_[j], n = cross(da, db);
                if (!(norm_sq(n) > 1e-24 * norm_sq(da) * norm_sq(db))) continue;
                const Vec3d unit = normalized(n);
                try_axis(unit, outwards, i, j);
                try_axis(-unit, outwards, i, j);
            }
        // In one plane they are also separated within it, normal to a side: then no two sides have a direction in common.
        if (norm_sq(cross(normal_a_, normal_b_)) < 1e-12)
            for (const TriangleCorners* t : {&a_, &b_})
                for (int i = 0; i < 3; ++i) {
                    const Vec3d unit = normalized(cross((*t)[(i + 1) % 3] - (*t)[i], normal_a_));
                    try_axis(unit, false, -3, -3);
                    try_axis(-unit, false, -3, -3);
                }
        return depth_ < std::numeric_limits<double>::infinity();
    }

    /// The features that bound both triangles touch last where they hold both witness points. Outer sides may leave no
    /// such direction: then the triangles part before their bounds pass each other.
    [[nodiscard]] Separation result() const
    {
        const Separation s = bounds();
        return holds(a_, s.on_a) && holds(b_, s.on_b) ? s : last_touch(s);
    }

private:
    [[nodiscard]] Separation bounds() const
    {
        const Range along_a = range_along(axis_, a_), along_b = range_along(axis_, b_);
        Separation s;
        s.normal = axis_;
        s.depth = std::max(depth_, 0.);
        if (i_ == -2) {
            s.corner_a = along_a.at_high;
            s.feature_a = Feature::Vertex;
            s.on_a = a_[s.corner_a];
            s.on_b = s.on_a - s.depth * axis_;
            return s;
        }
        s.corner_b = along_b.at_low;
        s.feature_b = Feature::Vertex;
        s.on_b = b_[s.corner_b];
        s.on_a = s.on_b + s.depth * axis_;
        double at_a = 0, at_b = 0;
        if (i_ < 0) return s;
        const Vec3d da = a_[(i_ + 1) % 3] - a_[i_], db = b_[(j_ + 1) % 3] - b_[j_];
        if (!nearest_on_lines(b_[j_] - a_[i_], da, db, at_a, at_b)) return s;
        s.feature_a = s.feature_b = Feature::Edge;
        s.corner_a = i_;
        s.corner_b = j_;
        s.on_a = a_[i_] + std::clamp(at_a, 0., 1.) * da;
        s.on_b = s.on_a - s.depth * axis_;
        return s;
    }

    /// The translation along the direction after which the triangles have no point in common, and what touches there.
    [[nodiscard]] Separation last_touch(const Separation& otherwise) const
    {
        const Vec3d beside = std::abs(axis_.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
        const Vec3d u = normalized(cross(beside, axis_)), v = cross(axis_, u), origin = a_.a;
        const auto along = [&](Vec3d p) { return Vec3d{dot(u, p - origin), dot(v, p - origin), dot(axis_, p - origin)}; };
        const auto seen = [&](const TriangleCorners& t) { return TriangleCorners{along(t.a), along(t.b), along(t.c)}; };
        const MeetingRange range = meeting_range(seen(a_), seen(b_), 1e-12 * size_);
        if (!(range.low <= range.high)) return otherwise;
        const Vec3d at = range.last.on_a;
        Separation s;
        s.normal = axis_;
        s.depth = std::max(range.high, 0.);
        s.on_a = origin + at.x * u + at.y * v + at.z * axis_;
        s.on_b = s.on_a - s.depth * axis_;
        s.feature_a = range.last.feature_a;
        s.feature_b = range.last.feature_b;
        s.corner_a = range.last.corner_a;
        s.corner_b = range.last.corner_b;
        return s;
    }

    [[nodiscard]] bool holds(const TriangleCorners& t, Vec3d p) const
    {
        return norm(closest_point_on_triangle(p, t.a, t.b, t.c) - p) <= 1e-9 * size_;
    }

    void try_axis(Vec3d axis, bool outwards, int i, int j)
    {
        if (!(norm_sq(axis) > 0.5) || (outwards && (dot(axis, normal_a_) < -k_beside || dot(axis, normal_b_) > k_beside))) return;
        const double depth = range_along(axis, a_).high - range_along(axis, b_).low;
        if (!(depth < depth_)) return;
        depth_ = depth;
        axis_ = axis;
        i_ = i;
        j_ = j;
    }

    const TriangleCorners &a_, &b_;
    const Vec3d normal_a_, normal_b_;
    const double size_;  // of both
    double depth_ = std::numeric_limits<double>::infinity();
    Vec3d axis_{};
    int i_ = 0, j_ = 0;  // sides; -1: the normal of a, -2: of b, -3: within the plane of both
};

}  // namespace

bool surely_lack_support(const Wedge& a, const Wedge& b) noexcept
{
    const Vec3d n = cross(a.to - a.from, b.to - b.from);
    bool falls = false, rises = false;
    const auto look = [&](Vec3d down) {
        const double x = n.x * down.x, y = n.y * down.y, z = n.z * down.z, sum = x + y + z;
        // Above what double rounds here, and there in the unit normal.
        const double bound = 1e-14 * (std::abs(x) + std::abs(y) + std::abs(z));
        falls |= sum > bound;
        rises |= sum < -bound;
    };
    for (int i = 0; i < 2; ++i) {
        look(a.from - a.beside[i]);
        look(b.beside[i] - b.from);
    }
    return falls && rises;
}

std::optional<Separation> separate(const Wedge& a, const Wedge& b) noexcept
{
    const Vec3d da = a.to - a.from, db = b.to - b.from, w = b.from - a.from;
    double at_a = 0, at_b = 0;
    if (!nearest_on_lines(w, da, db, at_a, at_b)) return {};
    if (at_a < 0 || at_a > 1 || at_b < 0 || at_b > 1) return {};
    Vec3d n = normalized(cross(da, db));
    double falls_a[2], rises_b[2];
    for (int i = 0; i < 2; ++i) {
        falls_a[i] = dot(n, a.from - a.beside[i]);
        rises_b[i] = dot(n, b.beside[i] - b.from);
    }
    if (falls_a[0] + falls_a[1] + rises_b[0] + rises_b[1] < 0) {
        n = -n;
        for (double* v : {falls_a, falls_a + 1, rises_b, rises_b + 1}) *v = -*v;
    }
    if (falls_a[0] < 0 || falls_a[1] < 0 || rises_b[0] < 0 || rises_b[1] < 0) return {};
    Separation s;
    s.feature_a = s.feature_b = Feature::Edge;
    s.normal = n;
    s.depth = std::max(-dot(n, w), 0.);
    s.on_a = a.from + at_a * da;
    s.on_b = s.on_a - s.depth * n;
    // An edge that ends much nearer than that is left along it: what is there separates both with less.
    const double to_end = std::min(std::min(at_a, 1 - at_a) * norm(da), std::min(at_b, 1 - at_b) * norm(db));
    if (s.depth > k_deepest_beside_end * to_end) return {};
    return s;
}

double depth_along_normals(const TriangleCorners& a, const TriangleCorners& b) noexcept
{
    const auto below = [](const TriangleCorners& of, const TriangleCorners& other) {
        const Vec3d normal = cross(of.b - of.a, of.c - of.b);
        const auto height = [&](Vec3d p) { return dot(p - of.b, normal); };
        const double length = norm(normal), lowest = std::min(height(other.a), std::min(height(other.b), height(other.c)));
        return -lowest / (length > 0 ? length : 1);
    };
    return std::max(std::min(below(a, b), below(b, a)), 0.);
}

Separation separate(const TriangleCorners& a, const TriangleCorners& b) noexcept
{
    Directions directions(a, b);
    if (!directions.find(true)) directions.find(false);
    return directions.result();
}

}  // namespace sqmap::query
