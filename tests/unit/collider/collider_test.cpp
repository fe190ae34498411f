#include "collider/numbers.h"
#include "collider/searches.h"
#include "collider/spheres.h"
#include "math/predicates.h"
#include "math/random.h"
#include "mesh/convex_hull.h"
#include "sqmap/collider/export.h"
#include "sqmap/math/rotation.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/mesh/solid.h"
#include "support/small_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace sqmap::collider {
namespace {

constexpr Kind k_enclosing[] = {Kind::Box, Kind::Sphere, Kind::Ellipsoid, Kind::Capsule, Kind::Cylinder, Kind::Hull};

std::vector<Vec3d> cloud(unsigned seed, std::size_t count, Vec3d stretch, Vec3d shift)
{
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const Mat3d turn = rotation_by({normal(random), normal(random), normal(random)});
    std::vector<Vec3d> out;
    for (std::size_t i = 0; i < count; ++i)
        out.push_back(turn * Vec3d{stretch.x * normal(random), stretch.y * normal(random), stretch.z * normal(random)} + shift);
    return out;
}

/// In 64 bits of mantissa: the shape's equation at a point, at most 1 within.
long double equation(const Shape& s, Vec3d p)
{
    using Real = long double;
    const Real r = s.rpy.x, q = s.rpy.y, y = s.rpy.z;
    const Real cr = std::cos(r), sr = std::sin(r), cp = std::cos(q), sp = std::sin(q), cy = std::cos(y), sy = std::sin(y);
    const Real m[3][3] = {{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
                          {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
                          {-sp, cp * sr, cp * cr}};
    Real local[3];
    for (int k = 0; k < 3; ++k) {
        local[k] = 0;
        for (int i = 0; i < 3; ++i) local[k] += m[i][k] * (static_cast<Real>(p[i]) - static_cast<Real>(s.xyz[i]));
    }
    const Real a = std::abs(local[0]), b = std::abs(local[1]), c = std::abs(local[2]), around = std::sqrt(a * a + b * b);
    switch (s.kind) {
        case Kind::Box:
            return std::max({a / s.size.x, b / s.size.y, c / s.size.z});
        case Kind::Capsule:
            return std::hypot(around, std::max(Real(0), c - s.size.z)) / s.size.x;
        case Kind::Cylinder:
            return std::max(around / s.size.x, c / s.size.z);
        default:
            return std::sqrt(a * a / s.size.x / s.size.x + b * b / s.size.y / s.size.y + c * c / s.size.z / s.size.z);
    }
}

/// By exact signs.
bool hull_holds(const mesh::Mesh& hull, Vec3d p)
{
    return std::none_of(hull.triangles.begin(), hull.triangles.end(), [&](const mesh::Triangle& t) {
        return orient3d(hull.vertices[t[0]], hull.vertices[t[1]], hull.vertices[t[2]], p) < 0;
    });
}

}  // namespace

TEST(ColliderNumbers, RoundingUpGivesNineDigitsThatAreNotBelow)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<double> exponent(-12, 12);
    for (int i = 0; i < 20000; ++i) {
        const double v = std::pow(10, exponent(random)), up = rounded_up(v);
        ASSERT_GE(up, v);
        ASSERT_LE(up, v * (1 + 2.1e-8));
        char digits[40];
        std::snprintf(digits, sizeof digits, "%.8e", up);
        ASSERT_EQ(std::strtod(digits, nullptr), up);
    }
    EXPECT_EQ(rounded_up(0), 0);
    EXPECT_EQ(rounded_up(1), 1);
}

TEST(Colliders, AttitudesSurviveTheirAngles)
{
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 300; ++i) {
        Mat3d m = rotation_by({normal(random), normal(random), normal(random)});
        if (i < 4) m = rotation_of_rpy({0.3 * i, i % 2 == 0 ? std::numbers::pi / 2 : -std::numbers::pi / 2, 0.7});
        const Mat3d back = rotation_of_rpy(rpy_of(m));
        for (int k = 0; k < 3; ++k) ASSERT_LT(norm(back.row[k] - m.row[k]), 1e-8);
    }
}

