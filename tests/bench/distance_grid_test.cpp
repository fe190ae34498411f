#include "distance_grid.h"

#include "settings.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace sqmap::bench {
namespace {

TEST(DistanceGrid, HoldsTheExactSignedDistanceAtEverySample)
{
    const auto setting = test::egg_on_ring();
    const DistanceGrid grid = distance_grid(*setting, 24);
    ASSERT_EQ(grid.values.size(), 24u * 24 * 24);
    for (std::uint32_t k = 0; k < 24; ++k)
        for (std::uint32_t j = 0; j < 24; ++j)
            for (std::uint32_t i = 0; i < 24; ++i) {
                const Vec3d p{grid.lo.x + i * grid.spacing.x, grid.lo.y + j * grid.spacing.y, grid.lo.z + k * grid.spacing.z};
                ASSERT_NEAR(static_cast<double>(grid.values[grid.index(i, j, k)]), signed_distance(setting->solid, p), 1e-7)
                    << i << ' ' << j << ' ' << k;
            }
}

TEST(DistanceGrid, DoesNotDependOnTheNumberOfThreads)
{
    const auto setting = test::egg_on_ring();
    setting->threads = 1;
    const DistanceGrid one = distance_grid(*setting, 20);
    setting->threads = 3;
    EXPECT_EQ(distance_grid(*setting, 20).values, one.values);
}

TEST(DistanceGrid, ComesBackFromTheCacheAndDamageThereIsMadeGood)
{
    const auto setting = test::egg_on_ring();
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "sqmap-bench-cache";
    std::filesystem::remove_all(folder);
    setting->cache = folder;
    const DistanceGrid made = distance_grid(*setting, 20);
    ASSERT_FALSE(std::filesystem::is_empty(folder));
    const std::filesystem::path file = *std::filesystem::directory_iterator(folder);
    const DistanceGrid cached = distance_grid(*setting, 20);
    EXPECT_EQ(cached.values, made.values);
    EXPECT_EQ(cached.build_s, made.build_s);
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(999).put('\x55');
    EXPECT_EQ(distance_grid(*setting, 20).values, made.values);
    std::filesystem::resize_file(file, 1000);
    EXPECT_EQ(distance_grid(*setting, 20).values, made.values);
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace sqmap::bench
