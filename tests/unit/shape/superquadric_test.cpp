#include "sqmap/shape/superquadric.h"

#include "sqmap/shape/surface.h"
#include "support/superquadrics.h"

#include <gtest/gtest.h>

#include <random>

namespace sqmap::shape {
namespace {

Vec3d random_in_box(std::mt19937& g, Vec3d half)
{
    std::uniform_real_distribution<double> u(-1, 1);
    const double x = u(g), y = u(g), z = u(g);
    return {half.x * x, half.y * y, half.z * z};
}

TEST(Superquadric, SphereImplicitIsTheSquaredRadius)
{
    const Superquadricd sq;
    EXPECT_DOUBLE_EQ(implicit(sq, Vec3d{0.3, 0.4, 0.0}), 0.25);
    EXPECT_NEAR(implicit(sq, Vec3d{2.0, 2.0, 1.0}), 9.0, 1e-12);
}

TEST(Superquadric, UndeformInvertsDeform)
{
    std::mt19937 g(1);
    for (const Superquadricd& sq : test::sample_superquadrics())
        for (int n = 0; n < 50; ++n) {
            const Vec3d q = random_in_box(g, sq.a);
            EXPECT_LT(norm(undeform(sq, deform(sq, q)) - q), 1e-12);
        }
}

// Solina and Bajcsy 1990, eqs. for bending as printed, on a point tapered before.
TEST(Superquadric, BendIsThatOfSolinaAndBajcsy)
{
    Superquadricd sq;
    sq.bend = 0.4;
    sq.bend_angle = 0.7;
    const double x = 0.3, y = -0.5, z = 0.8, k = sq.bend, alpha = sq.bend_angle;
    const double r = std::cos(alpha - std::atan2(y, x)) * std::hypot(x, y);
    const double gamma = z * k;
    const double big_r = 1 / k - (1 / k - r) * std::cos(gamma);
    const Vec3d expected{x + std::cos(alpha) * (big_r - r), y + std::sin(alpha) * (big_r - r), (1 / k - r) * std::sin(gamma)};
    EXPECT_LT(norm(deform(sq, Vec3d{x, y, z}) - expected), 1e-14);
}

TEST(Superquadric, AxisOfABentShapeIsACircleOfItsCurvature)
{
    Superquadricd sq;
    sq.bend = 0.5;
    sq.bend_angle = 1.1;
    const Vec3d centre{std::cos(1.1) / 0.5, std::sin(1.1) / 0.5, 0};
    for (double z : {-1.0, -0.3, 0.4, 1.0}) {
        const Vec3d p = deform(sq, Vec3d{0, 0, z});
        EXPECT_NEAR(norm(p - centre), 2.0, 1e-14);
        EXPECT_NEAR(2 * 2.0 * std::asin(norm(p) / 4.0), std::abs(z), 1e-14);  // arc length is kept
    }
}

TEST(Superquadric, TinyBendLosesNoDigitsInFloat)
{
    Superquadricf sq;
    sq.bend = 1e-6f;
    const Vec3f q{0.3f, -0.5f, 0.8f};
    EXPECT_LT(norm(undeform(sq, q) - q), 2e-6f);
    EXPECT_LT(norm(deform(sq, q) - q), 2e-6f);
}

TEST(Superquadric, FloatAgreesWithDoubleAtEveryExponent)
{
    std::mt19937 g(2);
    for (const Superquadricd& sq : test::sample_superquadrics()) {
        const auto f = cast<float>(sq);
        for (int n = 0; n < 50; ++n) {
            const Vec3d p = to_model(sq, deform(sq, random_in_box(g, sq.a)));
            const double d = implicit(sq, p);
            EXPECT_NEAR(static_cast<double>(implicit(f, cast<float>(p))), d, 1e-4 * std::max(1.0, d));
        }
    }
}

TEST(Superquadric, OctantPlanesPolesAndCentreAreFinite)
{
    for (float eps : {0.1f, 1.0f, 2.0f}) {
        Superquadricf sq;
        sq.eps1 = sq.eps2 = eps;
        EXPECT_EQ(implicit(sq, Vec3f{0, 0, 0}), 0.0f);
        EXPECT_FLOAT_EQ(implicit(sq, Vec3f{0, 0, 1}), 1.0f);
        EXPECT_FLOAT_EQ(implicit(sq, Vec3f{0, -1, 0}), 1.0f);
        EXPECT_TRUE(std::isfinite(implicit(sq, Vec3f{1e4f, 1e-20f, -1e4f})));
    }
}

}  // namespace
}  // namespace sqmap::shape
