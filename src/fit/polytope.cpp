// Choosing few tangent planes of a convex hull: greedy maximum coverage (G. Nemhauser, L. Wolsey, M. Fisher, 1978, within
// 1 - 1/e of the best choice) of points that should be cut off, then a pattern search of each plane's direction.
#include "fit/polytope.h"

#include "math/bit_set.h"
#include "mesh/convex_hull.h"
#include "sqmap/fit/fit.h"
#include "sqmap/mesh/bvh.h"
#include "support.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace sqmap::fit {

namespace {

constexpr double k_float_unit = 0x1.0p-24;
constexpr std::size_t k_spread = 128;                     ///< directions that do not depend on the hull
constexpr std::size_t k_max_facets = 160;                 ///< directions of the hull's largest facets
constexpr double k_same_direction = 0.9962;               ///< cosine of 5 degrees: of two facets so near the larger serves
constexpr double k_box = 1.3;                             ///< the sampled box, as a multiple of the hull's
constexpr double k_first_turn = 0.2, k_last_turn = 0.02;  ///< radians, of the pattern search
constexpr int k_sweeps = 2;
constexpr std::size_t k_excess_share = 5;  ///< one side in so many cuts off a far corner, whatever volume it has
constexpr double k_near = 0.01;            ///< of the superquadric's largest semi-axis: nearer corners stay

float rounded_up(double v)
{
    const auto f = static_cast<float>(v);
    return static_cast<double>(f) < v ? std::nextafterf(f, std::numeric_limits<float>::infinity()) : f;
}

/// Evenly spread unit vectors: a Fibonacci lattice.
Vec3d spread_direction(std::size_t k, std::size_t count)
{
    const double z = 1 - (2 * static_cast<double>(k) + 1) / static_cast<double>(count), r = std::sqrt(1 - z * z);
    const double angle = std::numbers::pi * (3 - std::sqrt(5.)) * static_cast<double>(k);
    return {r * std::cos(angle), r * std::sin(angle), z};
}

/// A tangent plane, and the points outside it.
struct Cut {
    Vec3d direction;
    BitSet beyond;
};

class SideChooser {
public:
    SideChooser(const mesh::Mesh& hull, std::span<const Vec3d> points, const shape::Superquadricd& beside,
                const PolytopeOptions& options)
        : hull_(hull), corners_(hull.triangles.empty() ? points : std::span<const Vec3d>(hull.vertices)), beside_(beside)
    {
        find_facets();
        gather(options.samples);
    }

    std::vector<Vec3d> run(std::size_t max_sides)
    {
        const std::size_t by_volume = std::max<std::size_t>(6, max_sides - max_sides / k_excess_share);
        std::vector<Cut> chosen = greedy(by_volume);
        for (int sweep = 0; sweep < k_sweeps; ++sweep)
            for (std::size_t i = 0; i < chosen.size(); ++i) turn(chosen, i);
        std::vector<Vec3d> directions;
        for (const Cut& cut : chosen) directions.push_back(cut.direction);
        if (!is_bounded(directions)) bound(directions, by_volume);
        while (directions.size() < max_sides && cut_farthest_corner(directions)) {
        }
        return directions;
    }

private:
    struct FacetPlane {
        Vec3d on, normal;
        double area;
    };

    void find_facets()
    {
        for (const mesh::Triangle& t : hull_.triangles) {
            const Vec3d a = hull_.vertices[t[0]], n = cross(hull_.vertices[t[1]] - a, hull_.vertices[t[2]] - a);
            facets_.push_back({a, normalized(n), norm(n)});
        }
        std::stable_sort(facets_.begin(), facets_.end(),
                         [](const FacetPlane& l, const FacetPlane& r) { return l.area > r.area; });
    }

    [[nodiscard]] bool is_in_hull(Vec3d p) const
    {
        return !facets_.empty() &&
               std::all_of(facets_.begin(), facets_.end(), [&](const FacetPlane& f) { return dot(f.normal, p - f.on) <= 0; });
    }

