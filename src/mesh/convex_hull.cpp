// C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The quickhull algorithm for convex hulls", 1996, with exact signs (Shewchuk 1997)
// in place of his widened facets. Facets in whose plane a new point lies are replaced along with those that it sees. The facets
// beyond the horizon then lie strictly below the point, so no edge of the horizon is in line with it, and no triangle without
// area can arise.
#include "mesh/convex_hull.h"

#include "math/predicates.h"
#include "sqmap/mesh/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace sqmap::mesh {

namespace {

constexpr std::uint32_t k_none = std::numeric_limits<std::uint32_t>::max();

/// A triangle of the hull so far; neighbour k lies across the edge from corner k to corner k + 1.
struct Facet {
    Triangle corners;
    std::array<std::uint32_t, 3> neighbours;
    std::vector<std::uint32_t> above{};  ///< points strictly outside its plane, each listed by one facet alone
    std::uint32_t seen_by = k_none;      ///< the point that was last found to be outside or in the plane
    bool is_gone = false;
};

/// An edge of a facet that a point does not see, as it runs in the facet that the point sees.
struct HorizonEdge {
    std::uint32_t from, to, beyond;
};

class Quickhull {
public:
    explicit Quickhull(std::span<const Vec3d> points) : points_(points), facet_from_(points.size(), k_none) {}

    Mesh run()
    {
        if (!start()) return {};
        for (std::uint32_t f = 0; f < facets_.size(); ++f)
            if (!facets_[f].is_gone && !facets_[f].above.empty()) add(farthest_above(facets_[f]), f);
        return mesh();
    }

private:
    /// +1 outside the plane, 0 in it, -1 inside; exact.
    [[nodiscard]] int side(const Triangle& t, std::uint32_t p) const
    {
        return -orient3d(points_[t[0]], points_[t[1]], points_[t[2]], points_[p]);
    }

    /// The point for which a measure is greatest, the first of equals.
    template <class Measure>
    [[nodiscard]] std::uint32_t first_of_greatest(Measure&& measure) const
    {
        std::uint32_t best = 0;
        double greatest = measure(points_[0]);
        for (std::uint32_t i = 1; i < points_.size(); ++i)
            if (const double m = measure(points_[i]); m > greatest) {
                greatest = m;
                best = i;
            }
        return best;
    }

    /// A tetrahedron of points that are far from one another. False where all points lie in one plane.
    bool start()
    {
        if (points_.size() < 4) return false;
        const std::uint32_t a = first_of_greatest([](Vec3d p) { return -p.x; });
        std::uint32_t b = first_of_greatest([&](Vec3d p) { return norm_sq(p - points_[a]); });
        const Vec3d along = points_[b] - points_[a];
        std::uint32_t c = first_of_greatest([&](Vec3d p) { return norm_sq(cross(along, p - points_[a])); });
        const Vec3d up = cross(along, points_[c] - points_[a]);
        std::uint32_t d = first_of_greatest([&](Vec3d p) { return std::abs(dot(up, p - points_[a])); });
        int turn = side({a, b, c}, d);
        // Rounding may have chosen a point in the plane though others are off it.
        for (std::uint32_t i = 0; i < points_.size() && turn == 0; ++i) turn = side({a, b, c}, d = i);
        if (turn == 0) return false;
        if (turn > 0) std::swap(b, c);
        facets_ = {{{a, b, c}, {1, 2, 3}}, {{b, a, d}, {0, 3, 2}}, {{c, b, d}, {0, 1, 3}}, {{a, c, d}, {0, 2, 1}}};
        for (std::uint32_t i = 0; i < points_.size(); ++i) list(i, 0);
        return true;
    }

    /// Lists a point with the first facet, from one on, that it is outside of. A point outside of none is inside the hull.
    void list(std::uint32_t p, std::size_t first)
    {
        for (std::size_t f = first; f < facets_.size(); ++f)
            if (side(facets_[f].corners, p) > 0) {
                facets_[f].above.push_back(p);
                return;
            }
    }

    [[nodiscard]] std::uint32_t farthest_above(const Facet& f) const
    {
        const Vec3d a = points_[f.corners[0]], n = cross(points_[f.corners[1]] - a, points_[f.corners[2]] - a);
        std::uint32_t best = f.above.front();
        for (const std::uint32_t p : f.above)
            if (dot(n, points_[p] - a) > dot(n, points_[best] - a)) best = p;
        return best;
    }

    /// Replaces the facets that a point sees, or in whose plane it lies, by those that join it to their horizon.
    void add(std::uint32_t p, std::uint32_t first_seen)
    {
        std::vector<std::uint32_t> seen{first_seen};
        facets_[first_seen].seen_by = p;
        std::vector<HorizonEdge> horizon;
        for (std::size_t i = 0; i < seen.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                const Facet& f = facets_[seen[i]];
                const std::uint32_t beyond = f.neighbours[k];
                if (facets_[beyond].seen_by == p) continue;
                if (side(facets_[beyond].corners, p) < 0) {
                    horizon.push_back({f.corners[k], f.corners[(k + 1) % 3], beyond});
                } else {
                    facets_[beyond].seen_by = p;
                    seen.push_back(beyond);
                }
            }
        const std::size_t first_new = facets_.size();
        join(p, horizon);
        for (const std::uint32_t f : seen) {
            facets_[f].is_gone = true;
            const std::vector<std::uint32_t> above = std::exchange(facets_[f].above, {});
            for (const std::uint32_t q : above)
                if (q != p) list(q, first_new);
        }
    }

