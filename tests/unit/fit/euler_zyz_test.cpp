#include "sqmap/fit/euler_zyz.h"

#include "unit/fit/shapes.h"

#include <gtest/gtest.h>

namespace sqmap::fit {
namespace {

void expect_round_trip(const Mat3d& rotation)
{
    const Mat3d back = rotation_from(euler_zyz_of(rotation));
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(back.row[i][k], rotation.row[i][k], 1e-12);
}

TEST(EulerZyz, RoundTripsRandomRotationsAndBothPoles)
{
    std::mt19937 random(1);
    for (int k = 0; k < 50; ++k) expect_round_trip(test::random_rotation(random));
    expect_round_trip(Mat3d{});
    expect_round_trip(rotation_from({0.4, 0, 0.3}));
    expect_round_trip(rotation_from({0.4, std::numbers::pi, 0.3}));
}

TEST(EulerZyz, ThetaTiltsTheLocalZAxisAndPhiTurnsIt)
{
    const Mat3d r = rotation_from({std::numbers::pi / 2, 0.3, 0.7});
    EXPECT_NEAR(r.row[2].x, 0, 1e-15);
    EXPECT_NEAR(r.row[2].y, std::sin(0.3), 1e-15);
    EXPECT_NEAR(r.row[2].z, std::cos(0.3), 1e-15);
}

}  // namespace
}  // namespace sqmap::fit
