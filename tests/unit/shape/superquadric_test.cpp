#include "sqmap/shape/superquadric.h"

#include <gtest/gtest.h>

namespace sqmap::shape {
namespace {

TEST(Superquadric, SphereImplicitIsTheSquaredRadius)
{
    const Superquadricd sq;
    EXPECT_DOUBLE_EQ(implicit(sq, Vec3d{0.3, 0.4, 0.0}), 0.25);
    EXPECT_NEAR(implicit(sq, Vec3d{2.0, 2.0, 1.0}), 9.0, 1e-12);
}

}  // namespace
}  // namespace sqmap::shape