    void join(std::uint32_t p, const std::vector<HorizonEdge>& horizon)
    {
        for (const HorizonEdge& e : horizon) {
            const auto made = static_cast<std::uint32_t>(facets_.size());
            facet_from_[e.from] = made;
            facets_.push_back({{e.from, e.to, p}, {e.beyond, k_none, k_none}});
            Facet& beyond = facets_[e.beyond];
            for (std::size_t k = 0; k < 3; ++k)
                if (beyond.corners[k] == e.to && beyond.corners[(k + 1) % 3] == e.from) beyond.neighbours[k] = made;
        }
        for (const HorizonEdge& e : horizon) {
            const std::uint32_t made = facet_from_[e.from], next = facet_from_[e.to];
            facets_[made].neighbours[1] = next;
            facets_[next].neighbours[2] = made;
        }
    }

    [[nodiscard]] Mesh mesh() const
    {
        std::vector<std::uint32_t> rank(points_.size(), k_none);
        for (const Facet& f : facets_)
            if (!f.is_gone)
                for (const std::uint32_t v : f.corners) rank[v] = 0;
        Mesh hull;
        for (std::uint32_t i = 0; i < points_.size(); ++i) {
            if (rank[i] == k_none) continue;
            rank[i] = static_cast<std::uint32_t>(hull.vertices.size());
            hull.vertices.push_back(points_[i]);
        }
        for (const Facet& f : facets_)
            if (!f.is_gone) hull.triangles.push_back({rank[f.corners[0]], rank[f.corners[1]], rank[f.corners[2]]});
        return hull;
    }

    std::span<const Vec3d> points_;
    std::vector<Facet> facets_;
    std::vector<std::uint32_t> facet_from_;  ///< #points: the newest facet whose edge on the horizon starts there
};

/// True where all half-spaces hold a point, up to rounding. suspect: the half-space that is tried first. One that does
/// not hold the point is the next suspect, as the next point is often beyond it too.
bool all_hold(std::span<const HalfSpaced> sides, Vec3d p, std::size_t& suspect)
{
    if (suspect < sides.size() && !nearly_holds(sides[suspect], p)) return false;
    const auto missed = std::find_if(sides.begin(), sides.end(), [&](const HalfSpaced& side) { return !nearly_holds(side, p); });
    if (missed == sides.end()) return true;
    suspect = static_cast<std::size_t>(missed - sides.begin());
    return false;
}

}  // namespace

Mesh convex_hull(std::span<const Vec3d> points) { return Quickhull(points).run(); }

bool meet(const HalfSpaced& a, const HalfSpaced& b, const HalfSpaced& c, Vec3d& point)
{
    const Vec3d bc = cross(b.normal, c.normal), ca = cross(c.normal, a.normal), ab = cross(a.normal, b.normal);
    const double determinant = dot(a.normal, bc);
    if (!(std::abs(determinant) > 1e-9 * norm(a.normal) * norm(b.normal) * norm(c.normal))) return false;
    point = (a.offset * bc + b.offset * ca + c.offset * ab) / determinant;
    return true;
}

bool nearly_holds(const HalfSpaced& side, Vec3d p)
{
    const double slack = 1e-9 * (std::abs(side.offset) + norm(side.normal) * norm(p));
    return dot(side.normal, p) <= side.offset + slack;
}

std::vector<Vec3d> polytope_corners(std::span<const HalfSpaced> sides)
{
    std::vector<Vec3d> corners;
    std::size_t suspect = 0;
    for (std::size_t i = 0; i < sides.size(); ++i)
        for (std::size_t j = i + 1; j < sides.size(); ++j)
            for (std::size_t k = j + 1; k < sides.size(); ++k)
                if (Vec3d p; meet(sides[i], sides[j], sides[k], p) && all_hold(sides, p, suspect)) corners.push_back(p);
    return corners;
}

std::vector<Vec3d> corners_on(const HalfSpaced& side, std::span<const HalfSpaced> sides)
{
    std::vector<Vec3d> corners;
    std::size_t suspect = 0;
    for (std::size_t i = 0; i < sides.size(); ++i)
        for (std::size_t j = i + 1; j < sides.size(); ++j)
            if (Vec3d p; meet(side, sides[i], sides[j], p) && all_hold(sides, p, suspect)) corners.push_back(p);
    return corners;
}

double farthest_from_hull(const Mesh& hull, std::span<const Vec3d> points)
{
    struct Plane {
        Vec3d on, normal;
    };
    std::vector<Plane> planes;
    for (const Triangle& t : hull.triangles) {
        const Vec3d a = hull.vertices[t[0]];
        planes.push_back({a, cross(hull.vertices[t[1]] - a, hull.vertices[t[2]] - a)});
    }
    const Bvh bvh(hull);
    double farthest = 0;
    for (const Vec3d& p : points) {
        const bool is_outside =
            std::any_of(planes.begin(), planes.end(), [&](const Plane& plane) { return dot(plane.normal, p - plane.on) > 0; });
        if (is_outside) farthest = std::max(farthest, bvh.closest_point(p).distance);
    }
    return farthest;
}

}  // namespace sqmap::mesh
