#include "sqmap/fit/fit.h"

#include "fit/chart.h"

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
        if (std::isfinite(c.largest_f)) {
            EXPECT_LE(c.largest_f - c.tolerance, dense * 1.02) << "the bound less its tolerance is a value that F takes";
        }
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
            for (int j = 0; j < 3; ++j)
                m.vertices.push_back({uniform(random, -1, 1), uniform(random, -0.5, 0.5), uniform(random, -0.1, 0.1)});
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

TEST(FitSurface, RecoversAxesAndExponentsOfPlainSuperquadrics)
{
    std::mt19937 random(4);
    for (const double eps1 : {0.2, 0.6, 1.0, 1.5}) {
        for (const double eps2 : {0.3, 0.7, 1.0, 1.4}) {
            shape::Superquadricd truth = random_shape(random, false, false);
            truth.a = {0.3, 0.5, 0.9};
            truth.eps1 = eps1;
            truth.eps2 = eps2;
            const auto m = tessellate(truth, 40);
            const FitReport r = fit_surface(m, all_triangles(m), {.max_iterations = 100});
            SCOPED_TRACE(testing::Message() << eps1 << " " << eps2);
            EXPECT_LT(r.rms, 3e-3) << "samples lie on flat triangles, a little inside";
            EXPECT_NEAR(r.volume / volume(truth), 1, 0.01);
            // Equal exponents, or an ellipsoidal section, leave the choice of the z axis free.
            if (std::abs(dot(r.superquadric.rotation.row[2], truth.rotation.row[2])) < 0.99) continue;
            EXPECT_NEAR(r.superquadric.a.z, 0.9, 0.01);
            EXPECT_NEAR(std::min(r.superquadric.a.x, r.superquadric.a.y), 0.3, 0.005);
            EXPECT_NEAR(std::max(r.superquadric.a.x, r.superquadric.a.y), 0.5, 0.005);
            EXPECT_NEAR(r.superquadric.eps1, eps1, 0.05);
            EXPECT_NEAR(r.superquadric.eps2, eps2, 0.05);
        }
    }
}

TEST(FitSurface, RecoversTaperAndBend)
{
    std::mt19937 random(5);
    for (int k = 0; k < 12; ++k) {
        shape::Superquadricd truth = random_shape(random, false, false);
        truth.a = {0.25, 0.35, 1.0};
        truth.eps1 = uniform(random, 0.3, 1.2);
        truth.eps2 = uniform(random, 0.4, 1.2);
        const bool tapered = k % 3 != 1, bent = k % 3 != 0;
        if (tapered) {
            truth.taper_x = uniform(random, 0.3, 0.6);
            truth.taper_y = uniform(random, -0.3, 0.6);
        }
        if (bent) {
            truth.bend = uniform(random, 0.5, 0.9) * bend_limit(truth);
            truth.bend_angle = uniform(random, -3, 3);
        }
        const auto m = tessellate(truth, 40);
        const FitReport r = fit_surface(m, all_triangles(m), {.max_iterations = 100});
        SCOPED_TRACE(testing::Message() << "shape " << k << " tapered " << tapered << " bent " << bent);
        EXPECT_LT(r.rms, 4e-3);
        EXPECT_NEAR(r.volume / volume(truth), 1, 0.015);
        if (tapered && !bent) {
            const auto& sq = r.superquadric;
            EXPECT_NEAR(std::max(std::abs(sq.taper_x), std::abs(sq.taper_y)),
                        std::max(std::abs(truth.taper_x), std::abs(truth.taper_y)), 0.03);
        }
        if (bent) {
            EXPECT_NEAR(r.superquadric.bend, truth.bend, 0.05);
        }
    }
}

TEST(FitBounding, IsAsSmallAsTheSuperquadricItsTrianglesCameFrom)
{
    std::mt19937 random(6);
    for (int k = 0; k < 12; ++k) {
        shape::Superquadricd truth = random_shape(random, k % 3 == 1, k % 3 == 2);
        truth.eps1 = uniform(random, 0.3, 1.2);
        truth.eps2 = uniform(random, 0.3, 1.2);
        truth.taper_x *= 0.7, truth.taper_y *= 0.7;
        if (truth.is_bent()) truth.bend = std::min(truth.bend, 0.45);
        const auto m = tessellate(truth, 24);
        const FitReport r = fit_bounding(m, all_triangles(m), {});
        SCOPED_TRACE(testing::Message() << "shape " << k);
        EXPECT_FALSE(r.fallback);
        // A deformation that would save less than its gain is left out on purpose.
        EXPECT_LE(r.volume / volume(truth), k % 3 == 0 ? 1.02 : (k % 3 == 1 ? 1.06 : 1.15));
    }
}

