#include "sqmap/shape/superquadric.h"

#include "sqmap/shape/surface.h"
#include "support/superquadrics.h"

#include <gtest/gtest.h>

#include <numbers>

namespace sqmap::shape {
namespace {

double farthest_sample(const Superquadricd& sq, Vec3d centre)
{
    constexpr double pi = std::numbers::pi;
    double best = 0;
    for (int i = 0; i <= 200; ++i)
        for (int j = 0; j < 400; ++j) {
            const SurfaceAngles<double> a{pi * (i / 200.0 - 0.5), 2 * pi * j / 400.0 - pi};
            best = std::max(best, norm(surface_point(sq, a).point - centre));
        }
    return best;
}

TEST(BoundingSphere, HoldsTheSurfaceAndIsExactWithoutDeformation)
{
    for (const Superquadricd& sq : test::sample_superquadrics(false)) {
        const Sphere3<double> s = bounding_sphere(sq);
        const double sampled = farthest_sample(sq, s.centre);
        EXPECT_GE(s.radius, sampled);
        EXPECT_LT(s.radius, sampled * 1.001);
    }
}

TEST(BoundingSphere, HoldsTaperedAndBentSurfacesWithinAFewPerCent)
{
    for (const Superquadricd& sq : test::sample_superquadrics(true)) {
        const Sphere3<double> s = bounding_sphere(sq);
        const double sampled = farthest_sample(sq, s.centre);
        EXPECT_GE(s.radius, sampled);
        EXPECT_LT(s.radius, sampled * 1.3);
    }
}

}  // namespace
}  // namespace sqmap::shape
