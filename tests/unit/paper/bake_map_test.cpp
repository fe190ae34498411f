#include "sqmap/paper/bake.h"

#include "paper/model/codes.h"

#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/projection.h"
#include "support/decoded.h"
#include "unit/fit/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::paper {
namespace {

using fit::test::all_triangles;
using shape::Superquadricd;
using std::numbers::pi;

mesh::Mesh joined(mesh::Mesh a, const mesh::Mesh& b, Vec3d shift_b)
{
    const auto first = static_cast<std::uint32_t>(a.vertices.size());
    for (const Vec3d& v : b.vertices) a.vertices.push_back(v + shift_b);
    for (const mesh::Triangle& t : b.triangles) a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    return a;
}

TEST(MapRays, CapIsWhatStartsInsideAndMissWhatMeetsNothing)
{
    const mesh::Mesh ball = mesh::sphere(1, 4);
    const MapRays rays(ball);
    using Kind = MapRays::Kind;
    EXPECT_EQ(rays.surface_along({0.1, 0.2, 0}, {1, 0, 0}, {10, 1e-6}).kind, Kind::Cap);
    EXPECT_EQ(rays.surface_along({3, 2, 0}, {-1, 0, 0}, {10, 1e-6}).kind, Kind::Miss);
    EXPECT_EQ(rays.surface_along({3, 0.1, 0.05}, {-1, 0, 0}, {1.5, 1e-6}).kind, Kind::Miss);  // beyond its reach
    const MapRays::Surface hit = rays.surface_along({3, 0.1, 0.05}, {-1, 0, 0}, {10, 1e-6});
    EXPECT_EQ(hit.kind, Kind::Hit);
    EXPECT_NEAR(hit.distance, 3 - std::sqrt(1 - 0.0125), 2e-3);
}

TEST(MapRays, BuriedSurfacesAreNotSurfaces)
{
    // Two overlapping balls: from between them the second one's surface lies inside the first.
    const mesh::Mesh pair = joined(mesh::sphere(1, 4), mesh::sphere(1, 4), {1, 0, 0});
    const MapRays rays(pair);
    const MapRays::Surface hit = rays.surface_along({-3, 0.01, 0.02}, {1, 0, 0}, {10, 1e-6});
    EXPECT_EQ(hit.kind, MapRays::Kind::Hit);
    EXPECT_NEAR(hit.distance, 2, 5e-3);
    // Inside the first ball only, looking at the second: still inside.
    EXPECT_EQ(rays.surface_along({-0.5, 0.01, 0.02}, {1, 0, 0}, {10, 1e-6}).kind, MapRays::Kind::Cap);
}

// Distance from a point outside to a sphere about the origin along a unit direction.
double to_sphere(Vec3d p, Vec3d d, double radius)
{
    const double b = dot(p, d), c = dot(p, p) - radius * radius, q = b * b - c;
    return q < 0 ? -1 : -b - std::sqrt(q);
}

TEST(Map, SphereInAnEllipsoidMatchesTheClosedForm)
{
    const double facet = 0.6 * 1e-3;  // 6 subdivisions: the mesh lies this close to the sphere
    const mesh::Mesh ball = mesh::sphere(0.6, 6);
    const MapRays rays(ball);
    Superquadricd sq;
    sq.a = {0.7, 0.8, 1.0};
    const Map map = bake_map(rays, all_triangles(ball), sq);
    EXPECT_TRUE(map.report.target_met);
    int hits = 0;
    for (std::uint32_t i = 0; i < map.eta_count; ++i)
        for (std::uint32_t j = 0; j < map.omega_count; ++j) {
            const shape::SurfaceAngles<double> at{pi * (double(i) / (map.eta_count - 1) - 0.5),
                                                  2 * pi * j / map.omega_count - pi};
            const auto s = shape::surface_point(sq, at);
            const double expected = to_sphere(s.point, -s.normal, 0.6);
            const std::uint16_t code = map.distance[std::size_t{i} * map.omega_count + j];
            const Vec3d m = s.point - expected * s.normal;
            if (expected < 0 || dot(m, s.normal) < 0.2) continue;  // a near miss of the sphere need not be one of the mesh
            ++hits;
            ASSERT_EQ(ray_of(code), MapRay::Surface);
            EXPECT_NEAR(double(map.distance_scale) * code, expected, 3 * facet);
            const std::uint32_t every = 1u << map.subdivisions;
            if (i % every != 0 || j % every != 0) continue;
            const std::size_t base = std::size_t{i / every} * (map.omega_count / every) + j / every;
            EXPECT_GT(dot(cast<double>(test::decode_normal(map.normal[hit_index(map.view(), base)])), m) / 0.6, std::cos(0.07));
        }
    EXPECT_GT(hits, static_cast<int>(map.distance.size() / 2));
    EXPECT_LE(map.report.quantization_error, 0.51 * double(map.distance_scale));
}

TEST(Map, SmoothingLeavesASphereAsItIs)
{
    const mesh::Mesh ball = mesh::sphere(0.6, 6);
    const MapRays rays(ball);
    const Superquadricd sq;  // the unit sphere: every distance is 0.4
    const Map map = bake_map(rays, all_triangles(ball), sq);
    const std::size_t hits = map.normal.size() - k_hit_padding;
    ASSERT_EQ(map.smoothed.size(), (5 * map.normal.size() + 1) / 2);
    std::size_t smoothed = 0;
    for (std::size_t k = 0; k < hits; ++k) {
        const SmoothedSample s = smoothed_at(map.view(), k);
        if (!is_smoothed(s)) continue;
        ++smoothed;
        EXPECT_LT(std::abs(double(map.change_scale) * s.steps()), 1e-3);
    }
    EXPECT_GT(smoothed, hits / 2);
    const shape::SurfaceAnglesf at{0.3f, 0.7f};
    const paper::MapSample sample = paper::sample_smoothed(map.view(), at);
    EXPECT_NEAR(sample.distance, 0.4f, 1e-3f);
    EXPECT_GT(dot(sample.normal, shape::surface_point(map.superquadric, at).normal), 0.999f);
}

// One surface for all maps: a ball's stays a ball, about its middle, whichever superquadric it is seen from, and a box's edges
// are planed off.
TEST(Map, TheSmoothedSurfaceIsTheMeshsOwn)
{
    const mesh::Mesh box = mesh::rounded_box({0.5, 0.4, 0.3}, 0.02, 3);
    const MapRays rays(box);
    const SmoothSurface& smooth = rays.smoothed(0.015);
    EXPECT_EQ(&smooth, &rays.smoothed(0.015));
    ASSERT_EQ(smooth.points.size(), box.vertices.size());
    double moved = 0;
    for (std::size_t v = 0; v < box.vertices.size(); ++v) moved = std::max(moved, norm(smooth.points[v] - box.vertices[v]));
    EXPECT_GT(moved, 1e-3);
    EXPECT_LT(moved, 0.06);
    for (const double stretch : {1.0, 1.3}) {
        Superquadricd sq;
        sq.a = {1.0, stretch, 1.0};
        const Map map = bake_map(rays, all_triangles(box), sq, {.grid = {33, 64}});
        const auto scale = static_cast<double>(map.distance_scale);
        const mesh::Mesh moved_mesh{smooth.points, box.triangles};
        const mesh::Bvh bvh(moved_mesh);
        std::size_t hits = 0;
        std::vector<double> off;
        for (std::size_t i = 0; i < 33; ++i)
            for (std::size_t j = 0; j < 64; ++j) {
                const SmoothedSample s = smoothed_at(map.view(), hit_index(map.view(), i * 64 + j));
                ASSERT_TRUE(is_smoothed(s)) << i << ' ' << j;  // beside edges and at the poles too
                const auto r =
                    shape::surface_point(shape::cast<double>(map.superquadric),
                                         shape::SurfaceAngles<double>{pi * (double(i) / 32 - 0.5), 2 * pi * double(j) / 64 - pi});
                const double d = scale * map.distance[2 * i * map.omega_count + 2 * j] + double(map.change_scale) * s.steps();
                off.push_back(bvh.closest_point(r.point - d * r.normal).distance);
                ++hits;
            }
        std::sort(off.begin(), off.end());
        EXPECT_LT(off[hits / 2], 2e-4);
        EXPECT_LT(off[hits * 95 / 100], 4e-3);
    }
}

// The mean by its definition, on a map that is far from flat.
TEST(Map, SmoothingIsTheWeightedMeanOfTheBaseGrid)
{
    const mesh::Mesh box = mesh::rounded_box({0.5, 0.4, 0.3}, 0.1, 3);
    const MapRays rays(box);
    const auto gauss = [](double d) { return std::exp(-2 * d * d / 4); };
    struct Case {
        SmoothingKernel kernel;
        std::vector<double> weights;
    };
    const Case cases[] = {{SmoothingKernel::Binomial, {1, 2, 1}},
                          {SmoothingKernel::Binomial, {1, 4, 6, 4, 1}},
                          {SmoothingKernel::Box, {1, 1, 1}},
                          {SmoothingKernel::Gaussian, {gauss(2), gauss(1), 1, gauss(1), gauss(2)}}};
    for (const auto& [kernel, weights] : cases) {
        const std::size_t radius = weights.size() / 2;
        const Map map = bake_map(rays, all_triangles(box), Superquadricd{},
                                 {.grid = {33, 64},
                                  .smoothing = paper::Smoothing::Distances,
                                  .smoothing_radius = static_cast<int>(radius),
                                  .smoothing_kernel = kernel});
        const std::size_t stride = std::size_t{1} << map.subdivisions;
        const std::size_t rows = (map.eta_count - 1) / stride + 1, columns = map.omega_count / stride;
        ASSERT_EQ(rows, 33u);
        ASSERT_EQ(columns, 64u);
        const auto distance = [&](std::size_t i, std::size_t j) {
            return double(map.distance_scale) * map.distance[i * stride * map.omega_count + j % columns * stride];
        };
        std::size_t checked = 0;
        double largest = 0;
        for (std::size_t i = radius; i + radius < rows; ++i)
            for (std::size_t j = 0; j < columns; ++j) {
                if (ray_of(map.distance[i * stride * map.omega_count + j * stride]) != MapRay::Surface) continue;
                const SmoothedSample s = smoothed_at(map.view(), hit_index(map.view(), i * columns + j));
                if (!is_smoothed(s)) continue;
                double sum = 0, total = 0;
                for (std::size_t di = 0; di < weights.size(); ++di)
                    for (std::size_t dj = 0; dj < weights.size(); ++dj) {
                        sum += weights[di] * weights[dj] * distance(i + di - radius, j + columns + dj - radius);
                        total += weights[di] * weights[dj];
                    }
                // Roots are rounded: a change may be off by the root's step, and the distances are rounded as well.
                const double change = double(map.change_scale) * s.steps();
                EXPECT_NEAR(distance(i, j) + change, sum / total,
                            2.0 * double(map.distance_scale) + double(map.change_scale) * (std::abs(s.change) + 0.5));
                largest = std::max(largest, std::abs(change));
                ++checked;
            }
        EXPECT_GT(checked, 100u);
        EXPECT_GT(largest, 1e-3);
    }
}

TEST(Map, AChosenGridIsThatOfLayerTwo)
{
    const mesh::Mesh ball = mesh::sphere(0.6, 4);
    const MapRays rays(ball);
    for (const int subdivisions : {0, 1, 2}) {
        const Map map = bake_map(rays, all_triangles(ball), Superquadricd{}, {.grid = {20, 50}, .subdivisions = subdivisions});
        EXPECT_EQ(map.eta_count, (19u << subdivisions) + 1);
        EXPECT_EQ(map.omega_count, 50u << subdivisions);
        EXPECT_EQ(map.subdivisions, static_cast<std::uint32_t>(subdivisions));
        EXPECT_EQ(map.hits.size(), (20u * 50u + 31) / 32);
        EXPECT_EQ(map.normal.size(), 20u * 50u + k_hit_padding);  // every ray meets the ball
        for (const paper::Projector projector : {paper::Projector::Newton, paper::Projector::Pyramid}) {
            const paper::PartAnswer answer = paper::project(map.view(), {0.2f, 0.3f, 0.1f}, {.projector = projector});
            EXPECT_EQ(answer.verdict, paper::Verdict::Contact);
            EXPECT_NEAR(answer.depth, 0.6f - std::sqrt(0.14f), 0.02f);
        }
    }
}

// Errata 8: at a minimum of the map the gradient is next to nothing, about it it is not.
TEST(Map, TheOffsetOfEq12GrowsWithTheRadiusItLooksAt)
{
    const mesh::Mesh box = mesh::rounded_box({0.5, 0.4, 0.3}, 0.1, 3);
    const MapRays rays(box);
    std::vector<double> largest, mean;
    for (const int radius : {0, 1, 2}) {
        const Map map = bake_map(rays, all_triangles(box), Superquadricd{}, {.offset_radius = radius});
        double sum = 0, greatest = 0;
        const std::size_t samples =
            std::size_t{((map.eta_count - 1) >> map.subdivisions) + 1} * (map.omega_count >> map.subdivisions);
        for (std::size_t i = 0; i < samples; ++i) {
            const double offset = double(map.offset_scale) * offset_steps(map.view(), i);
            sum += offset;
            greatest = std::max(greatest, offset);
        }
        largest.push_back(greatest);
        mean.push_back(sum);
    }
    EXPECT_LT(mean[0], 0.5 * mean[1]);
    EXPECT_LE(mean[1], mean[2] * 1.01);
    EXPECT_LE(largest[1], largest[2] * 1.01);
}

TEST(Map, WithoutSmoothingNothingIsStoredForIt)
{
    const mesh::Mesh ball = mesh::sphere(0.5, 3);
    const MapRays rays(ball);
    const Map map = bake_map(rays, all_triangles(ball), Superquadricd{}, {.grid = {17, 32}, .smoothing_radius = 0});
    EXPECT_TRUE(map.smoothed.empty());
    const shape::SurfaceAnglesf at{0.2f, 0.3f};
    EXPECT_EQ(paper::sample_smoothed(map.view(), at).distance, paper::sample_map(map.view(), at, {}).distance);
}

// Fig. 13: around a box, over its rounded edges, the normal turns by smaller steps on the smoothed map.
TEST(Map, SmoothingTurnsTheNormalBySmallerSteps)
{
    const mesh::Mesh box = mesh::rounded_box({0.5, 0.5, 0.5}, 0.01, 3);
    const MapRays rays(box);
    // Normals of both are of the same samples, and the kernel is as wide as the default's on half of them.
    const Map map = bake_map(rays, all_triangles(box), Superquadricd{},
                             {.subdivisions = 0, .smoothing = paper::Smoothing::Distances, .smoothing_radius = 4});
    double steepest[2] = {0, 0};
    Vec3f before[2];
    for (int i = 0; i <= 2000; ++i) {
        const shape::SurfaceAnglesf at{0.2f, static_cast<float>(2 * pi * i / 2000 - pi)};
        const paper::MapSample sample[2] = {paper::sample_map(map.view(), at, {}), paper::sample_smoothed(map.view(), at)};
        for (int k = 0; k < 2; ++k) {
            ASSERT_NEAR(norm(sample[k].normal), 1.f, 1e-3f);
            if (i > 0) steepest[k] = std::max(steepest[k], static_cast<double>(norm(sample[k].normal - before[k])));
            before[k] = sample[k].normal;
        }
    }
    EXPECT_LT(steepest[1], 0.6 * steepest[0]);
}

TEST(Map, QuantisationErrorIsWhatTheReportSays)
{
    const mesh::Mesh ball = mesh::sphere(0.6, 4);
    const MapRays rays(ball);
    Superquadricd sq;
    sq.a = {0.7, 0.8, 1.0};
    const Map map = bake_map(rays, all_triangles(ball), sq);
    EXPECT_GT(map.report.quantization_error, 0.0);
    EXPECT_LT(map.report.quantization_error, 1e-5);
}

TEST(Map, SameInputGivesTheSameMap)
{
    const mesh::Mesh m = mesh::dumbbell();
    Superquadricd sq;
    sq.a = {6, 6, 6};
    sq.eps1 = 0.7;
    const MapRays rays(m), again(m);
    const Map a = bake_map(rays, all_triangles(m), sq), b = bake_map(again, all_triangles(m), sq);
    EXPECT_EQ(a.distance, b.distance);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.corrections, b.corrections);
    EXPECT_EQ(a.seeds, b.seeds);
}

