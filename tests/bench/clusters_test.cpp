#include "clusters.h"

#include "settings.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace sqmap::bench {
namespace {

std::vector<Vec3d> scattered(std::size_t count)
{
    test::Random random(7);
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < count; ++i) points.push_back(random.in_box({-1, -2, -0.5}, {1, 2, 0.5}));
    return points;
}

TEST(Clusters, HoldEveryVertexOnceAndItsSpheresHoldIt)
{
    for (const std::size_t count : {1u, 15u, 16u, 17u, 255u, 256u, 257u, 4097u, 5000u}) {
        const std::vector<Vec3d> points = scattered(count);
        const ClusteredProbe probe = cluster(points);
        std::vector<int> seen(count, 0);
        for (std::size_t c = 0; c <= probe.last_block; ++c)
            for (std::size_t i = 0; i < (c == probe.last_block ? probe.last_lanes : k_lanes); ++i) {
                const std::uint32_t v = probe.vertices[c].vertex[i];
                ASSERT_LT(v, count);
                ++seen[v];
                const auto distance = [&](const SphereBlock& block, std::size_t lane) {
                    return norm(points[v] - Vec3d{block.x[lane], block.y[lane], block.z[lane]}) -
                           static_cast<double>(block.radius[lane]);
                };
                EXPECT_LE(distance(probe.clusters[c / k_lanes], c % k_lanes), 0) << "cluster " << c << " of " << count;
                const std::size_t g = c / k_lanes;
                EXPECT_LE(distance(probe.groups[g / k_lanes], g % k_lanes), 0) << "group " << g << " of " << count;
            }
        EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(count));
    }
}

/// Distances to a ball, in 16 bits on a coarse oblong grid, and the same values interpolated in double.
class BallField {
public:
    static constexpr int n = 20;
    static constexpr double k_step = 1e-4, k_ball = 0.25;
    const Vec3d lo{-0.5, -0.6, -0.4}, spacing{1.0 / (n - 1), 1.2 / (n - 1), 0.8 / (n - 1)};

    BallField()
    {
        for (int k = 0; k < n; ++k)
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < n; ++i) {
                    const Vec3d at{lo.x + i * spacing.x, lo.y + j * spacing.y, lo.z + k * spacing.z};
                    values_.push_back(static_cast<std::int16_t>(std::lround((norm(at) - k_ball) / k_step)));
                }
    }
    [[nodiscard]] FieldView view() const
    {
        return {{values_.data(), n},
                {values_.data(), n},
                1,
                static_cast<float>(k_step),
                {static_cast<float>(spacing.x), static_cast<float>(spacing.y), static_cast<float>(spacing.z)}};
    }
    [[nodiscard]] double reference(Vec3d p) const
    {
        int cell[3];
        double f[3];
        for (int k = 0; k < 3; ++k) {
            const double g = (p[k] - lo[k]) / spacing[k];
            if (g < 0 || g >= n - 1) return 1.0;
            cell[k] = static_cast<int>(g);
            f[k] = g - cell[k];
        }
        double sum = 0;
        for (int c = 0; c < 8; ++c) {
            const int at[3] = {cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)};
            sum += (c & 1 ? f[0] : 1 - f[0]) * (c >> 1 & 1 ? f[1] : 1 - f[1]) * (c >> 2 ? f[2] : 1 - f[2]) *
                   values_[static_cast<std::size_t>((at[2] * n + at[1]) * n + at[0])];
        }
        return sum * k_step;
    }

private:
    std::vector<std::int16_t> values_;
};

TEST(Clusters, EveryInstructionSetFindsWhatALookUpOfEveryVertexFinds)
{
    const auto setting = test::egg_on_ring();
    const BallField ball;
    const FieldView field = ball.view();
    const Vec3d lo = ball.lo, spacing = ball.spacing;
    const auto reference = [&](Vec3d p) { return ball.reference(p); };
    std::vector<DenseKernel> kernels{dense_kernel_plain};
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) kernels.push_back(dense_kernel_avx2);
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) kernels.push_back(dense_kernel_avx512);
#endif
    ClusteredProbe probe = cluster(setting->probe.vertices);
    for (std::vector<SphereBlock>* blocks : {&probe.groups, &probe.clusters})
        for (SphereBlock& block : *blocks)
            for (std::uint32_t i = 0; i < k_lanes; ++i) block.reach[i] = 1.1f * block.radius[i] + 1e-3f;
    std::vector<std::uint32_t> vertex(setting->probe.vertices.size() + k_lanes);
    std::vector<float> depth(vertex.size());
    std::array<std::vector<float>, 3> normal;
    normal.fill(depth);
    std::size_t contacts = 0, steep = 0;
    for (int shift = 0; shift < 40; ++shift) {
        const Vec3d translation{0.02 * shift - 0.1, 0.3 - 0.01 * shift, 0.015 * shift - 0.3};
        CellPose pose{};
        for (int i = 0; i < 3; ++i) {
            pose.m[i][i] = static_cast<float>(1 / spacing[i]);
            pose.m[i][3] = static_cast<float>((translation[i] - lo[i]) / spacing[i]);
        }
        for (std::size_t k = 0; k < kernels.size(); ++k) {
            const std::uint32_t count = kernels[k](
                field, probe.view(), pose, {vertex.data(), depth.data(), {normal[0].data(), normal[1].data(), normal[2].data()}});
            std::vector<double> found(setting->probe.vertices.size(), 0.0);
            for (std::uint32_t i = 0; i < count; ++i) {
                found[vertex[i]] = static_cast<double>(depth[i]);
                // The gradient of the interpolant, by differences that stay within a cell.
                const Vec3d p = setting->probe.vertices[vertex[i]] + translation;
                const Vec3d direction{normal[0][i], normal[1][i], normal[2][i]};
                EXPECT_NEAR(norm(direction), 1, 1e-5);
                constexpr double e = 1e-7;
                Vec3d slope;
                for (int axis = 0; axis < 3; ++axis) {
                    Vec3d shifted = p;
                    shifted[axis] += e;
                    slope[axis] = (reference(shifted) - reference(p)) / e;
                }
                steep += norm(normalized(slope) - direction) > 1e-3 ? 1 : 0;
            }
            for (std::size_t v = 0; v < found.size(); ++v) {
                const double exact = std::max(0.0, -reference(setting->probe.vertices[v] + translation));
                EXPECT_NEAR(found[v], exact, 2e-6) << "kernel " << k << ", shift " << shift << ", vertex " << v;
            }
            contacts += count;
        }
    }
    EXPECT_GT(contacts, 1000u);
    EXPECT_LT(steep, contacts / 1000 + 1);  // differences across a cell's border
}

}  // namespace
}  // namespace sqmap::bench
