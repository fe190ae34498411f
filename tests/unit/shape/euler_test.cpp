#include "sqmap/shape/superquadric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sqmap::shape {
namespace {

Mat3d rz(double t) { return {{{std::cos(t), -std::sin(t), 0}, {std::sin(t), std::cos(t), 0}, {0, 0, 1}}}; }
Mat3d ry(double t) { return {{{std::cos(t), 0, std::sin(t)}, {0, 1, 0}, {-std::sin(t), 0, std::cos(t)}}}; }

double difference(const Mat3d& a, const Mat3d& b)
{
    return norm(a.row[0] - b.row[0]) + norm(a.row[1] - b.row[1]) + norm(a.row[2] - b.row[2]);
}

TEST(Euler, IsTheTransposedProductOfThreeTurns)
{
    EXPECT_LT(difference(rotation_of<double>({0.4, 1.2, -2.0}), transpose(rz(0.4) * ry(1.2) * rz(-2.0))), 1e-14);
}

TEST(Euler, AnglesComeBackAlsoWhereOnlyTheirSumCounts)
{
    for (double theta : {0.0, 1e-9, 0.3, 2.0, std::numbers::pi})
        for (double phi : {-2.5, 0.0, 1.0})
            for (double chi : {-1.0, 0.7, 3.0}) {
                const Mat3d m = rotation_of<double>({phi, theta, chi});
                EXPECT_LT(difference(rotation_of(euler_angles_of(m)), m), 1e-8);
            }
}

}  // namespace
}  // namespace sqmap::shape
