#include "sqmap/shape/superellipse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sqmap::shape {
namespace {

TEST(Superellipse, ArcLiesOnTheCurveAlongTheRay)
{
    for (double eps : {0.1, 0.5, 1.0, 1.6, 2.0})
        for (double t = -3.1; t < 3.2; t += 0.1) {
            const Arc<double> arc = arc_through(3 * std::cos(t), 3 * std::sin(t), eps);
            EXPECT_NEAR(implicit(Superellipse<double>{1, 1, eps}, arc.c, arc.s), 1.0, 1e-12);
            EXPECT_NEAR(std::atan2(arc.s, arc.c), t, 1e-12);
            EXPECT_NEAR(arc.gauge * arc.c, 3 * std::cos(t), 1e-12);
            EXPECT_NEAR(arc.c * arc.nc + arc.s * arc.ns, 1.0, 1e-12);
        }
}

TEST(Superellipse, DerivativesMatchFiniteDifferences)
{
    const double h = 1e-6;
    for (double eps : {0.1, 0.5, 1.0, 1.6, 2.0})
        for (double t : {-2.8, -1.9, -0.7, 0.2, 0.9, 1.4, 3.0}) {
            const auto at = [&](double s) { return arc_through(std::cos(t + s), std::sin(t + s), eps); };
            const ArcDerivative<double> d = derivative(at(0), eps);
            EXPECT_NEAR(d.c, (at(h).c - at(-h).c) / (2 * h), 1e-7);
            EXPECT_NEAR(d.s, (at(h).s - at(-h).s) / (2 * h), 1e-7);
            EXPECT_NEAR(d.nc, (at(h).nc - at(-h).nc) / (2 * h), 1e-6 * (1 + std::abs(d.nc)));
            EXPECT_NEAR(d.ns, (at(h).ns - at(-h).ns) / (2 * h), 1e-6 * (1 + std::abs(d.ns)));
        }
}

TEST(Superellipse, CentreAndOctantPlanesHaveAPlace)
{
    for (float eps : {0.1f, 1.0f, 2.0f}) {
        EXPECT_EQ(arc_through(0.0f, 0.0f, eps).gauge, 0.0f);
        const Arc<float> up = arc_through(0.0f, 2.0f, eps);
        EXPECT_FLOAT_EQ(up.s, 1.0f);
        EXPECT_FLOAT_EQ(up.ns, 1.0f);
        EXPECT_EQ(up.nc, 0.0f);
        const ArcDerivative<float> d = derivative(up, eps);
        EXPECT_TRUE(std::isfinite(d.nc) && std::isfinite(d.ns));
    }
}

TEST(Superellipse, SpacingIsInvertedAndKeepsQuadrants)
{
    // Away from octant planes: at eps 0.1 the paper's parameter itself rounds to the plane from 0.04 rad on.
    constexpr double quarter = std::numbers::pi / 2;
    for (double eps : {0.1, 0.4, 1.0, 2.0})
        for (int i = -18; i < 18; ++i) {
            const double t = (i + 0.5) / 9 * quarter;
            const double parameter = parameter_of_spaced(t, eps);
            EXPECT_NEAR(spaced_of_parameter(parameter, eps), t, 1e-6);
            EXPECT_EQ(std::floor(parameter / quarter), std::floor(t / quarter));
        }
}

}  // namespace
}  // namespace sqmap::shape