TEST(Map, StepThreeBringsTheMapToTheVertices)
{
    // A coarse map of a faceted ball: with corrections the map passes through the vertices that a foot can see.
    const mesh::Mesh ball = mesh::sphere(0.6, 2);
    const MapRays rays(ball);
    Superquadricd sq;
    sq.a = {0.8, 0.9, 1.1};
    const MapOptions options{.min_level = 5, .max_level = 5, .correction_threshold = 0};
    const Map map = bake_map(rays, all_triangles(ball), sq, options);
    EXPECT_EQ(map.report.occluded_vertices, 0u);
    EXPECT_GT(map.report.corrections, map.report.vertices / 2);
    const auto worst = [&](bool corrections) {
        double sum = 0;
        for (const Vec3d& v : ball.vertices) {
            const auto a = paper::project(map.view(), cast<float>(v), {.corrections = corrections});
            sum += std::abs(static_cast<double>(a.depth_along));
        }
        return sum / static_cast<double>(ball.vertices.size());
    };
    EXPECT_LT(worst(true), 0.3 * worst(false));
}

TEST(Map, StepThreeMovesTheMapAsFarTowardsASpikeAsItCanBeStored)
{
    // The spike's tip is higher than half of the largest distance, all that a correction can hold, and lies between samples.
    mesh::Mesh ball = mesh::sphere(0.9, 3);
    std::size_t tip = 0;
    const auto middle = [](const Vec3d& v) {  // 0 at a cell's centre of a grid of 17 x 32, 1 on its border
        const auto off = [](double cells) { return 2 * std::abs(cells - std::floor(cells) - 0.5); };
        return std::max(off(std::asin(v.z / norm(v)) * 16 / std::numbers::pi), off(std::atan2(v.y, v.x) * 16 / std::numbers::pi));
    };
    for (std::size_t i = 0; i < ball.vertices.size(); ++i)
        if (middle(ball.vertices[i]) < middle(ball.vertices[tip])) tip = i;
    ball.vertices[tip] = 1.28 * ball.vertices[tip];
    const MapRays rays(ball);
    Superquadricd sq;
    sq.a = {1.2, 1.2, 1.2};
    const Map map = bake_map(rays, all_triangles(ball), sq, {.min_level = 4, .max_level = 4, .gaps = false});
    const auto error = [&](bool corrections) {
        return std::abs(project(map.view(), cast<float>(ball.vertices[tip]), {.corrections = corrections}).depth_along);
    };
    EXPECT_GT(error(false), 0.16f);
    EXPECT_LT(error(true), error(false) - 0.12f);
}

