#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace sqmap::mesh {
namespace {

using std::numbers::pi;

/// Euler characteristic of a closed manifold mesh; a failure is recorded when it is not one: every directed edge once,
/// its opposite too, and one fan of triangles around each vertex.
int euler_of_closed_manifold(const Mesh& mesh)
{
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
    std::vector<std::map<std::uint32_t, std::uint32_t>> next(mesh.vertices.size());  // around each vertex
    for (const Triangle& t : mesh.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            ++directed[{t[i], t[(i + 1) % 3]}];
            next[t[i]][t[(i + 1) % 3]] = t[(i + 2) % 3];
        }
    for (const auto& [edge, count] : directed) {
        EXPECT_EQ(count, 1);
        EXPECT_TRUE(directed.contains({edge.second, edge.first}));
    }
    for (const auto& fan : next) {
        if (fan.empty()) {
            ADD_FAILURE() << "unused vertex";
            continue;
        }
        std::size_t steps = 0;
        std::uint32_t at = fan.begin()->first;
        do {
            at = fan.contains(at) ? fan.at(at) : fan.begin()->first;
            ++steps;
        } while (at != fan.begin()->first && steps <= fan.size());
        EXPECT_EQ(steps, fan.size());
    }
    return static_cast<int>(mesh.vertices.size()) - static_cast<int>(directed.size() / 2) +
           static_cast<int>(mesh.triangles.size());
}

double least_height(const Mesh& mesh)
{
    double least = 1e300;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const double longest =
            std::sqrt(std::max({norm_sq(mesh.vertices[a] - mesh.vertices[b]), norm_sq(mesh.vertices[b] - mesh.vertices[c]),
                                norm_sq(mesh.vertices[c] - mesh.vertices[a])}));
        least = std::min(least, 2 * triangle_area(mesh, t) / (longest * longest));
    }
    return least;
}

/// Volume of a superellipsoid (Jaklic, Leonardis and Solina 2000): 2 a1 a2 a3 e1 e2 B(e1/2 + 1, e1) B(e2/2, e2/2).
double superellipsoid_volume(Vec3d a, double e1, double e2)
{
    return 2 * a.x * a.y * a.z * e1 * e2 * std::beta(e1 / 2 + 1, e1) * std::beta(e2 / 2, e2 / 2);
}

TEST(Shapes, AreClosedManifoldsWithTheRightNumberOfHandlesAndNoFlatTriangle)
{
    const shape::Superquadricd pillow{
        .a = {0.6, 0.8, 1.2}, .eps1 = 0.5, .eps2 = 1.7, .taper_x = 0.4, .taper_y = -0.3, .bend = 0.3};
    const std::pair<Mesh, int> cases[] = {{sphere(1, 2), 2},
                                          {ellipsoid({3, 1, 0.5}, 3), 2},
                                          {rounded_box({1.2, 0.8, 0.6}, 0.2, 4), 2},
                                          {torus(), 0},
                                          {dumbbell(), 2},
                                          {superquadric_surface(pillow, 9), 2},
                                          {polygonized(hand_capsules(), 0.03), 2},
                                          {loop_subdivided(torus({.major_segments = 9, .minor_segments = 5}), 2), 0}};
    for (const auto& [mesh, euler] : cases) {
        EXPECT_EQ(euler_of_closed_manifold(mesh), euler);
        EXPECT_GT(volume(mesh), 0);
        EXPECT_GT(least_height(mesh), 1e-3);
        const Mesh sorted = canonicalized(mesh);
        EXPECT_EQ(sorted.vertices, mesh.vertices);
        EXPECT_EQ(sorted.triangles, mesh.triangles);
    }
}

TEST(Shapes, SphereApproachesItsVolumeAndAreaAtSecondOrder)
{
    const double coarse_volume = 4 * pi / 3 * 8 - volume(sphere(2, 3)), fine_volume = 4 * pi / 3 * 8 - volume(sphere(2, 4));
    EXPECT_NEAR(coarse_volume / fine_volume, 4, 0.1);
    EXPECT_LT(fine_volume, 0.1);
    const double coarse_area = 16 * pi - surface_area(sphere(2, 3)), fine_area = 16 * pi - surface_area(sphere(2, 4));
    EXPECT_NEAR(coarse_area / fine_area, 4, 0.1);
}

TEST(Shapes, EllipsoidHasItsVolume)
{
    EXPECT_NEAR(volume(ellipsoid({3, 1, 0.5}, 5)), 4 * pi / 3 * 1.5, 0.003 * 4 * pi / 3 * 1.5);
}

TEST(Shapes, RoundedBoxFollowsSteiner)
{
    // Inner box 2x, 2y, 2z swept by a ball: volume + area r + mean-width term pi r^2 (x+y+z) 2 + ball.
    const double x = 1.0, y = 0.6, z = 0.4, r = 0.2;
    const double exact = 8 * x * y * z + 8 * (x * y + y * z + z * x) * r + 2 * pi * r * r * (x + y + z) + 4 * pi / 3 * r * r * r;
    const double exact_area = 8 * (x * y + y * z + z * x) + 4 * pi * r * (x + y + z) + 4 * pi * r * r;
    const Mesh box = rounded_box({x + r, y + r, z + r}, r, 12);
    EXPECT_NEAR(volume(box), exact, 0.002 * exact);
    EXPECT_NEAR(surface_area(box), exact_area, 0.002 * exact_area);
}

TEST(Shapes, TorusFollowsPappus)
{
    const Mesh mesh = torus({.major_radius = 2, .minor_radius = 0.5, .major_segments = 200, .minor_segments = 100});
    EXPECT_NEAR(volume(mesh), 2 * pi * pi * 2 * 0.25, 0.001 * pi * pi);
    EXPECT_NEAR(surface_area(mesh), 4 * pi * pi * 2 * 0.5, 0.001 * 4 * pi * pi);
}

