// Containment of triangles in a superquadric, proven.
//
// f = sqrt(F) of eq. 1 at an undeformed point is a norm: a nested l_p norm with p = 2/eps >= 1. So it is convex and
// subadditive, and grows with each |component|.
//  Undeformed shapes: the map to local coordinates is linear, so f over a triangle is largest at a corner.
//  Deformed shapes: let u be the map that undoes bend and taper and L its linear interpolant on the triangle. Then
//      f(u(p)) <= f(L(p)) + f(u(p) - L(p)) <= largest corner value + f(e),   |u - L| <= e componentwise.
//  Taylor's formula about p gives u(p) - L(p) = -1/2 sum_i l_i D2u(xi_i)[v_i - p, v_i - p], with l the barycentric
//  coordinates. A coordinate that spans a width w over the triangle has sum_i l_i (v_i - p)^2 <= w^2 / 4 (Popoviciu), and
//  Cauchy-Schwarz bounds the mixed sums by products of such "spreads" w / 2. What remains are bounds of first and second
//  derivatives over the triangle's box, in closed form below. e falls with the square of the size: few subdivisions.
#include "sqmap/fit/fit.h"

#include "power_free.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sqmap::fit {
namespace {

constexpr double k_accuracy = 2e-4;  ///< of f: subdivision stops here
constexpr int k_max_depth = 14;
constexpr double k_rounding = 1e-12;  ///< relative allowance for double arithmetic on both sides

struct Interval {
    double low, high;
    double spread() const { return (high - low) / 2; }
    double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
};

Interval hull(double a, double b, double c) { return {std::min({a, b, c}), std::max({a, b, c})}; }
Interval widened(Interval i, double by) { return {i.low - by, i.high + by}; }

/// Spread of each coordinate after the bend is undone, and the greatest distance from its linear interpolant.
struct Straightened {
    Vec3d spread;
    Vec3d deviation;
};

/// q: corners, local. In the bend's plane the map is polar, about the centre of curvature, c = 1/bend away:
/// r = c - rho, z = c gamma. |D rho| = 1, |D gamma| = 1/rho, |D2 rho| <= 1/rho, |D2 gamma| <= 1/rho^2.
Straightened straighten(const shape::Superquadricd& sq, const std::array<Vec3d, 3>& q)
{
    const double ca = std::cos(sq.bend_angle), sa = std::sin(sq.bend_angle), c = 1 / sq.bend;
    const auto along = [&](const Vec3d& v) { return ca * v.x + sa * v.y; };
    const auto across = [&](const Vec3d& v) { return ca * v.y - sa * v.x; };
    const Interval x = hull(c - along(q[0]), c - along(q[1]), c - along(q[2]));
    const Interval z = hull(q[0].z, q[1].z, q[2].z);
    const double w_spread = hull(across(q[0]), across(q[1]), across(q[2])).spread();
    const auto nearest_zero = [](Interval i) { return i.low > 0 ? i.low : (i.high < 0 ? -i.high : 0.0); };
    const double rho = norm(Vec3d{nearest_zero(x), nearest_zero(z), 0});
    // Behind the centre, across z = 0, gamma jumps; at the centre the map is not smooth.
    if (!(rho > 0) || (x.low < 0 && z.low <= 0 && z.high >= 0)) return {{}, {INFINITY, INFINITY, INFINITY}};
    const double s = norm(Vec3d{x.spread(), z.spread(), 0});
    const double r_deviation = s * s / (2 * rho), z_deviation = c * s * s / (2 * rho * rho);
    return {{std::abs(sa) * w_spread + std::abs(ca) * s, std::abs(ca) * w_spread + std::abs(sa) * s, c / rho * s},
            {std::abs(ca) * r_deviation, std::abs(sa) * r_deviation, z_deviation}};
}

/// A point on its way to where the shape is not deformed.
struct CertifiedPoint {
    Vec3d local, straight, undeformed;  ///< straight: its bend undone
    double upper_bound;                 ///< of f, without powers
};
using CertifiedTriangle = std::array<CertifiedPoint, 3>;

/// Finds such points: by the shape without its taper, and without its bend.
class Undoing {
public:
    explicit Undoing(const shape::Superquadricd& sq) : bend_only_(sq), taper_only_(sq), upper_bound_(sq)
    {
        bend_only_.taper_x = bend_only_.taper_y = 0;
        taper_only_.bend = 0;
    }
    CertifiedPoint operator()(Vec3d local) const
    {
        const Vec3d straight = undeform(bend_only_, local), u = undeform(taper_only_, straight);
        return {local, straight, u, upper_bound_(u)};
    }
    CertifiedPoint middle(const CertifiedPoint& a, const CertifiedPoint& b) const { return (*this)(0.5 * (a.local + b.local)); }
    double upper_bound(Vec3d u) const { return upper_bound_(u); }

private:
    shape::Superquadricd bend_only_, taper_only_;
    PowerFreeBound upper_bound_;
};

/// Componentwise bound of |undeform(p) - linear interpolant| over the triangle.
Vec3d interpolation_error(const shape::Superquadricd& sq, const CertifiedTriangle& corners)
{
    const std::array<Vec3d, 3> q{corners[0].local, corners[1].local, corners[2].local};
    Straightened s;
    if (sq.is_bent()) {
        s = straighten(sq, q);
        if (!(s.deviation.z < INFINITY)) return s.deviation;
    } else {
        for (int k = 0; k < 3; ++k) s.spread[k] = hull(q[0][k], q[1][k], q[2][k]).spread();
    }
    if (!sq.is_tapered()) return s.deviation;

    // X / w with w = 1 + g Z. First derivatives 1/w and -g X/w^2; second: XZ -g/w^2, ZZ 2 g^2 X/w^3.
    const Interval z = widened(hull(corners[0].straight.z, corners[1].straight.z, corners[2].straight.z), s.deviation.z);
    const auto taper = [&](int k, double factor) -> double {
        const double g = factor / sq.a.z;
        const double w = 1 + std::min(g * z.low, g * z.high);
        if (!(w > 1e-3)) return INFINITY;
        const Interval across = hull(corners[0].straight[k], corners[1].straight[k], corners[2].straight[k]);
        const double x = widened(across, s.deviation[k]).magnitude();
        const double first_z = std::abs(g) * x / (w * w);
        const double mixed = std::abs(g) / (w * w), second_z = 2 * g * g * x / (w * w * w);
        return s.deviation[k] / w + first_z * s.deviation.z + mixed * s.spread[k] * s.spread.z +
               second_z * s.spread.z * s.spread.z / 2;
    };
    return {taper(0, sq.taper_x), taper(1, sq.taper_y), s.deviation.z};
}

double norm_of(const shape::Superquadricd& sq, Vec3d u)
{
    return std::sqrt(shape::implicit_undeformed(sq.a, sq.eps1, sq.eps2, u));
}

/// Bounds of f over triangles: upper is proven, lower is a value that f takes.
struct Range {
    double lower = 0, upper = 0;
};

void bound(const shape::Superquadricd& sq, const Undoing& undoing, const CertifiedTriangle& corners, int depth, Range& range)
{
    double corner = 0;
    for (const CertifiedPoint& p : corners) {
        double f = p.upper_bound;
        if (f > range.lower) range.lower = std::max(range.lower, f = norm_of(sq, p.undeformed));
        corner = f >= corner ? f : (f < corner ? corner : INFINITY);  // a NaN counts as outside
    }
    if (!(corner < INFINITY)) {
        range.lower = range.upper = INFINITY;
        return;
    }
    const Vec3d e = interpolation_error(sq, corners);
    const bool finite = e.x < INFINITY && e.y < INFINITY && e.z < INFINITY;
    if (finite && corner + undoing.upper_bound(e) < range.upper) return;
    corner =
        std::max({norm_of(sq, corners[0].undeformed), norm_of(sq, corners[1].undeformed), norm_of(sq, corners[2].undeformed)});
    const double upper = finite ? corner + norm_of(sq, e) : INFINITY;
    if (upper <= range.upper) return;
    if (upper <= range.lower + k_accuracy || depth == k_max_depth || !(range.upper < INFINITY)) {
        range.upper = upper;
        return;
    }
    const CertifiedPoint m01 = undoing.middle(corners[0], corners[1]), m12 = undoing.middle(corners[1], corners[2]),
                         m20 = undoing.middle(corners[2], corners[0]);
    bound(sq, undoing, {m01, m12, m20}, depth + 1, range);
    bound(sq, undoing, {corners[0], m01, m20}, depth + 1, range);
    bound(sq, undoing, {m01, corners[1], m12}, depth + 1, range);
    bound(sq, undoing, {m20, m12, corners[2]}, depth + 1, range);
}

}  // namespace