    /// Points outside the hull: of the superquadric, and of a box in its frame so that the sides close on all sides.
    void gather(std::size_t samples)
    {
        const auto add = [&](Vec3d p) {
            if (!is_in_hull(p)) outside_.push_back(p);
        };
        for (const InteriorPoint& p : interior_points(beside_, 2 * samples)) add(p.point);
        Vec3d lo{}, hi{};
        for (std::size_t i = 0; i < corners_.size(); ++i) {
            const Vec3d q = beside_.rotation * corners_[i];
            for (int k = 0; k < 3; ++k) {
                lo[k] = i == 0 ? q[k] : std::min(lo[k], q[k]);
                hi[k] = i == 0 ? q[k] : std::max(hi[k], q[k]);
            }
        }
        const Vec3d middle = 0.5 * (lo + hi), half = 0.5 * k_box * (hi - lo);
        for (const Vec3d& at : spread_points(samples)) {
            Vec3d q = middle;
            for (int k = 0; k < 3; ++k) q[k] += half[k] * (2 * at[k] - 1);
            add(transpose_mul(beside_.rotation, q));
        }
    }

    [[nodiscard]] double support(Vec3d direction) const { return greatest_along(direction, corners_); }

    [[nodiscard]] Cut cut_along(Vec3d direction) const
    {
        Cut cut{direction, BitSet(outside_.size())};
        mark_beyond(direction, support(direction), outside_, cut.beyond.words());
        return cut;
    }

    [[nodiscard]] std::vector<Vec3d> candidates() const
    {
        std::vector<Vec3d> directions;
        for (const FacetPlane& f : facets_) {
            if (directions.size() == k_max_facets) break;
            if (std::none_of(directions.begin(), directions.end(), [&](Vec3d d) { return dot(d, f.normal) > k_same_direction; }))
                directions.push_back(f.normal);
        }
        for (std::size_t k = 0; k < k_spread; ++k)
            directions.push_back(transpose_mul(beside_.rotation, spread_direction(k, k_spread)));
        return directions;
    }

    [[nodiscard]] std::vector<Cut> greedy(std::size_t max_sides) const
    {
        std::vector<Cut> cuts, chosen;
        for (const Vec3d& d : candidates()) cuts.push_back(cut_along(d));
        BitSet done(outside_.size());
        while (chosen.size() < max_sides) {
            std::size_t best = 0, gain = 0;
            for (std::size_t i = 0; i < cuts.size(); ++i)
                if (const std::size_t more = cuts[i].beyond.count_without(done); more > gain) {
                    gain = more;
                    best = i;
                }
            if (gain == 0) break;
            done.add(cuts[best].beyond);
            chosen.push_back(cuts[best]);
        }
        return chosen;
    }

    /// Turns one plane about the hull while it cuts off more points that the others leave.
    void turn(std::vector<Cut>& chosen, std::size_t index) const
    {
        BitSet others(outside_.size());
        for (std::size_t i = 0; i < chosen.size(); ++i)
            if (i != index) others.add(chosen[i].beyond);
        std::size_t gain = chosen[index].beyond.count_without(others);
        for (double by = k_first_turn; by >= k_last_turn;) {
            const Vec3d n = chosen[index].direction;
            const Vec3d across = normalized(cross(n, std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})),
                        third = cross(n, across);
            bool is_better = false;
            for (const Vec3d& to : {across, -across, third, -third}) {
                Cut cut = cut_along(normalized(n + by * to));
                if (const std::size_t more = cut.beyond.count_without(others); more > gain) {
                    gain = more;
                    chosen[index] = std::move(cut);
                    is_better = true;
                    break;
                }
            }
            if (!is_better) by *= 0.5;
        }
    }

    /// Adds the side that the corner farthest from the hull loses most by: across the line to the nearest point of the hull.
    /// False where no corner is far away.
    bool cut_farthest_corner(std::vector<Vec3d>& directions) const
    {
        if (hull_.triangles.empty()) return false;
        std::vector<HalfSpaced> sides;
        for (const Vec3d& d : directions) sides.push_back({d, support(d)});
        const mesh::Bvh bvh(hull_);
        double farthest = k_near * std::max({beside_.a.x, beside_.a.y, beside_.a.z});
        Vec3d across{};
        for (const Vec3d& p : mesh::polytope_corners(sides)) {
            if (is_in_hull(p)) continue;
            const mesh::ClosestPoint nearest = bvh.closest_point(p);
            if (!(nearest.distance > farthest)) continue;
            farthest = nearest.distance;
            across = (p - nearest.point) / nearest.distance;
        }
        if (norm_sq(across) > 0) directions.push_back(across);
        return norm_sq(across) > 0;
    }