TEST(Shapes, DumbbellIsTwoCappedBallsAndABar)
{
    const double big = 1, bar = 0.35, d = 1.8, h = big - std::sqrt(big * big - bar * bar);
    const double cap = pi * h * h * (3 * big - h) / 3;
    const double exact = 2 * (4 * pi / 3 - cap) + pi * bar * bar * 2 * (d - big + h);
    EXPECT_NEAR(volume(dumbbell({.ball_radius = big, .bar_radius = bar, .half_distance = d, .segments = 160})), exact,
                0.002 * exact);
}

TEST(Shapes, SuperquadricsHaveTheirVolumeAlsoTaperedAndBent)
{
    for (const double e1 : {0.4, 1.0, 1.6})
        for (const double e2 : {0.5, 1.0, 1.8}) {
            shape::Superquadricd sq{.a = {0.6, 0.8, 1.2}, .eps1 = e1, .eps2 = e2};
            const double exact = superellipsoid_volume(sq.a, e1, e2);
            EXPECT_NEAR(volume(superquadric_surface(sq, 48)), exact, 0.006 * exact) << e1 << ' ' << e2;

            // Bending moves matter around a centre: in proportion to its distance, which averages to one.
            sq.bend = 0.4;
            sq.bend_angle = 0.7;
            EXPECT_NEAR(volume(superquadric_surface(sq, 48)), exact, 0.006 * exact) << e1 << ' ' << e2;

            // Tapering scales the slice at height z by (1 + Kx z/a3)(1 + Ky z/a3): the odd terms cancel and the even one
            // is Kx Ky times the mean of (z/a3)^2. A slice's area goes as (1 - |z/a3|^(2/e1))^e1.
            sq.taper_x = 0.5;
            sq.taper_y = -0.6;
            const double mean_sq = std::beta(1.5 * e1, e1 + 1) / std::beta(0.5 * e1, e1 + 1);
            const double tapered = exact * (1 + sq.taper_x * sq.taper_y * mean_sq);
            sq.bend = 0;
            EXPECT_NEAR(volume(superquadric_surface(sq, 48)), tapered, 0.006 * tapered) << e1 << ' ' << e2;
        }
}

TEST(Shapes, SuperquadricVerticesSatisfyEquationOne)
{
    const shape::Superquadricd sq{.a = {0.6, 0.8, 1.2},
                                  .eps1 = 0.3,
                                  .eps2 = 1.4,
                                  .translation = {3, 2, 1},
                                  .taper_x = 0.4,
                                  .taper_y = -0.3,
                                  .bend = 0.3,
                                  .bend_angle = 1.1};
    for (const Vec3d& v : superquadric_surface(sq, 12).vertices) EXPECT_NEAR(shape::implicit(sq, v), 1, 1e-9);
}

TEST(Shapes, PolygonizedVerticesLieOnTheFieldAndTheVolumeMatchesCounting)
{
    const CapsuleSolid hand = hand_capsules();
    const Mesh mesh = polygonized(hand, 0.02);
    for (const Vec3d& v : mesh.vertices) EXPECT_NEAR(field(hand, v), 0, 1e-5);

    Vec3d lo = mesh.vertices.front(), hi = lo;
    for (const Vec3d& v : mesh.vertices)
        for (int i = 0; i < 3; ++i) {
            lo[i] = std::min(lo[i], v[i]);
            hi[i] = std::max(hi[i], v[i]);
        }
    const double step = 0.008;
    int inside = 0;
    for (double x = lo.x; x < hi.x; x += step)
        for (double y = lo.y; y < hi.y; y += step)
            for (double z = lo.z; z < hi.z; z += step) inside += field(hand, {x, y, z}) < 0;
    const double counted = inside * step * step * step;
    EXPECT_NEAR(volume(mesh), counted, 0.01 * counted);
}

TEST(Shapes, LoopSubdivisionKeepsTheCentreOfASymmetricShapeAndTheAffineImage)
{
    const Mesh base = sphere(1, 1);
    Mesh moved = base;
    const auto affine = [](Vec3d p) { return Vec3d{2 * p.x + p.y + 3, p.y - 0.5 * p.z, p.z + 1}; };
    for (Vec3d& v : moved.vertices) v = affine(v);
    const Mesh a = loop_subdivided(base, 2), b = loop_subdivided(canonicalized(moved), 2);
    EXPECT_EQ(a.triangles.size(), 16 * base.triangles.size());
    EXPECT_NEAR(volume(b), 2 * volume(a), 1e-9);  // the affine map's determinant is 2
    Vec3d mean{};
    for (const Vec3d& v : a.vertices) mean += v / static_cast<double>(a.vertices.size());
    EXPECT_NEAR(norm(mean), 0, 1e-12);
}

TEST(Shapes, LoopSubdivisionRefusesAnOpenMesh)
{
    Mesh open = sphere(1, 1);
    open.triangles.pop_back();
    EXPECT_THROW((void)loop_subdivided(open, 1), std::invalid_argument);
}

TEST(Shapes, ImpossibleSizesAreRefused)
{
    EXPECT_THROW((void)sphere(-1, 2), std::invalid_argument);
    EXPECT_THROW((void)rounded_box({1, 1, 1}, 1.0, 4), std::invalid_argument);
    EXPECT_THROW((void)torus({.major_radius = 1, .minor_radius = 1}), std::invalid_argument);
    EXPECT_THROW((void)polygonized({}, 0.1), std::invalid_argument);
}

}  // namespace
}  // namespace sqmap::mesh
