#include "fit/polytope.h"

#include "mesh/convex_hull.h"
#include "sqmap/fit/fit.h"
#include "sqmap/mesh/shapes.h"

#include "unit/fit/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::fit {
namespace {

using namespace test;

std::vector<Vec3d> float_points(std::mt19937& random, std::size_t count, double size, Vec3d shift)
{
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < count; ++i)
        points.push_back(cast<double>(
            cast<float>(shift + size * Vec3d{uniform(random, -1, 1), uniform(random, -0.7, 0.7), uniform(random, -0.4, 0.4)})));
    return points;
}

std::vector<HalfSpaced> in_double(const std::vector<HalfSpacef>& sides)
{
    std::vector<HalfSpaced> out;
    for (const HalfSpacef& side : sides) out.push_back(cast<double>(side));
    return out;
}

/// The sum of products in every order, with and without fused multiply-add.
std::vector<float> evaluations(Vec3f n, Vec3f p)
{
    const float x = n.x * p.x, y = n.y * p.y, z = n.z * p.z;
    return {(x + y) + z,
            x + (y + z),
            (x + z) + y,
            std::fma(n.x, p.x, std::fma(n.y, p.y, z)),
            std::fma(n.z, p.z, std::fma(n.y, p.y, x)),
            std::fma(n.y, p.y, std::fma(n.z, p.z, x))};
}

TEST(TouchingSide, HoldsFloatPointsOfTheHullHoweverTheSumIsEvaluated)
{
    std::mt19937 random(4);
    int touching = 0;
    for (int k = 0; k < 300; ++k) {
        const double size = std::pow(10., uniform(random, -4, 4));
        const std::vector<Vec3d> points = float_points(random, 30, size, {uniform(random, -5, 5) * size, 0, size});
        const Vec3d direction{uniform(random, -1, 1), uniform(random, -1, 1), k % 3 == 0 ? 0 : uniform(random, -1, 1)};
        const HalfSpacef side = touching_side(direction, points);
        EXPECT_NEAR(norm(cast<double>(side.normal)), 1, 1e-6);
        double support = -std::numeric_limits<double>::infinity(), largest = 0;
        for (int i = 0; i < 200; ++i) {
            // Corners, and points between three of them that are float as a query's are.
            Vec3d p = points[static_cast<std::size_t>(i) % points.size()];
            if (i >= 30) {
                const double u = uniform(random, 0, 1), v = uniform(random, 0, 1 - u);
                p = u * points[random() % 30] + v * points[random() % 30] + (1 - u - v) * p;
            }
            const Vec3f q = cast<float>(p);
            largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
            if (i < 30) support = std::max(support, dot(cast<double>(side.normal), p));
            // Rounding may have taken a point between corners out of the hull.
            if (i >= 30 && dot(cast<double>(side.normal), cast<double>(q)) > support) continue;
            for (const float value : evaluations(side.normal, q)) ASSERT_LE(value, side.offset);
        }
        const double slack = static_cast<double>(side.offset) - support;
        EXPECT_GT(slack, 0);
        EXPECT_LE(slack, 1e-6 * largest) << "the room for rounding is no more than it needs";
        touching += slack < 6e-7 * largest ? 1 : 0;
    }
    EXPECT_GT(touching, 150);
}

TEST(InteriorPoints, FillTheSuperquadricEvenlyAndWeighItsVolume)
{
    std::mt19937 random(2);
    for (int k = 0; k < 12; ++k) {
        shape::Superquadricd sq;
        sq.a = {0.5, 0.4, 1};
        sq.eps1 = uniform(random, 0.2, 1.8);
        sq.eps2 = uniform(random, 0.2, 1.8);
        sq.rotation = random_rotation(random);
        sq.translation = {1, -2, 3};
        if (k & 1) sq.taper_x = 0.7, sq.taper_y = -0.3;
        if (k & 2) sq.bend = 0.8, sq.bend_angle = 0.6;
        double sum = 0, above = 0, above_of_surface = 0;
        for (const InteriorPoint& p : interior_points(sq, 40000)) {
            ASSERT_LE(shape::implicit(sq, p.point), 1 + 1e-9);
            sum += p.weight;
            above += dot(Vec3d{1, 0, 0}, p.point - sq.translation) * p.weight;
        }
        EXPECT_NEAR(sum, volume(sq), 1e-9 * sum);
        // The first moment, against that of the surface by the divergence theorem.
        const mesh::Mesh surface = tessellate(sq, 60);
        double enclosed = 0;
        for (const mesh::Triangle& t : surface.triangles) {
            const Vec3d a = surface.vertices[t[0]] - sq.translation, b = surface.vertices[t[1]] - sq.translation,
                        c = surface.vertices[t[2]] - sq.translation;
            const double six = dot(a, cross(b, c));
            enclosed += six / 6;
            above_of_surface += six / 24 * (a.x + b.x + c.x);
        }
        EXPECT_NEAR(sum, std::abs(enclosed), 0.02 * sum);
        EXPECT_NEAR(above, above_of_surface * (enclosed > 0 ? 1 : -1), 0.012 * sum);
    }
}

