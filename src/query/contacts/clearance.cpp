// Clearance: pairs of triangles that float cannot rule out, the likeliest first, each decided in double.
#include "sqmap/query/clearance.h"

#include "gap_search.h"
#include "query/probe/triangle_tree.h"
#include "sqmap/query/distance.h"
#include "triangle_gap.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::query {
namespace {

/// Orders a heap whose top is the least. An object, not a function: its calls are compiled into the heap's.
constexpr auto k_is_farther = [](const GapEntry& x, const GapEntry& y) {
    if (x.gap != y.gap) return x.gap > y.gap;
    return x.b != y.b ? x.b > y.b : x.a > y.a;
};

constexpr double k_infinite = std::numeric_limits<double>::infinity();

/// A number of float that is no less.
float rounded_up(double v)
{
    const auto f = static_cast<float>(v + 1.2e-7 * std::abs(v));
    return std::isnan(f) ? std::numeric_limits<float>::infinity() : f;
}

class NearestTriangles {
public:
    /// enough: where the search may end.
    NearestTriangles(const Body& a, const Body& b, double enough)
        : tree_a_(a.probe->triangles()),
          tree_b_(b.probe->triangles()),
          move_(b_in_a(a, b)),
          trees_(tree_a_, tree_b_, move_),
          enough_(enough)
    {
        const double far = norm(centre(tree_a_.box())) + norm(centre(tree_b_.box())) + norm(move_.shift);
        rounding_ = 64 * 0x1p-53 * (far + trees_.radius_a + trees_.radius_b);
    }

    void run()
    {
        direction_ = norm(trees_.between) > 0 ? normalized(trees_.between) : Vec3d{0, 0, 1};
        // Any two points are as near as the nearest at most.
        upper_ =
            std::min((norm(trees_.between) + trees_.radius_a + trees_.radius_b) * (1 + 1e-6) + 2 * rounding_, limit_of_enough());
        look_from(centre(tree_a_.box()), apply(move_, centre(tree_b_.box())));
        bound_ = bound();
        search_gap(
            trees_, bound_,
            [](void* self, const TrianglePair& pair) noexcept { return static_cast<NearestTriangles*>(self)->take(pair); }, this);
    }

    /// Squares of what is farther away are infinite.
    [[nodiscard]] bool is_measurable() const { return norm(trees_.between) < 1e150; }
    [[nodiscard]] bool is_found() const { return distance_ <= enough_; }
    [[nodiscard]] double distance() const { return distance_; }
    [[nodiscard]] double at_least() const
    {
        return std::clamp(std::min(distance_ - rounding_, least_gap_) - rounding_, 0., distance_);
    }
    [[nodiscard]] const TriangleGap& gap() const { return gap_; }
    [[nodiscard]] const TrianglePair& pair() const { return pair_; }

private:
    /// The search need not find anything farther away.
    [[nodiscard]] double limit_of_enough() const { return enough_ < 0 ? k_infinite : enough_ * (1 + 1e-6) + 2 * rounding_; }

    [[nodiscard]] GapBound bound() const
    {
        GapBound out;
        if (distance_ <= enough_ || distance_ == 0) {
            out.limit = out.along_limit = -1;
            return out;
        }
        const double between = dot(direction_, trees_.between), error = 1e-6 * (trees_.radius_a + trees_.radius_b);
        const double limit = upper_ - rounding_;
        out.limit = rounded_up(limit);
        out.along_limit = rounded_up(limit - between + error);
        out.along_between = static_cast<float>(std::min(between - 1e-6 * std::abs(between) - error, 1e30));
        const Vec3d in_b = transpose_mul(move_.linear, direction_);
        for (int k = 0; k < 3; ++k) {
            out.direction_a[k] = static_cast<float>(direction_[k]);
            out.direction_b[k] = static_cast<float>(in_b[k]);
            out.nearest_a[k] = nearest_a_[k];
            out.nearest_b[k] = nearest_b_[k];
        }
        return out;
    }

    GapBound take(const TrianglePair& pair)
    {
        const ProbeTriangle &s = tree_a_.triangle(pair.a), &t = tree_b_.triangle(pair.b);
        const TriangleCorners a{tree_a_.point(s[0]), tree_a_.point(s[1]), tree_a_.point(s[2])};
        const TriangleCorners b{apply(move_, tree_b_.point(t[0])), apply(move_, tree_b_.point(t[1])),
                                apply(move_, tree_b_.point(t[2]))};
        if (gap_along(a, b, direction_, a.a) < upper_ - rounding_ && measure(a, b, pair)) bound_ = bound();
        return bound_;
    }

