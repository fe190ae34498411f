#include "distance_grid.h"

#include "settings.h"
#include "sqmap/mesh/admission.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <utility>

namespace sqmap::bench {
namespace {

void expect_exact_everywhere(const Setting& setting)
{
    const DistanceGrid grid = distance_grid(setting, 24);
    ASSERT_EQ(grid.values.size(), 24u * 24 * 24);
    for (std::uint32_t k = 0; k < 24; ++k)
        for (std::uint32_t j = 0; j < 24; ++j)
            for (std::uint32_t i = 0; i < 24; ++i) {
                const Vec3d p{grid.lo.x + i * grid.spacing.x, grid.lo.y + j * grid.spacing.y, grid.lo.z + k * grid.spacing.z};
                ASSERT_NEAR(static_cast<double>(grid.values[grid.index(i, j, k)]), signed_distance(setting.solid, p), 1e-7)
                    << i << ' ' << j << ' ' << k;
            }
}

TEST(DistanceGrid, HoldsTheExactSignedDistanceAtEverySample) { expect_exact_everywhere(*test::egg_on_ring()); }

TEST(DistanceGrid, HoldsItForASolidOfCrossingShells)
{
    mesh::Mesh two = test::mapped(mesh::sphere(1, 2), 1, {0.7, 0.1, 0});
    const mesh::Mesh other = mesh::sphere(0.8, 2);
    const auto shift = static_cast<std::uint32_t>(two.vertices.size());
    two.vertices.insert(two.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const mesh::Triangle& t : other.triangles) two.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
    std::vector<std::uint32_t> offsets{0};
    std::vector<std::int64_t> indices;
    for (const mesh::Triangle& t : two.triangles) {
        indices.insert(indices.end(), t.begin(), t.end());
        offsets.push_back(static_cast<std::uint32_t>(indices.size()));
    }
    mesh::AdmitResult gate = mesh::admit({two.vertices, offsets, indices});
    ASSERT_FALSE(gate.crossed.empty());
    expect_exact_everywhere(Setting(std::move(gate.mesh), mesh::sphere(1, 1), std::move(gate.crossed)));
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
    setting->cache = "/proc/nowhere";
    EXPECT_EQ(distance_grid(*setting, 20).values, made.values);
}

}  // namespace
}  // namespace sqmap::bench
