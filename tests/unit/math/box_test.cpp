#include "sqmap/math/box.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace sqmap {
namespace {

TEST(Box, IsEmptyAsMadeAndHoldsWhatItWasExtendedBy)
{
    Box box;
    EXPECT_TRUE(is_empty(box));
    EXPECT_FALSE(contains(box, {0, 0, 0}));
    extend(box, Vec3d{1, -2, 3});
    EXPECT_FALSE(is_empty(box));
    EXPECT_TRUE(contains(box, {1, -2, 3}));
    extend(box, Vec3d{-1, 4, 3});
    EXPECT_EQ(size(box), (Vec3d{2, 6, 0}));
    EXPECT_EQ(centre(box), (Vec3d{0, 1, 3}));
    EXPECT_TRUE(contains(box, {0, 1, 3}));
    EXPECT_FALSE(contains(box, {0, 1, 3.1}));
    EXPECT_EQ(longest_axis(box), 1);
}

TEST(Box, OfPointsIsTheSameAsExtendedByEach)
{
    const std::vector<Vec3f> points{{1, 2, 3}, {-1, 5, 0}, {0, 0, 0}};
    const Boxf box = box_of(points);
    EXPECT_EQ(box, (Boxf{{-1, 0, 0}, {1, 5, 3}}));
    EXPECT_TRUE(is_empty(box_of(std::vector<Vec3d>{})));
}

TEST(Box, AnEmptyBoxExtendsNothing)
{
    Box box{{0, 0, 0}, {1, 1, 1}};
    extend(box, Box{});
    EXPECT_EQ(box, (Box{{0, 0, 0}, {1, 1, 1}}));
    extend(box, Vec3d{NAN, NAN, NAN});
    EXPECT_EQ(box, (Box{{0, 0, 0}, {1, 1, 1}}));
}

TEST(Box, BoxesThatTouchOverlap)
{
    const Box box{{0, 0, 0}, {1, 1, 1}};
    EXPECT_TRUE(overlap(box, {{1, 0, 0}, {2, 1, 1}}));
    EXPECT_FALSE(overlap(box, {{1.5, 0, 0}, {2, 1, 1}}));
    EXPECT_FALSE(overlap(box, Box{}));
}

}  // namespace
}  // namespace sqmap