TEST(FitBounding, IsNeverLargerThanThePrincipalBoundingEllipsoid)
{
    std::mt19937 random(7);
    for (int k = 0; k < 10; ++k) {
        mesh::Mesh m;
        for (std::uint32_t i = 0; i < 20; ++i) {
            for (int j = 0; j < 3; ++j)
                m.vertices.push_back({uniform(random, -2, 2), uniform(random, -1, 1), uniform(random, -0.5, 0.5)});
            m.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
        }
        FitOptions round;
        round.min_exponent = round.max_exponent = 1;
        round.allow_taper = round.allow_bend = false;
        const double ellipsoid = fit_bounding(m, all_triangles(m), {}, round).volume;
        const FitReport r = fit_bounding(m, all_triangles(m), {});
        EXPECT_LE(r.volume, ellipsoid * 1.001);
    }
}

TEST(FitBounding, FollowsRigidMotionAndScale)
{
    std::mt19937 random(8);
    const auto m = tessellate(random_shape(random, true, false), 12);
    const double v = fit_bounding(m, all_triangles(m), {}).volume;
    for (const double scale : {1e-3, 0.7, 4.0, 1e3}) {
        const Mat3d rotation = random_rotation(random);
        mesh::Mesh moved = m;
        for (Vec3d& p : moved.vertices) p = scale * (rotation * p + Vec3d{0.3, -0.2, 0.1});
        const FitReport r = fit_bounding(moved, all_triangles(moved), {});
        EXPECT_TRUE(r.certificate.bounding);
        EXPECT_NEAR(r.volume / (v * scale * scale * scale), 1, 0.03) << "scale " << scale;
    }
}

TEST(FitBounding, AxesStayWithinTheirOverhangOfThePart)
{
    std::mt19937 random(9);
    for (int k = 0; k < 10; ++k) {
        // A cone invites an apex that runs away.
        shape::Superquadricd cone;
        cone.taper_x = cone.taper_y = -0.94;
        cone.eps1 = uniform(random, 0.1, 2);
        cone.a = {0.3, 0.3, 1};
        const auto m = tessellate(cone, 12);
        const FitReport r = fit_bounding(m, all_triangles(m), {});
        const auto& sq = r.superquadric;
        Vec3d extent{};
        for (const Vec3d& p : m.vertices) {
            const Vec3d u = undeform(sq, to_local(sq, p));
            for (int i = 0; i < 3; ++i) extent[i] = std::max(extent[i], std::abs(u[i]));
        }
        for (int i = 0; i < 3; ++i) EXPECT_LE(sq.a[i], 1.6 * extent[i]);
    }
}

TEST(FitBounding, IsTheSameEachTime)
{
    std::mt19937 random(10);
    const auto m = tessellate(random_shape(random, true, true), 10);
    const auto r = fit_bounding(m, all_triangles(m), {});
    const auto other = tessellate(random_shape(random, false, true), 9);
    (void)fit_bounding(other, all_triangles(other), {});
    const auto again = fit_bounding(m, all_triangles(m), {});
    EXPECT_EQ(r.superquadric.a, again.superquadric.a);
    EXPECT_EQ(r.superquadric.rotation, again.superquadric.rotation);
    EXPECT_EQ(r.certificate.largest_f, again.certificate.largest_f);
}

TEST(Volume, IsThatOfTheEllipsoidAndOfFineClosedMeshes)
{
    shape::Superquadricd ellipsoid;
    ellipsoid.a = {1, 2, 3};
    EXPECT_NEAR(volume(ellipsoid), 8 * std::numbers::pi, 1e-10);
    std::mt19937 random(11);
    for (int k = 0; k < 6; ++k) {
        // Divergence theorem on a fine closed mesh: an independent way to the same number.
        const auto sq = random_shape(random, k & 1, k & 2);
        const auto m = tessellate(sq, 120);
        double v = 0;
        for (const auto& t : m.triangles) v += dot(m.vertices[t[0]], cross(m.vertices[t[1]], m.vertices[t[2]])) / 6;
        EXPECT_NEAR(std::abs(v) / volume(sq), 1, 0.01) << "shape " << k;
    }
}

}  // namespace
}  // namespace sqmap::fit