Certificate certify(const shape::Superquadricd& sq, std::span<const Vec3d> points, std::span<const mesh::Triangle> triangles)
{
    Range range;
    const Undoing undoing(sq);
    std::vector<CertifiedPoint> corners;
    corners.reserve(points.size());
    for (const Vec3d& p : points) {
        corners.push_back(undoing(to_local(sq, p)));
        if (corners.back().upper_bound < range.lower) continue;
        const double f = norm_of(sq, corners.back().undeformed);
        range.lower = f >= range.lower ? f : (f < range.lower ? range.lower : INFINITY);
    }
    range.upper = range.lower;
    // All corners first: the greatest of them lets most triangles pass without subdivision.
    if (sq.is_deformed()) {
        for (const mesh::Triangle& t : triangles) {
            const CertifiedTriangle of{corners[t[0]], corners[t[1]], corners[t[2]]};
            const double corner = std::max({of[0].upper_bound, of[1].upper_bound, of[2].upper_bound});
            if (corner < range.upper && corner + undoing.upper_bound(interpolation_error(sq, of)) < range.upper) continue;
            bound(sq, undoing, of, 0, range);
        }
    }

    // Bending far from its centre of curvature loses digits: an error of 1/bend roundings in r and z.
    const double lost = sq.is_bent() ? 4e-16 / sq.bend / std::min({sq.a.x, sq.a.y, sq.a.z}) : 0;
    const double upper = (range.upper + lost) * (1 + k_rounding);
    Certificate certificate;
    certificate.largest_f = upper * upper;
    certificate.tolerance = certificate.largest_f - range.lower * range.lower;
    certificate.bounding = certificate.largest_f <= 1;
    return certificate;
}

Certificate certify(const shape::Superquadricd& sq, std::span<const std::array<Vec3d, 3>> triangles)
{
    std::vector<Vec3d> points;
    std::vector<mesh::Triangle> faces;
    for (const std::array<Vec3d, 3>& t : triangles) {
        const auto first = static_cast<std::uint32_t>(points.size());
        faces.push_back({first, first + 1, first + 2});
        points.insert(points.end(), t.begin(), t.end());
    }
    return certify(sq, points, faces);
}

double float_margin(const shape::Superquadricd& sq)
{
    // Coordinates of a point of the shape are off by a few units of the last place of the largest number met on the way:
    // the point itself, and, where bent, the radius of curvature. f, a norm, turns that into its own error.
    const double k_ulp = 6e-8;
    const double reach = norm(sq.translation) + norm(sq.a);
    double error = 4 * k_ulp * reach;
    if (sq.is_bent()) error += 4 * k_ulp / sq.bend;
    Vec3d e{error, error, error};
    e.x /= 1 - std::abs(sq.taper_x);
    e.y /= 1 - std::abs(sq.taper_y);
    return 1e-5 + 2 * norm_of(sq, e);
}

}  // namespace sqmap::fit
