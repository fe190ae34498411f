#include "sqmap/fit/fit.h"

#include "unit/fit/shapes.h"

#include <gtest/gtest.h>

#include <limits>

namespace sqmap::fit {
namespace {

using namespace test;
using Corners = std::array<Vec3d, 3>;

shape::Superquadricd random_shape(std::mt19937& random, bool tapered, bool bent)
{
    shape::Superquadricd sq;
    sq.a = {uniform(random, 0.3, 0.6), uniform(random, 0.3, 0.6), uniform(random, 0.8, 1.5)};
    sq.eps1 = uniform(random, 0.1, 2);
    sq.eps2 = uniform(random, 0.1, 2);
    sq.rotation = random_rotation(random);
    sq.translation = {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
    if (tapered) {
        sq.taper_x = uniform(random, -0.9, 0.9);
        sq.taper_y = uniform(random, -0.9, 0.9);
    }
    if (bent) {
        sq.bend = uniform(random, 0.05, 0.6);
        sq.bend_angle = uniform(random, -3, 3);
    }
    return sq;
}

TEST(Certify, BoundsDenseSamplesOfRandomTrianglesWithinItsTolerance)
{
    std::mt19937 random(1);
    int deformed_inside = 0;
    for (int k = 0; k < 200; ++k) {
        const auto sq = random_shape(random, k & 1, k & 2);
        std::vector<Corners> triangles(3);
        const double reach = uniform(random, 0.1, 1.2);
        for (auto& t : triangles)
            for (Vec3d& v : t) {
                const Vec3d u{uniform(random, -1, 1) * sq.a.x, uniform(random, -1, 1) * sq.a.y, uniform(random, -1, 1) * sq.a.z};
                v = deform(sq, reach * u);
            }
        const Certificate c = certify(sq, triangles);
        const double dense = dense_largest_f(sq, triangles, 60);
        EXPECT_GE(c.largest_f, dense) << "shape " << k;
        EXPECT_EQ(c.bounding, c.largest_f <= 1);
        if (std::isfinite(c.largest_f))
            EXPECT_LE(c.largest_f - c.tolerance, dense * 1.02) << "the bound less its tolerance is a value that F takes";
        if (c.bounding) {
            EXPECT_LE(dense, 1);
            EXPECT_LE(c.tolerance, 5e-4);
            deformed_inside += sq.is_deformed();
        }
    }
    EXPECT_GT(deformed_inside, 20);
}

TEST(Certify, RefusesWhatItCannotProve)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    shape::Superquadricd sq;
    EXPECT_FALSE(certify(sq, std::vector<Corners>{{Vec3d{nan, 0, 0}, Vec3d{}, Vec3d{}}}).bounding);
    sq.bend = 5;  // folds over: a triangle through the centre of curvature
    EXPECT_FALSE(certify(sq, std::vector<Corners>{{Vec3d{0.2, -0.1, -0.1}, Vec3d{0.2, 0.1, -0.1}, Vec3d{0.2, 0, 0.1}}}).bounding);
}

TEST(FitBounding, HoldsEveryTriangleOfRandomSoups)
{
    std::mt19937 random(2);
    for (int k = 0; k < 30; ++k) {
        mesh::Mesh m;
        const int n = 1 + k;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < 3; ++j) m.vertices.push_back({uniform(random, -1, 1), uniform(random, -0.5, 0.5), uniform(random, -0.1, 0.1)});
            const auto v = static_cast<std::uint32_t>(3 * i);
            m.triangles.push_back({v, v + 1, v + 2});
        }
        const std::vector<Corners> caps{{Vec3d{1.2, 0, 0}, Vec3d{0, 0.7, 0}, Vec3d{0, 0, 0.3}}};
        const FitReport r = fit_bounding(m, all_triangles(m), caps);
        EXPECT_TRUE(r.certificate.bounding);
        auto held = corners_of(m);
        held.push_back(caps[0]);
        EXPECT_LE(dense_largest_f(r.superquadric, held, 30), 1);
    }
}

TEST(FitBounding, DegenerateInputsGiveAValidBound)
{
    const auto expect_valid = [](const mesh::Mesh& m, const char* what) {
        const FitReport r = fit_bounding(m, all_triangles(m), {});
        EXPECT_TRUE(r.certificate.bounding) << what;
        for (int k = 0; k < 3; ++k) EXPECT_GT(r.superquadric.a[k], 0) << what;
        EXPECT_TRUE(std::isfinite(r.rms) && std::isfinite(r.volume)) << what;
        EXPECT_LE(dense_largest_f(r.superquadric, corners_of(m), 10), 1) << what;
    };
    expect_valid({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}, "one triangle");
    expect_valid({{{1, 2, 3}, {1, 2, 3}, {1, 2, 3}}, {{0, 1, 2}}}, "one point");
    expect_valid({{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}}}, "the origin");
    expect_valid({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}}, "a segment");
    expect_valid({{{0, 0, 0}, {1, 1, 1}, {2, 2, 2.001}, {1, 1.0005, 1}}, {{0, 1, 2}, {0, 2, 3}}}, "a needle");
    expect_valid({{{5, 5, 5}, {6, 5, 5}, {6, 6, 5}, {5, 6, 5}}, {{0, 1, 2}, {0, 2, 3}}}, "a flat square");
    expect_valid({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}}, "a tetrahedron");
    mesh::Mesh same{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {}};
    for (int i = 0; i < 50; ++i) same.triangles.push_back({0, 1, 2});
    expect_valid(same, "one triangle, fifty times");
    const FitReport none = fit_bounding({}, {}, {});
    EXPECT_TRUE(none.certificate.bounding);
}

TEST(FitBounding, ParametersAreFloatsAndTheFloatShapeHoldsTheCorners)
{
    std::mt19937 random(3);
    for (int k = 0; k < 8; ++k) {
        const auto m = tessellate(random_shape(random, k & 1, k & 2), 8);
        const auto r = fit_bounding(m, all_triangles(m), {});
        const auto& sq = r.superquadric;
        shape::Superquadricf f;
        f.a = cast<float>(sq.a);
        f.translation = cast<float>(sq.translation);
        for (int i = 0; i < 3; ++i) f.rotation.row[i] = cast<float>(sq.rotation.row[i]);
        f.eps1 = float(sq.eps1), f.eps2 = float(sq.eps2), f.taper_x = float(sq.taper_x), f.taper_y = float(sq.taper_y);
        f.bend = float(sq.bend), f.bend_angle = float(sq.bend_angle);
        EXPECT_EQ(cast<double>(f.a), sq.a);
        EXPECT_EQ(cast<double>(f.translation), sq.translation);
        EXPECT_EQ(double(f.eps1), sq.eps1);
        EXPECT_EQ(double(f.bend), sq.bend);
        for (int i = 0; i < 3; ++i) EXPECT_EQ(cast<double>(f.rotation.row[i]), sq.rotation.row[i]);
        for (const Vec3d& v : m.vertices) EXPECT_LE(implicit(f, cast<float>(v)), 1.0f);
    }
}

}  // namespace
}  // namespace sqmap::fit