    /// Makes the last sides those of the box in the superquadric's frame.
    void bound(std::vector<Vec3d>& directions, std::size_t max_sides) const
    {
        directions.resize(std::min(directions.size(), max_sides - 6));
        for (int k = 0; k < 3; ++k)
            for (const double sign : {1., -1.}) directions.push_back(sign * beside_.rotation.row[k]);
    }

    const mesh::Mesh& hull_;
    std::span<const Vec3d> corners_;
    const shape::Superquadricd& beside_;
    std::vector<FacetPlane> facets_;  ///< largest first
    std::vector<Vec3d> outside_;
};

/// Volume that a unit of the undeformed shape takes up: of taper (1 + kx z)(1 + ky z), of bend 1 - k r.
double stretch(const shape::Superquadricd& sq, Vec3d q)
{
    const double fx = sq.taper_x * q.z / sq.a.z + 1, fy = sq.taper_y * q.z / sq.a.z + 1;
    if (!sq.is_bent()) return fx * fy;
    return fx * fy * (1 - sq.bend * (std::cos(sq.bend_angle) * fx * q.x + std::sin(sq.bend_angle) * fy * q.y));
}

}  // namespace

bool is_bounded(std::span<const Vec3d> directions)
{
    const mesh::Mesh hull = mesh::convex_hull(directions);
    return !hull.triangles.empty() && std::all_of(hull.triangles.begin(), hull.triangles.end(), [&](const mesh::Triangle& t) {
        const Vec3d a = hull.vertices[t[0]], n = cross(hull.vertices[t[1]] - a, hull.vertices[t[2]] - a);
        return dot(n, a) > 1e-3 * norm(n);
    });
}

HalfSpacef touching_side(Vec3d direction, std::span<const Vec3d> points)
{
    HalfSpacef side{cast<float>(normalized(direction)), 0};
    const Vec3d n = cast<double>(side.normal);
    double support = -std::numeric_limits<double>::infinity();
    Vec3d largest{};
    for (const Vec3d& p : points) {
        support = std::max(support, dot(n, p));
        for (int k = 0; k < 3; ++k) largest[k] = std::max(largest[k], std::abs(p[k]));
    }
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += std::abs(n[k]) * largest[k];
    side.offset = rounded_up(support + 4 * k_float_unit * sum + 0x1.0p-120);
    return side;
}

std::vector<Vec3d> spread_points(std::size_t count)
{
    constexpr double k_root = 1.2207440846057594754;  // k_root^4 = k_root + 1
    const auto part = [](double v) { return v - std::floor(v); };
    std::vector<Vec3d> points;
    for (std::size_t k = 0; k < count; ++k) {
        const double n = static_cast<double>(k) + 0.5;
        points.push_back({part(n / k_root), part(n / (k_root * k_root)), part(n / (k_root * k_root * k_root))});
    }
    return points;
}

std::vector<InteriorPoint> interior_points(const shape::Superquadricd& sq, std::size_t tries)
{
    std::vector<InteriorPoint> points;
    double sum = 0;
    for (const Vec3d& at : spread_points(tries)) {
        const Vec3d q{sq.a.x * (2 * at.x - 1), sq.a.y * (2 * at.y - 1), sq.a.z * (2 * at.z - 1)};
        if (shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, q) > 1) continue;
        const double weight = stretch(sq, q);
        points.push_back({shape::to_model(sq, shape::deform(sq, q)), weight});
        sum += weight;
    }
    const double unit = sum > 0 ? volume(sq) / sum : 0;
    for (InteriorPoint& p : points) p.weight *= unit;
    return points;
}

std::vector<HalfSpacef> bounding_polytope(const mesh::Mesh& hull, std::span<const Vec3d> points,
                                          const shape::Superquadricd& beside, const PolytopeOptions& options)
{
    std::vector<HalfSpacef> sides;
    for (const Vec3d& d : SideChooser(hull, points, beside, options).run(options.max_sides))
        sides.push_back(touching_side(d, points));
    return sides;
}

}  // namespace sqmap::fit
