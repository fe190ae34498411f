#include "math/cube_root.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap {
namespace {

TEST(CubeRoot, IsWithinABitOfTheLibrarys)
{
    double worst = 0;
    for (double x = 1e-300; x < 1e300; x *= 1.00371) worst = std::max(worst, std::abs(cube_root(x) / std::cbrt(x) - 1));
    EXPECT_LT(worst, 1e-15);
}

TEST(CubeRoot, UndoesACube)
{
    for (int n = 1; n <= 200; ++n) EXPECT_DOUBLE_EQ(cube_root(static_cast<double>(n) * n * n), n);
    EXPECT_DOUBLE_EQ(cube_root(0x1p-300), 0x1p-100);
}

TEST(CubeRoot, GivesWhatHasNoneBack)
{
    EXPECT_EQ(cube_root(0), 0);
    EXPECT_EQ(cube_root(-8), -8);
    EXPECT_TRUE(std::isnan(cube_root(std::numeric_limits<double>::quiet_NaN())));
    EXPECT_EQ(cube_root(std::numeric_limits<double>::infinity()), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace sqmap