TEST(Colliders, EveryShapeHoldsEveryPointAsWritten)
{
    for (unsigned seed = 0; seed < 3; ++seed)
        for (const Vec3d& shift : {Vec3d{}, Vec3d{1000, -2000, 500}})
            for (const double scale : {1e-3, 1., 1e4}) {
                const std::vector<Vec3d> points = cloud(seed, 60, scale * Vec3d{1, 0.5, 0.2}, shift);
                for (const Kind kind : k_enclosing) {
                    const Shape s = enclosing(kind, points);
                    for (const Vec3d& p : points) {
                        if (kind == Kind::Hull)
                            ASSERT_TRUE(hull_holds(s.hull, p)) << seed;
                        else
                            ASSERT_LE(equation(s, p), 1) << name_of(kind) << " " << seed << " " << scale;
                    }
                    const Shape hull = as_hull(s, points);
                    for (const Vec3d& p : points) ASSERT_TRUE(hull_holds(hull.hull, p)) << name_of(kind);
                    ASSERT_LE(volume(hull), 1.6 * volume(s)) << name_of(kind);
                }
            }
}

TEST(Colliders, FlatPointsGetThinShapes)
{
    std::vector<Vec3d> plane = cloud(1, 30, {1, 1, 0}, {2, 0, 0}), line = cloud(2, 30, {1, 0, 0}, {}), point(3, Vec3d{1, 2, 3});
    for (const std::vector<Vec3d>& points : {plane, line, point})
        for (const Kind kind : k_enclosing) {
            const Shape s = enclosing(kind, points);
            EXPECT_GT(volume(s), 0) << name_of(kind);
            if (kind == Kind::Hull) continue;
            for (const Vec3d& p : points) ASSERT_LE(equation(s, p), 1) << name_of(kind);
        }
}