TEST(Map, BakedViewsAreConsistentAndBrokenOnesAreNot)
{
    const mesh::Mesh m = mesh::dumbbell();
    Superquadricd sq;
    sq.a = {1.4, 1.4, 3};
    sq.eps1 = 0.5;
    const MapRays rays(m);
    const Map map = bake_map(rays, all_triangles(m), sq);
    ASSERT_GT(map.corrections.size(), 1u);
    EXPECT_TRUE(is_consistent(map.view()));
    const auto broken = [&](auto&& change) {
        MapView v = map.view();
        change(v);
        return !is_consistent(v);
    };
    EXPECT_TRUE(broken([](auto& v) { v.eta_count += 1; }));
    EXPECT_TRUE(broken([](auto& v) { v.subdivisions = 7; }));
    EXPECT_TRUE(broken([](auto& v) { v.distance = v.distance.first(v.distance.size() - 1); }));
    EXPECT_TRUE(broken([](auto& v) { v.cuts = {}; }));
    EXPECT_TRUE(broken([](auto& v) { v.seed_count = 5; }));
    EXPECT_TRUE(broken([](auto& v) { v.surface_seeds = v.surface_seeds.first(5); }));
    EXPECT_FALSE(broken([](auto& v) { v.surface_seeds = {}; }));
    EXPECT_TRUE(broken([](auto& v) { v.correction_rows = v.correction_rows.first(3); }));
    EXPECT_TRUE(broken([](auto& v) { v.distance_scale = std::nanf(""); }));
    EXPECT_TRUE(broken([](auto& v) { v.superquadric.eps1 = 0; }));
    std::vector<VertexCorrection> far = map.corrections;
    far.front().column = 60000;
    EXPECT_TRUE(broken([&](auto& v) { v.corrections = far; }));
    std::vector<std::uint32_t> falling = map.correction_rows;
    falling[falling.size() / 2] = static_cast<std::uint32_t>(map.corrections.size()) + 5;
    EXPECT_TRUE(broken([&](auto& v) { v.correction_rows = falling; }));
}

