// Borders between named parts against the shortest ones near them, which Boost's maximum flow finds.
#include "decompose/borders.h"
#include "decompose/mirror.h"
#include "decompose/named_parts.h"
#include "sqmap/mesh/shapes.h"
#include "support/baked_shapes.h"
#include "support/least_border.h"
#include "support/parts_by.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sqmap::decompose {
namespace {

using test::parts_by;
using Labels = std::vector<std::uint32_t>;

Labels names_of(const NamedPartition& named)
{
    Labels out;
    for (const std::uint32_t part : named.partition.part_of_triangle) out.push_back(named.names[part]);
    return out;
}

NamedPartition named(const mesh::Mesh& mesh)
{
    const std::optional<Mirror> mirror = find_mirror(mesh);
    Partition partition = cut_creases(mesh, decompose(mesh), {});
    if (mirror) partition = symmetrised(mesh, *mirror, partition, 24);
    const NamedPartition rough{partition, named_parts(mesh, partition, {}, mirror ? &*mirror : nullptr)};
    return smoothed(mesh, rough, mirror ? &*mirror : nullptr);
}

/// A mesh's borders on open ground are at most a tenth longer than the least near them.
void expect_short(const std::string& name, const mesh::Mesh& mesh)
{
    const std::vector<test::BorderLength> borders = test::border_lengths(mesh, names_of(named(mesh)));
    EXPECT_GE(borders.size(), 3u) << name;
    for (const test::BorderLength& b : borders)
        EXPECT_LE(b.excess(), 1.1 + 0.2 * b.crease_share) << name << ": " << b.label_a << " and " << b.label_b;
}

TEST(LeastBorder, OfAToothedRingAroundATubeIsTheRing)
{
    // Rings of edges around a bar: one is the shortest, and the border between its triangles' teeth is longer.
    const mesh::Mesh mesh = mesh::dumbbell({.segments = 24});
    const Labels straight = parts_by(mesh, 2, [](Vec3d p) { return p.z > 0.01 ? 1u : 0u; }).part_of_triangle;
    const std::vector<test::BorderLength> toothed = test::border_lengths(mesh, straight);
    ASSERT_EQ(toothed.size(), 1u);
    const double ring = 24 * 2 * 0.35 * std::sin(std::numbers::pi / 24);  // bar_radius
    EXPECT_NEAR(toothed[0].least, ring, 0.01 * ring);
    EXPECT_GE(toothed[0].length, toothed[0].least * (1 - 1e-12));
    EXPECT_LT(toothed[0].crease_share, 0.01);
}

TEST(Smoothed, ARaggedBorderBecomesShortAndStaysInItsCrease)
{
    const mesh::DumbbellOptions options;
    const mesh::Mesh mesh = mesh::dumbbell(options);
    const double crease = options.half_distance - std::sqrt(1 - options.bar_radius * options.bar_radius);
    // Teeth as high as a tenth of the bar's circumference.
    const auto ragged = [&](Vec3d p) { return p.z > crease - 0.1 * (1 + std::sin(9 * std::atan2(p.y, p.x))) ? 1u : 0u; };
    NamedPartition rough{parts_by(mesh, 2, ragged), {0, 1}};
    rough.partition.boundaries = {{0, 1, CutKind::Salient, 1}};
    const std::vector<test::BorderLength> before = test::border_lengths(mesh, names_of(rough));
    ASSERT_EQ(before.size(), 1u);
    EXPECT_GT(before[0].excess(), 1.1);
    const NamedPartition smooth = smoothed(mesh, rough, nullptr);
    const std::vector<test::BorderLength> after = test::border_lengths(mesh, names_of(smooth));
    ASSERT_EQ(after.size(), 1u);
    EXPECT_LE(after[0].excess(), 1.05);
    EXPECT_NEAR(after[0].length, 2 * std::numbers::pi * options.bar_radius, 0.1 * after[0].length);
    ASSERT_EQ(smooth.partition.boundaries.size(), 1u);
    EXPECT_EQ(smooth.partition.boundaries[0].kind, CutKind::Salient);
}

TEST(Smoothed, PartsOfOneNameKeepTheirBorderAndOthersTheirPlace)
{
    const mesh::Mesh mesh = mesh::ellipsoid({2, 1, 1}, 4);
    const auto toothed = [](Vec3d p) { return p.x + 0.15 * std::sin(11 * std::atan2(p.y, p.z)); };
    const NamedPartition rough{parts_by(mesh, 3, [&](Vec3d p) { return toothed(p) < -1  ? 0u
                                                                       : toothed(p) < 0 ? 1u
                                                                                        : 2u; }),
                               {0, 0, 1}};
    for (const test::BorderLength& b : test::border_lengths(mesh, names_of(rough))) EXPECT_GT(b.excess(), 1.1);
    const NamedPartition smooth = smoothed(mesh, rough, nullptr);
    ASSERT_EQ(smooth.partition.part_count, 3u);
    EXPECT_EQ(std::set<std::uint32_t>(smooth.names.begin(), smooth.names.end()).size(), 2u);
    for (const test::BorderLength& b : test::border_lengths(mesh, names_of(smooth))) EXPECT_LE(b.excess(), 1.1);
    std::map<std::uint32_t, std::set<std::uint32_t>> now_of;  // away from the border of the names
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
        if (std::abs(mesh::triangle_centroid(mesh, t).x) > 1)
            now_of[rough.partition.part_of_triangle[t]].insert(smooth.partition.part_of_triangle[t]);
    EXPECT_EQ(now_of.size(), 3u);
    for (const auto& [part, now] : now_of) EXPECT_EQ(now.size(), 1u) << part;
}

TEST(Smoothed, NewNeighboursOfOtherNamesAreNoCutForTheFit)
{
    const mesh::Mesh mesh = mesh::ellipsoid({2, 1, 1}, 4);
    const NamedPartition rough{parts_by(mesh, 2, [](Vec3d p) { return p.x < 0.3 ? 0u : 1u; }), {0, 1}};
    const NamedPartition smooth = smoothed(mesh, rough, nullptr);
    ASSERT_EQ(smooth.partition.boundaries.size(), 1u);
    EXPECT_EQ(smooth.partition.boundaries[0].kind, CutKind::Crease);
}

TEST(NamedBorders, OfOwnBodiesAreShort)
{
    expect_short("hand", test::small_hand());
    const mesh::CapsuleSolid beast{{{{-1, 0, 0}, {1, 0, 0.1}, 0.55, 0.6},
                                    {{-0.9, 0.35, -0.3}, {-1.1, 0.55, -1.7}, 0.2, 0.14},
                                    {{-0.9, -0.35, -0.3}, {-1.1, -0.55, -1.7}, 0.2, 0.14},
                                    {{0.9, 0.35, -0.3}, {0.8, 0.65, -1.6}, 0.22, 0.15},
                                    {{0.9, -0.35, -0.3}, {0.8, -0.65, -1.6}, 0.22, 0.15},
                                    {{-1.2, 0, 0.2}, {-2.4, 0, 0.7}, 0.16, 0.08}},
                                   0.03};
    expect_short("beast", mesh::polygonized(beast, 0.09));
    expect_short("beast of many triangles", mesh::polygonized(beast, 0.05));
}

TEST(NamedBorders, OfAnimalsAreShort)
{
    for (const char* name : {"cat_8108.obj", "elephant_10272.obj", "hand_9344.obj", "horse_5946.obj"})
        if (const std::optional<mesh::Mesh> mesh = test::shared_mesh_too(name)) expect_short(name, *mesh);
}

}  // namespace
}  // namespace sqmap::decompose
