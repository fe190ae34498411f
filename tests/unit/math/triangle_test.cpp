#include "sqmap/math/triangle.h"

#include "sqmap/math/random.h"

#include <gtest/gtest.h>

namespace sqmap {
namespace {

template <class Real>
class ClosestPoint : public testing::Test {
protected:
    Vec3<Real> position(double size)
    {
        return {static_cast<Real>(random_.between(-size, size)), static_cast<Real>(random_.between(-size, size)),
                static_cast<Real>(random_.between(-size, size))};
    }
    SplitMix64 random_{5};
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(ClosestPoint, Reals);

TYPED_TEST(ClosestPoint, NoPointOfALatticeIsNearer)
{
    for (int i = 0; i < 2000; ++i) {
        const auto a = this->position(1), b = this->position(1), c = this->position(1), p = this->position(2);
        const auto found = closest_point_on_triangle(p, a, b, c);
        TypeParam least = norm(found - p), nearest_lattice = 100;
        constexpr int k_steps = 24;
        for (int u = 0; u <= k_steps; ++u)
            for (int v = 0; u + v <= k_steps; ++v) {
                const auto q = a + (TypeParam(u) / k_steps) * (b - a) + (TypeParam(v) / k_steps) * (c - a);
                EXPECT_LE(least, norm(q - p) + TypeParam(1e-5));
                nearest_lattice = std::min(nearest_lattice, norm(q - found));
            }
        // The answer is a point of the triangle: not farther from the lattice than its step.
        EXPECT_LE(nearest_lattice, (norm(b - a) + norm(c - a)) / k_steps);
    }
}

TYPED_TEST(ClosestPoint, ATriangleWithoutAreaGivesAPointOfIt)
{
    const Vec3<TypeParam> a{0, 0, 0}, b{1, 0, 0}, c{2, 0, 0};
    EXPECT_LE(norm(closest_point_on_triangle<TypeParam>({3, 1, 0}, a, b, c) - c), TypeParam(1e-6));
    EXPECT_LE(norm(closest_point_on_triangle<TypeParam>({-1, 1, 0}, a, a, a) - a), TypeParam(1e-6));
}

}  // namespace
}  // namespace sqmap
