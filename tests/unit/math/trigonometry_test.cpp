#include "math/trigonometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sqmap {
namespace {

constexpr long double k_bound = 2e-15L;

long double error_of_sines(double angle)
{
    const auto [sine, cosine] = sine_cosine(angle);
    const long double exact = angle;
    return std::max(std::abs(sine - std::sin(exact)), std::abs(cosine - std::cos(exact)));
}

TEST(Trigonometry, SinesAndCosinesAreWithinTheBoundOfLongDoubles)
{
    for (double range : {1e-9, 0.1, std::numbers::pi, 100.0, 1e6})
        for (int i = -20000; i <= 20000; ++i) ASSERT_LE(error_of_sines(range * i / 20000), k_bound) << range << " " << i;
}

TEST(Trigonometry, SinesNearWholeTurnsKeepTheirRelativeError)
{
    for (int turn = 1; turn <= 1000; ++turn) {
        const double angle = turn * std::numbers::pi;
        const long double exact = std::sin(static_cast<long double>(angle));
        ASSERT_LE(std::abs(sine_cosine(angle).sine - exact), 1e-6L * std::abs(exact) + 1e-19L) << turn;
    }
}

TEST(Trigonometry, AnglesAreWithinTheBoundOfLongDoublesInAllQuadrants)
{
    for (double size : {1e-300, 1e-3, 1.0, 1e300})
        for (int i = -20000; i <= 20000; ++i) {
            const double t = std::numbers::pi * i / 20000, x = size * std::cos(t), y = size * std::sin(t);
            ASSERT_LE(std::abs(angle_of(y, x) - std::atan2(static_cast<long double>(y), static_cast<long double>(x))), k_bound)
                << size << " " << i;
        }
}

TEST(Trigonometry, SmallAnglesKeepTheirRelativeError)
{
    for (double y = 1e-300; y < 1e-3; y *= 7) {
        EXPECT_NEAR(angle_of(y, 1.0) / std::atan(y), 1, 1e-15);
        EXPECT_NEAR(sine_cosine(y).sine / std::sin(y), 1, 1e-15);
    }
}

TEST(Trigonometry, WhatHasNoAngleIsZeroOrNotANumber)
{
    EXPECT_EQ(angle_of(0.0, 0.0), 0.0);
    EXPECT_EQ(angle_of(0.0, -1.0), std::numbers::pi);
    const double infinite = std::numeric_limits<double>::infinity();
    for (const double bad : {infinite, -infinite, std::nan("")}) {
        EXPECT_TRUE(std::isnan(sine_cosine(bad).sine));
        EXPECT_TRUE(std::isnan(angle_of(bad, bad)));
        EXPECT_TRUE(std::isnan(angle_of(std::nan(""), 1.0)));
    }
}

}  // namespace
}  // namespace sqmap