TEST(Colliders, ShapesOfTheirOwnKindAreFound)
{
    const Mat3d turn = rotation_by({0.4, -1.1, 0.7});
    const auto moved = [&](std::vector<Vec3d> points) {
        for (Vec3d& p : points) p = turn * p + Vec3d{0.3, 2, -1};
        return points;
    };
    std::vector<Vec3d> box, capsule, cylinder;
    for (int i = 0; i < 8; ++i) box.push_back({(i & 1) != 0 ? 1. : -1., (i & 2) != 0 ? 2. : -2., (i & 4) != 0 ? 0.5 : -0.5});
    for (const Vec3d& v : mesh::sphere(0.5, 3).vertices)
        for (const double at : {1.5, -1.5})
            if (at * v.z >= 0) capsule.push_back(v + Vec3d{0, 0, at});
    for (int i = 0; i < 64; ++i)
        for (const double z : {0.8, -0.8})
            cylinder.push_back({std::cos(i * std::numbers::pi / 32), std::sin(i * std::numbers::pi / 32), z});
    const double pi = std::numbers::pi;
    EXPECT_LE(volume(enclosing(Kind::Box, moved(box))), 8 * 1.001);
    EXPECT_LE(volume(enclosing(Kind::Sphere, moved(mesh::sphere(1, 3).vertices))), 4 * pi / 3 * 1.001);
    EXPECT_LE(volume(enclosing(Kind::Ellipsoid, moved(mesh::ellipsoid({1, 2, 0.4}, 3).vertices))), 4 * pi / 3 * 0.8 * 1.002);
    EXPECT_LE(volume(enclosing(Kind::Capsule, moved(capsule))), pi * 0.25 * (3 + 2. / 3) * 1.02);
    EXPECT_LE(volume(enclosing(Kind::Cylinder, moved(cylinder))), pi * 1.6 * 1.02);
    // The ellipsoid of least volume about a box has semi-axes sqrt(3) times the half lengths.
    EXPECT_NEAR(volume(enclosing(Kind::Ellipsoid, moved(box))), 4 * pi / 3 * std::pow(3, 1.5),
                4 * pi / 3 * std::pow(3, 1.5) * 0.002);
    // A regular tetrahedron's least box is the cube whose face diagonals its edges are.
    const std::vector<Vec3d> tetrahedron{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    EXPECT_LE(volume(enclosing(Kind::Box, moved(tetrahedron))), 8 * 1.001);
    EXPECT_NEAR(volume(enclosing(Kind::Sphere, moved(tetrahedron))), 4 * pi / 3 * std::pow(3, 1.5), 0.02);
}

TEST(Colliders, NoTurnOfAGridGivesABoxOrACapsuleTwoPercentSmaller)
{
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (unsigned seed = 20; seed < 26; ++seed) {
        const std::vector<Vec3d> points = cloud(seed, 40, {1, 0.6, 0.3}, {});
        const double box = volume(enclosing(Kind::Box, points)), capsule = volume(enclosing(Kind::Capsule, points));
        double least_box = INFINITY, least_capsule = INFINITY;
        for (int i = 0; i < 30000; ++i) {
            const Mat3d m = rotation_by({3 * normal(random), 3 * normal(random), 3 * normal(random)});
            Vec3d lo{INFINITY, INFINITY, INFINITY}, hi = -lo;
            for (const Vec3d& p : points)
                for (int k = 0; k < 3; ++k) {
                    lo[k] = std::min(lo[k], dot(m.row[k], p));
                    hi[k] = std::max(hi[k], dot(m.row[k], p));
                }
            const Vec3d size = hi - lo, middle = 0.5 * (hi + lo);
            least_box = std::min(least_box, size.x * size.y * size.z);
            // About the box's middle, give or take, with a radius from the least on.
            const double at_x = middle.x + 0.1 * normal(random), at_y = middle.y + 0.1 * normal(random);
            double radius = 0;
            for (const Vec3d& p : points) radius = std::max(radius, std::hypot(dot(m.row[0], p) - at_x, dot(m.row[1], p) - at_y));
            radius *= 1 + 0.1 * std::abs(normal(random));
            double from = INFINITY, to = -INFINITY;
            for (const Vec3d& p : points) {
                const double around = std::hypot(dot(m.row[0], p) - at_x, dot(m.row[1], p) - at_y);
                const double cap = std::sqrt(std::max(0., radius * radius - around * around)), z = dot(m.row[2], p);
                from = std::min(from, z + cap);
                to = std::max(to, z - cap);
            }
            least_capsule =
                std::min(least_capsule, std::numbers::pi * radius * radius * (std::max(0., to - from) + 4 * radius / 3));
        }
        EXPECT_LE(box, 1.02 * least_box) << seed;
        EXPECT_LE(capsule, 1.02 * least_capsule) << seed;
    }
}

TEST(ColliderFigures, AreThoseOfClosedForms)
{
    const mesh::Mesh ball = mesh::sphere(1, 4);
    const Shape box = enclosing(Kind::Box, ball.vertices);
    const Figures f = figures_of({&box, 1}, {.points = ball.vertices, .volume = 4 * std::numbers::pi / 3, .solid = &ball});
    EXPECT_NEAR(f.volume_ratio, 6 / std::numbers::pi, 0.02);
    EXPECT_NEAR(f.support_excess, std::sqrt(3.) - 1, 0.01);
    EXPECT_NEAR(f.protrusion, std::sqrt(3.) - 1, 0.05);
    // A torus's hull fills its hole: what is farthest is the middle of the hole's lids.
    const mesh::Mesh torus = mesh::torus({.major_radius = 1, .minor_radius = 0.25});
    const Shape hull = enclosing(Kind::Hull, torus.vertices);
    const Figures t = figures_of({&hull, 1}, {.points = torus.vertices, .volume = 1, .solid = &torus});
    EXPECT_LT(t.support_excess, 1e-12);
    EXPECT_NEAR(t.protrusion, std::hypot(1, 0.25) - 0.25, 0.03);
    // An ellipsoid is searched: a ball of radius 1 about semi-axes 1, 0.5, 0.25 exceeds along the shortest.
    const mesh::Mesh flat = mesh::ellipsoid({1, 0.5, 0.25}, 4);
    const Shape about{.kind = Kind::Ellipsoid, .size = {1, 1, 1}};
    EXPECT_NEAR(figures_of({&about, 1}, {.points = flat.vertices}).support_excess, 0.75, 0.01);
}

TEST(ColliderSupport, IsTheGreatestProductWithAPointOfTheSurface)
{
    std::mt19937 random(8);
    std::normal_distribution<double> normal;
    for (int kind = 0; kind <= static_cast<int>(Kind::Superquadric); ++kind) {
        Shape s{.kind = static_cast<Kind>(kind), .xyz = {1, 2, 3}, .rpy = {0.2, 0.5, -1}, .size = {0.7, 0.7, 0.9}};
        if (s.kind == Kind::Sphere) s.size.z = 0.7;
        if (s.kind == Kind::Hull) s = enclosing(Kind::Hull, cloud(3, 30, {1, 1, 1}, {}));
        s.superquadric = {
            .a = {1, 0.5, 2}, .eps1 = 0.4, .eps2 = 1.3, .rotation = rotation_by({1, 0, 0.4}), .translation = {1, 0, 0}};
        const Support support(s);
        const Outside outside(s);
        const std::vector<Vec3d> surface = surface_of(s).vertices;
        for (const Vec3d& p : surface) ASSERT_LT(outside(p), 1e-6) << name_of(s.kind);
        for (int i = 0; i < 200; ++i) {
            const Vec3d u = normalized(Vec3d{normal(random), normal(random), normal(random)});
            double greatest = -INFINITY;
            for (const Vec3d& p : surface) greatest = std::max(greatest, dot(u, p));
            ASSERT_GE(support(u), greatest - 1e-9) << name_of(s.kind);
            ASSERT_LE(support(u), greatest + 0.06) << name_of(s.kind);
            ASSERT_LE(outside(3. * u + Vec3d{1, 2, 3}), norm(3. * u + Vec3d{1, 2, 3} - surface[0]) + 1e-9);
        }
    }
}

TEST(CoveringSpheres, HoldEveryPointOfTheSolidAndReachOutLessTheMoreThereAre)
{
    const mesh::Mesh torus = mesh::torus({.major_radius = 1, .minor_radius = 0.3, .major_segments = 32, .minor_segments = 12});
    const mesh::Solid solid(torus);
    std::mt19937 random(9);
    std::uniform_real_distribution<double> at(-1.3, 1.3);
    double before = INFINITY;
    for (const std::size_t count : {std::size_t{1}, std::size_t{6}, std::size_t{16}}) {
        const std::vector<Shape> balls = covering_spheres(torus, {}, count);
        ASSERT_EQ(balls.size(), count);
        const auto holds = [&](Vec3d p) {
            return std::any_of(balls.begin(), balls.end(), [&](const Shape& b) { return equation(b, p) <= 1; });
        };
        for (const Vec3d& v : torus.vertices) ASSERT_TRUE(holds(v));
        for (int i = 0; i < 3000; ++i) {
            const Vec3d p{at(random), at(random), at(random) / 3};
            ASSERT_TRUE(!solid.inside(p) || holds(p));
        }
        const double protrusion = figures_of(balls, {.points = torus.vertices, .volume = 1, .solid = &torus}).protrusion;
        EXPECT_LT(protrusion, before);
        before = protrusion;
    }
    EXPECT_LT(before, 0.3);
}

TEST(CoveringSpheres, MoreThanARoundSolidNeedsAreNotMade)
{
    const mesh::Mesh ball = mesh::sphere(1, 3);
    const auto protrusion = [&](std::size_t count) {
        return figures_of(covering_spheres(ball, {}, count), {.points = ball.vertices, .volume = 1, .solid = &ball}).protrusion;
    };
    const double of_one = protrusion(1);
    for (const std::size_t count : {std::size_t{3}, std::size_t{4}, std::size_t{7}})
        EXPECT_LE(protrusion(count), of_one) << count;
}

TEST(CoveringSpheres, OfABoxAreAsSmallAsThoseOfALatticeWhereverItLies)
{
    for (const double away : {0., 1e5}) {
        const Vec3d lo{away, -away, away};
        const mesh::Mesh box = test::box(lo, lo + Vec3d{1, 1, 1});
        const std::vector<Shape> balls = covering_spheres(box, {}, 8);
        const double protrusion = figures_of(balls, {.points = box.vertices, .volume = 1, .solid = &box}).protrusion;
        EXPECT_LE(protrusion, (std::sqrt(3.) - 1) / 4 + 0.005) << away;  // of a ball about an eighth
    }
}

TEST(LeastBall, OfASquareAndOfPointsOnALineIsFinite)
{
    const Vec3d square[] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    EXPECT_NEAR(least_ball(square).radius, std::sqrt(0.5), 1e-12);
    const Vec3d line[] = {{1e6, 0, 0}, {1e6 + 1, 0, 0}, {1e6 + 2, 0, 0}, {1e6 + 4, 0, 0}};
    EXPECT_NEAR(least_ball(line).radius, 2, 1e-9);
}

TEST(ExportNames, AreReadWhateverTheirCase)
{
    EXPECT_EQ(format_named("URDF"), Format::Urdf);
    EXPECT_FALSE(format_named("usd"));
    EXPECT_EQ(choice_named("Capsule")->kind, Kind::Capsule);
    EXPECT_EQ(choice_named("spheres:64")->spheres, 64u);
    for (const char* wrong : {"", "spheres", "spheres:", "spheres:0", "spheres:-1", "spheres:5000", "spheres:3x", "cone"})
        EXPECT_FALSE(choice_named(wrong)) << wrong;
}

}  // namespace sqmap::collider
