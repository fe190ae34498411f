#include "decompose/named_parts.h"

#include "sqmap/mesh/shapes.h"
#include "support/parts_by.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <vector>

namespace sqmap::decompose {
namespace {

using test::parts_by;

using Names = std::vector<std::uint32_t>;

TEST(NamedParts, PiecesOfAConvexBodyAreOne)
{
    const mesh::Mesh egg = mesh::ellipsoid({2, 1, 1}, 4);
    const Partition pieces = parts_by(egg, 4, [](Vec3d p) { return (p.x < 0.3 ? 0u : 1u) + (p.y < 0 ? 0u : 2u); });
    EXPECT_EQ(named_parts(egg, pieces), (Names{0, 0, 0, 0}));
}

TEST(NamedParts, PiecesOfABentTubeAreOne)
{
    const mesh::Mesh ring = mesh::torus();
    const Partition pieces = parts_by(ring, 5, [](Vec3d p) {
        return static_cast<std::uint32_t>(5 * (std::atan2(p.y, p.x) + std::numbers::pi) / (2.0001 * std::numbers::pi));
    });
    EXPECT_EQ(named_parts(ring, pieces), (Names{0, 0, 0, 0, 0}));
}

/// Balls, and between them a bar in two pieces.
Partition dumbbell_pieces(const mesh::Mesh& mesh, const mesh::DumbbellOptions& o, double scale)
{
    const double crease = scale * (o.half_distance - std::sqrt(o.ball_radius * o.ball_radius - o.bar_radius * o.bar_radius));
    return parts_by(mesh, 4, [=](Vec3d p) { return p.z > crease ? 0u : p.z < -crease ? 1u : p.z > 0 ? 2u : 3u; });
}

TEST(NamedParts, CreasesPartABarFromItsBalls)
{
    const mesh::DumbbellOptions options;
    const mesh::Mesh mesh = mesh::dumbbell(options);
    EXPECT_EQ(named_parts(mesh, dumbbell_pieces(mesh, options, 1)), (Names{0, 1, 2, 2}));
}

TEST(NamedParts, UnitsHaveNoInfluence)
{
    const mesh::DumbbellOptions options;
    mesh::Mesh mesh = mesh::dumbbell(options);
    for (Vec3d& v : mesh.vertices) v = 1000.0 * v;
    EXPECT_EQ(named_parts(mesh, dumbbell_pieces(mesh, options, 1000)), (Names{0, 1, 2, 2}));
}

TEST(NamedParts, ABendBeyondTheThresholdIsNeeded)
{
    const mesh::DumbbellOptions options;
    const mesh::Mesh mesh = mesh::dumbbell(options);
    EXPECT_EQ(named_parts(mesh, dumbbell_pieces(mesh, options, 1), {.least_bend = std::numbers::pi}), (Names{0, 0, 0, 0}));
}

TEST(NamedParts, ASalientBorderNeedsLess)
{
    // A waist so shallow that the surface turns inwards by some 0.08 radians on average.
    mesh::Mesh waist = mesh::ellipsoid({1, 1, 2}, 5);
    for (Vec3d& v : waist.vertices) {
        const double narrow = 1 - 0.1 * std::exp(-4 * v.z * v.z);
        v = {narrow * v.x, narrow * v.y, v.z};
    }
    Partition halves = parts_by(waist, 2, [](Vec3d p) { return p.z < 0 ? 0u : 1u; });
    halves.boundaries = {{0, 1, CutKind::Error, 1}};
    EXPECT_EQ(named_parts(waist, halves), (Names{0, 0}));
    halves.boundaries[0].kind = CutKind::Salient;
    EXPECT_EQ(named_parts(waist, halves), (Names{0, 1}));
}

TEST(NamedParts, ComponentsKeepTheirNames)
{
    mesh::Mesh two = mesh::sphere(1, 2);
    const auto count = static_cast<std::uint32_t>(two.vertices.size());
    const std::size_t triangles = two.triangles.size();
    for (std::uint32_t v = 0; v < count; ++v) two.vertices.push_back(two.vertices[v] + Vec3d{5, 0, 0});
    for (std::size_t t = 0; t < triangles; ++t) {
        const mesh::Triangle& first = two.triangles[t];
        two.triangles.push_back({first[0] + count, first[1] + count, first[2] + count});
    }
    EXPECT_EQ(named_parts(two, parts_by(two, 2, [](Vec3d p) { return p.x < 2.5 ? 0u : 1u; })), (Names{0, 1}));
}

Partition one_part(const mesh::Mesh& mesh)
{
    return parts_by(mesh, 1, [](Vec3d) { return 0u; });
}

TEST(CutCreases, CutsADumbbellWhereItsBarMeetsItsBalls)
{
    const mesh::DumbbellOptions options;
    const mesh::Mesh mesh = mesh::dumbbell(options);
    const Partition cut = cut_creases(mesh, one_part(mesh), {});
    ASSERT_EQ(cut.part_count, 3u);
    for (const Boundary& border : cut.boundaries) {
        EXPECT_EQ(border.kind, CutKind::Crease);
        EXPECT_NEAR(border.length, 2 * std::numbers::pi * options.bar_radius, 0.1 * border.length);
    }
    EXPECT_EQ(named_parts(mesh, cut).size(), 3u);
    EXPECT_EQ(cut_creases(mesh, one_part(mesh), {.max_parts = 2}).part_count, 2u);
}

TEST(CutCreases, PartsArmsThatNoEllipsoidHoldsTogether)
{
    // A right angle of two bars: the surface turns inwards on a part of the border alone.
    const mesh::CapsuleSolid angle{{{{0, 0, 0}, {2, 0, 0}, 0.15, 0.15}, {{0, 0, 0}, {0, 2, 0}, 0.15, 0.15}}, 0.05};
    const mesh::Mesh mesh = mesh::polygonized(angle, 0.08);
    const Partition cut = cut_creases(mesh, one_part(mesh), {});
    ASSERT_EQ(cut.part_count, 2u);
    std::set<std::uint32_t> along_x, along_y;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3d p = mesh::triangle_centroid(mesh, t);
        if (p.x - p.y > 0.5) along_x.insert(cut.part_of_triangle[t]);
        if (p.y - p.x > 0.5) along_y.insert(cut.part_of_triangle[t]);
    }
    EXPECT_EQ(along_x.size(), 1u);
    EXPECT_EQ(along_y.size(), 1u);
    EXPECT_NE(along_x, along_y);
    EXPECT_EQ(cut_creases(mesh, one_part(mesh), {.least_gain = 1}).part_count, 1u);
    EXPECT_EQ(cut_creases(mesh, one_part(mesh), {.slight_bend = 1}).part_count, 1u);
}

TEST(CutCreases, LeavesConvexBodiesAndBentTubesAlone)
{
    for (const mesh::Mesh& mesh : {mesh::ellipsoid({2, 1, 1}, 4), mesh::torus(), mesh::rounded_box({1.2, 0.8, 0.6}, 0.2, 3)})
        EXPECT_EQ(cut_creases(mesh, one_part(mesh), {}).part_count, 1u);
}

TEST(LabelsOfParts, AreThoseOfTheLargerShareOfTheTriangles)
{
    const Partition partition{{0, 0, 0, 1, 1, 2}, 3, {}};
    EXPECT_EQ(labels_of_parts(partition, {7, 3, 7, 3, 3, 7}), (Names{0, 1, 0}));
}

}  // namespace
}  // namespace sqmap::decompose
