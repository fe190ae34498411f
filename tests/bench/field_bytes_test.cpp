#include "field_bytes.h"

#include "setting.h"
#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace sqmap::bench {
namespace {

/// A long egg and a ball, scaled to a box diagonal of 1.
std::unique_ptr<Setting> egg() { return std::make_unique<Setting>(mesh::ellipsoid({4, 2, 1}, 3), mesh::sphere(1, 1)); }

TEST(FieldBytes, DenseHasAFloatAGridPointOfTheBoxAndItsMargin)
{
    // 32 cells along the longest side, 16 and 8 along the others; a margin of one on each side.
    EXPECT_EQ(dense_bytes(*egg(), {32}), 4u * 35 * 19 * 11);
}

TEST(FieldBytes, SparseStructuresGrowLikeTheSurfaceAndDenseLikeTheVolume)
{
    const auto setting = egg();
    const auto growth = [&](auto bytes) {
        return static_cast<double>(bytes(*setting, FieldDensity{128})) / static_cast<double>(bytes(*setting, FieldDensity{64}));
    };
    EXPECT_NEAR(growth(dense_bytes), 8, 1.2);  // the margin grows more slowly
    EXPECT_NEAR(growth(full_octree_bytes), 4, 0.5);
    EXPECT_NEAR(growth(tree512_bytes), 4, 0.8);
}

TEST(FieldBytes, TheFullOctreeHoldsAtLeastTheCellsThatTheAreaNeeds)
{
    const auto setting = egg();
    const double side = cell_side(*setting, {128});
    // A plane piece of a cell has at most sqrt(2) times a face's area (a diagonal cut), so no fewer cells can cover it.
    const double cells = mesh::surface_area(setting->object) / (std::sqrt(2.0) * side * side);
    EXPECT_GT(static_cast<double>(full_octree_bytes(*setting, {128})), 32 * cells);
}

TEST(FieldBytes, AnAdaptiveFieldThatMayStopEarlyIsNoLargerWithoutTheInside)
{
    // To 0.1 % of the diagonal the egg is met long before 512 cells: finer limits change nothing more.
    const auto setting = egg();
    EXPECT_LT(static_cast<double>(adf_bytes(*setting, {256})), 0.5 * static_cast<double>(full_octree_bytes(*setting, {256})));
}

TEST(FieldBytes, TrilinearErrorFallsWithTheSquareOfTheCell)
{
    const auto setting = egg();
    const double coarse = field_error(*setting, {32}), fine = field_error(*setting, {128});
    EXPECT_GT(coarse, 0);
    // Facets make the fall a little slower than 16.
    EXPECT_GT(coarse / fine, 8);
}

}  // namespace
}  // namespace sqmap::bench