struct Fitted {
    std::vector<Vec3d> points;
    mesh::Mesh hull;
    shape::Superquadricd superquadric;
};
Fitted fitted(const mesh::Mesh& mesh)
{
    return {mesh.vertices, mesh::convex_hull(mesh.vertices), fit_bounding(mesh, all_triangles(mesh), {}).superquadric};
}

TEST(BoundingPolytope, HoldsEveryPointAndBoundsASolid)
{
    std::mt19937 random(7);
    for (const mesh::Mesh& mesh :
         {mesh::sphere(1, 3), mesh::rounded_box({1.2, 0.8, 0.6}, 0.2, 3), mesh::ellipsoid({3, 1, 0.2}, 3),
          mesh::torus({.major_radius = 1, .minor_radius = 0.3, .major_segments = 36, .minor_segments = 16})}) {
        const Fitted f = fitted(mesh);
        for (const std::size_t max_sides : {6u, 12u, 20u, 40u}) {
            const std::vector<HalfSpacef> sides = bounding_polytope(f.hull, f.points, f.superquadric, {.max_sides = max_sides});
            EXPECT_GE(sides.size(), 4u);
            EXPECT_LE(sides.size(), max_sides);
            for (const Vec3d& p : f.points) ASSERT_TRUE(holds(in_double(sides), p));
            const mesh::Mesh polytope = mesh::convex_hull(mesh::polytope_corners(in_double(sides)));
            ASSERT_FALSE(polytope.triangles.empty());
            EXPECT_LE(mesh::farthest_from_hull(polytope, f.points), 1e-6);
            EXPECT_LT(mesh::volume(polytope), 3 * mesh::volume(f.hull));
        }
    }
}

TEST(BoundingPolytope, OfFewFacetsIsTheHull)
{
    // A prism with five sides: seven half-spaces suffice, whatever its superquadric.
    mesh::Mesh prism;
    for (int i = 0; i < 10; ++i) {
        const double angle = 2 * std::numbers::pi * (i % 5) / 5;
        prism.vertices.push_back({std::cos(angle), std::sin(angle), i < 5 ? -0.7 : 0.7});
    }
    const mesh::Mesh hull = mesh::convex_hull(prism.vertices);
    const Fitted f = fitted(hull);
    const mesh::Mesh polytope = mesh::convex_hull(
        mesh::polytope_corners(in_double(bounding_polytope(hull, hull.vertices, f.superquadric, {.max_sides = 20}))));
    EXPECT_NEAR(mesh::volume(polytope), mesh::volume(hull), 1e-3 * mesh::volume(hull));
}

TEST(BoundingPolytope, CutsOffMoreWithMoreSidesAndMoreThanABox)
{
    const Fitted f = fitted(mesh::ellipsoid({1.5, 1, 0.6}, 4));
    double before = std::numeric_limits<double>::infinity();
    for (const std::size_t max_sides : {6u, 12u, 20u, 40u}) {
        const std::vector<HalfSpaced> sides =
            in_double(bounding_polytope(f.hull, f.points, f.superquadric, {.max_sides = max_sides}));
        const double volume = mesh::volume(mesh::convex_hull(mesh::polytope_corners(sides)));
        EXPECT_LT(volume, before) << max_sides;
        before = volume;
    }
    EXPECT_LT(before, 1.15 * mesh::volume(f.hull));
}