TEST(Map, CutsKeepTheSheetsApart)
{
    // Two balls in one wide ellipsoid: rays between them see one, the other or nothing.
    const mesh::Mesh pair = joined(mesh::sphere(0.4, 4), mesh::sphere(0.4, 4), {1.2, 0, 0});
    const MapRays rays(pair);
    Superquadricd sq;
    sq.a = {1.2, 0.6, 0.6};
    sq.translation = {0.6, 0, 0};
    const Map map = bake_map(rays, all_triangles(pair), sq);
    EXPECT_GT(map.report.cut_share, 0.0);
    EXPECT_GT(map.report.miss_share, 0.0);
    // No value is read that lies on neither ball.
    for (int n = 0; n < 4000; ++n) {
        const shape::SurfaceAnglesf at{static_cast<float>(1.5 * std::sin(0.37 * n)),
                                       static_cast<float>(3.1 * std::sin(0.11 * n))};
        const paper::MapSample s = paper::sample_map(map.view(), at, {});
        if (!std::isfinite(s.distance)) continue;
        const auto foot = shape::surface_point(map.superquadric, at);
        const Vec3d m = cast<double>(foot.point - s.distance * foot.normal);
        EXPECT_LT(std::min(std::abs(norm(m) - 0.4), std::abs(norm(m - Vec3d{1.2, 0, 0}) - 0.4)), 0.02);
    }
}

}  // namespace
}  // namespace sqmap::paper