    /// True where it is the nearest so far.
    bool measure(const TriangleCorners& a, const TriangleCorners& b, const TrianglePair& pair)
    {
        TriangleGap gap = gap_of(a, b);
        const Vec3d v = gap.on_b - gap.on_a;
        double distance = std::sqrt(gap.distance_sq);
        const double own = certain_gap(a, b, gap);
        // Triangles that no direction separates for certain may have a point in common beside their sides.
        if (!(own > rounding_)) {
            const Crossing crossing = crossing_of(a, b);
            if (crossing.meets()) {
                gap.on_a = gap.on_b = common_position(a, b, crossing);
                distance = 0;
            }
        }
        least_gap_ = std::min(least_gap_, own);
        if (!(distance < distance_)) return false;
        distance_ = distance;
        upper_ = std::min(upper_, distance);
        gap_ = gap;
        pair_ = pair;
        if (distance > rounding_) direction_ = v / distance;
        look_from(gap.on_a, gap.on_b);
        return true;
    }

    /// Nearer things of a are near to b's position, and the other way round.
    void look_from(Vec3d on_a, Vec3d on_b)
    {
        nearest_a_ = cast<float>(on_b - centre(tree_a_.box()));
        nearest_b_ = cast<float>(transpose_mul(move_.linear, on_a - move_.shift) - centre(tree_b_.box()));
    }

    const TriangleTree &tree_a_, &tree_b_;
    const Affine move_;
    const PosedTrees trees_;
    const double enough_;
    double rounding_ = 0;
    Vec3d direction_{};
    double upper_ = k_infinite;      // of what has to be found
    double distance_ = k_infinite;   // of the nearest pair so far
    double least_gap_ = k_infinite;  // of all pairs that were measured, each along its own direction
    TriangleGap gap_{};
    TrianglePair pair_{};
    GapBound bound_;
    Vec3f nearest_a_{}, nearest_b_{};
};

/// A point of one body's probe within the other's model, where there is one. gap: surfaces are no nearer, so points within are as
/// deep. Nearer to the surface than float rounds the exact layer may take a point outside for one within: these are
/// measured in double.
bool find_inside(const Body& touched, const Body& collider, double gap, Vec3d& point)
{
    Contact contact;
    const ProbeResult found = query_probe(touched, collider, {.layer = Layer::Exact, .first_only = true}, {&contact, 1});
    if (found.contacts == 0) return false;
    point = found.position(contact) - static_cast<double>(contact.depth) * cast<double>(contact.normal);
    if (static_cast<double>(contact.depth) > 1e-6 * (sphere_of(touched).radius + sphere_of(collider).radius)) return true;
    const TriangleTree& tree = collider.probe->triangles();
    for (std::size_t i = 0; i < tree.points(); ++i) {
        point = apply(collider.pose, tree.point(i));
        if (exact_distance(touched, point).distance < -0.5 * gap) return true;
    }
    return false;
}

}  // namespace

void heap_gaps(std::span<GapEntry> entries) noexcept { std::make_heap(entries.begin(), entries.end(), k_is_farther); }
void pop_gap(std::span<GapEntry> entries) noexcept { std::pop_heap(entries.begin(), entries.end(), k_is_farther); }

Clearance clearance(const Body& a, const Body& b) noexcept
{
    Clearance out;
    if (!is_finite(a.pose) || !is_finite(b.pose)) {
        out.status = k_not_finite;
        return out;
    }
    if (!has_triangles(a) || !has_triangles(b)) {
        out.status = k_no_triangles;
        return out;
    }
    NearestTriangles search(a, b, -1);
    if (!search.is_measurable()) {
        out.status = k_not_finite;
        return out;
    }
    search.run();
    Vec3d common;
    if (search.distance() > 0 && (find_inside(a, b, search.distance(), common) || find_inside(b, a, search.distance(), common))) {
        out.witness = {common, common};
        return out;
    }
    out.distance = search.distance();
    out.at_least = search.at_least();
    out.witness = {apply(a.pose, search.gap().on_a), apply(a.pose, search.gap().on_b)};
    out.triangle_a = search.pair().a;
    out.triangle_b = search.pair().b;
    return out;
}

bool is_within(const Body& a, const Body& b, double distance) noexcept
{
    if (!is_finite(a.pose) || !is_finite(b.pose) || !has_triangles(a) || !has_triangles(b) || !(distance >= 0)) return false;
    NearestTriangles search(a, b, distance);
    if (!search.is_measurable()) return false;
    search.run();
    Vec3d common;
    return search.is_found() || find_inside(a, b, distance, common) || find_inside(b, a, distance, common);
}

}  // namespace sqmap::query