TEST(BoundingPolytope, OfWhatHasNoSolidIsAThinSlab)
{
    std::mt19937 random(3);
    std::vector<Vec3d> flat;
    for (int i = 0; i < 40; ++i)
        flat.push_back(cast<double>(cast<float>(Vec3d{uniform(random, -1, 1), uniform(random, -1, 1), 0.5})));
    shape::Superquadricd sq;
    sq.a = {1.5, 1.5, 0.01};
    sq.translation = {0, 0, 0.5};
    const std::vector<HalfSpacef> sides = bounding_polytope(mesh::convex_hull(flat), flat, sq);
    for (const Vec3d& p : flat) EXPECT_TRUE(holds(in_double(sides), p));
    EXPECT_FALSE(holds(in_double(sides), Vec3d{3, 0, 0.5}));
    for (const std::vector<Vec3d>& point : {std::vector<Vec3d>{{1, 2, 3}}, std::vector<Vec3d>{{1, 2, 3}, {2, 2, 3}}})
        for (const Vec3d& p : point) EXPECT_TRUE(holds(in_double(bounding_polytope(mesh::convex_hull(point), point, sq)), p));
}

/// The hull of balls: round everywhere, so that every side has corners to fight for.
Fitted hull_of_balls(std::span<const Vec3d> middles)
{
    std::vector<Vec3d> points;
    for (const Vec3d& middle : middles)
        for (const Vec3d& p : mesh::sphere(0.4, 2).vertices) points.push_back(cast<double>(cast<float>(middle + p)));
    return fitted(mesh::convex_hull(points));
}

double excess(const mesh::Mesh& hull, const std::vector<HalfSpacef>& sides)
{
    return mesh::farthest_from_hull(hull, mesh::polytope_corners(in_double(sides)));
}

TEST(NearerPolytope, HoldsTheSameWithAsManySidesAndLessExcess)
{
    const std::vector<std::vector<Vec3d>> bodies{{{0, 0, 0}, {0, 0, 1}},
                                                 {{0, 0, 0}, {0, 0, 1.5}, {0.7, 0, 1.7}},
                                                 {{0, 0, 0}, {0, 0.2, 1}, {0.9, 0, 1.1}, {0.2, 1.1, 0.3}}};
    for (const std::vector<Vec3d>& middles : bodies) {
        const Fitted f = hull_of_balls(middles);
        const std::vector<HalfSpacef> sides = bounding_polytope(f.hull, f.points, f.superquadric);
        const std::vector<HalfSpacef> nearer = nearer_polytope(f.hull, f.points, sides, f.superquadric.rotation);
        ASSERT_EQ(nearer.size(), sides.size());
        for (const Vec3d& p : f.points) ASSERT_TRUE(holds(in_double(nearer), p));
        const mesh::Mesh polytope = mesh::convex_hull(mesh::polytope_corners(in_double(nearer)));
        ASSERT_FALSE(polytope.triangles.empty());
        EXPECT_LE(mesh::farthest_from_hull(polytope, f.points), 1e-6);
        EXPECT_LT(excess(f.hull, nearer), 0.85 * excess(f.hull, sides)) << middles.size();
        EXPECT_LT(mesh::volume(polytope), 1.15 * mesh::volume(f.hull)) << middles.size();
        EXPECT_EQ(nearer_polytope(f.hull, f.points, sides, f.superquadric.rotation), nearer);
    }
}

TEST(NearerPolytope, OfAPolytopeThatIsTheHullIsNone)
{
    const mesh::Mesh box = mesh::convex_hull(
        std::vector<Vec3d>{{-1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {-1, 1, 1}, {1, -1, -1}, {1, -1, 1}, {1, 1, -1}, {1, 1, 1}});
    std::vector<HalfSpacef> sides;
    for (int k = 0; k < 3; ++k)
        for (const double sign : {-1., 1.}) {
            Vec3d normal{};
            normal[k] = sign;
            sides.push_back(touching_side(normal, box.vertices));
        }
    EXPECT_TRUE(nearer_polytope(box, box.vertices, sides, Mat3d{}).empty());
}

}  // namespace
}  // namespace sqmap::fit
