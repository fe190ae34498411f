#include "decompose/mirror.h"

#include "decompose/named_parts.h"
#include "sqmap/mesh/shapes.h"
#include "support/parts_by.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace sqmap::decompose {
namespace {

using test::parts_by;

/// A body with four legs and a tail. lean: by how much one leg differs from its mirror image about y = 0. Its triangles are
/// nowhere their own mirror images.
mesh::Mesh beast(double lean)
{
    return mesh::polygonized({{{{-1, 0, 0}, {1, 0, 0.1}, 0.55, 0.6},
                               {{-0.9, 0.35, -0.3}, {-1.1, 0.55, -1.7}, 0.2, 0.14},
                               {{-0.9, -0.35, -0.3}, {-1.1, -0.55 - lean, -1.7}, 0.2, 0.14},
                               {{0.9, 0.35, -0.3}, {0.8, 0.65, -1.6}, 0.22, 0.15},
                               {{0.9, -0.35, -0.3}, {0.8, -0.65, -1.6}, 0.22, 0.15},
                               {{-1.2, 0, 0.2}, {-2.4, 0, 0.7}, 0.16, 0.08}},
                              0.03},
                             0.09);
}

mesh::Mesh moved(mesh::Mesh mesh, const std::function<Vec3d(Vec3d)>& to)
{
    for (Vec3d& v : mesh.vertices) v = to(v);
    return mesh;
}

double area_of(const mesh::Mesh& mesh)
{
    double area = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) area += mesh::triangle_area(mesh, t);
    return area;
}

TEST(FindMirror, FindsThePlaneOfABodyWhoseTrianglesAreNotSymmetric)
{
    const mesh::Mesh mesh = beast(0);
    const std::optional<Mirror> mirror = find_mirror(mesh);
    ASSERT_TRUE(mirror);
    EXPECT_GT(std::abs(mirror->normal.y), 0.9999);
    EXPECT_NEAR(mirror->offset, 0, 0.01);
    double near = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint32_t o = mirror->of_triangle[t];
        if (o == mesh::k_no_triangle) continue;
        near += mesh::triangle_area(mesh, t);
        const Vec3d p = mesh::triangle_centroid(mesh, t), q = mesh::triangle_centroid(mesh, o);
        EXPECT_LT(norm(Vec3d{p.x, -p.y, p.z} - q), 0.15);
    }
    EXPECT_GT(near, 0.97 * area_of(mesh));
}

TEST(FindMirror, AMeshWithoutAreaHasNone) { EXPECT_FALSE(find_mirror({{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}})); }

TEST(FindMirror, ALegThatLeansHasNone) { EXPECT_FALSE(find_mirror(beast(0.5))); }

TEST(FindMirror, ThePlaneTurnsAndGrowsWithTheMesh)
{
    const mesh::Mesh mesh = beast(0);
    const auto turned = [](Vec3d p) { return 5.0 * Vec3d{0.6 * p.x - 0.8 * p.y, 0.8 * p.x + 0.6 * p.y, p.z} + Vec3d{1, 2, 3}; };
    const std::optional<Mirror> mirror = find_mirror(mesh), other = find_mirror(moved(mesh, turned));
    ASSERT_TRUE(mirror && other);
    const Vec3d expected = turned(mirror->normal) - turned({0, 0, 0});
    EXPECT_GT(std::abs(dot(other->normal, expected)), 5 * (1 - 1e-9));
    EXPECT_NEAR(std::abs(dot(other->normal, turned(mirror->offset * mirror->normal)) - other->offset), 0, 1e-6);
}

TEST(FindMirror, TheLongestAxisGoesFirstAndOneThatMayTurnFreelyLast)
{
    const std::optional<Mirror> dumbbell = find_mirror(mesh::dumbbell()), torus = find_mirror(mesh::torus());
    ASSERT_TRUE(dumbbell && torus);
    EXPECT_GT(std::abs(dumbbell->normal.z), 0.999);
    EXPECT_GT(std::abs(torus->normal.z), 0.999);
}

constexpr double k_around_bar = 2 * std::numbers::pi * 0.35;

/// The height at which a dumbbell's bar meets its ball.
double crease_of(const mesh::DumbbellOptions& o)
{
    return o.half_distance - std::sqrt(o.ball_radius * o.ball_radius - o.bar_radius * o.bar_radius);
}

TEST(Symmetrised, ACutInACreaseIsMadeOnBothSides)
{
    const mesh::Mesh mesh = mesh::dumbbell();
    const double crease = crease_of({});
    const std::optional<Mirror> mirror = find_mirror(mesh);
    ASSERT_TRUE(mirror);
    for (const double side : {1.0, -1.0}) {
        Partition one = parts_by(mesh, 2, [&](Vec3d p) { return side * p.z > crease ? 1u : 0u; });
        one.boundaries = {{0, 1, CutKind::Salient, k_around_bar}};
        const Partition both = symmetrised(mesh, *mirror, one, 24);
        ASSERT_EQ(both.part_count, 3u);
        const Partition expected = parts_by(mesh, 3, [&](Vec3d p) { return p.z > crease ? 1u : p.z < -crease ? 2u : 0u; });
        std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            pairs.emplace(both.part_of_triangle[t], expected.part_of_triangle[t]);
        EXPECT_EQ(pairs.size(), 3u);  // no triangle is elsewhere
        EXPECT_EQ(both.boundaries.size(), 2u);
    }
}

TEST(Symmetrised, ACutOverAConvexSurfaceIsMadeOnNeither)
{
    const mesh::Mesh mesh = mesh::dumbbell();
    const std::optional<Mirror> mirror = find_mirror(mesh);
    ASSERT_TRUE(mirror);
    const double crease = crease_of({}), equator = mesh::DumbbellOptions{}.half_distance;
    Partition partition = parts_by(mesh, 4, [&](Vec3d p) {
        return p.z > equator ? 3u : p.z > crease ? 1u : p.z < -crease ? 2u : 0u;
    });
    partition.boundaries = {{0, 1, CutKind::Salient, k_around_bar},
                            {0, 2, CutKind::Salient, k_around_bar},
                            {1, 3, CutKind::Error, 2 * std::numbers::pi}};
    EXPECT_EQ(symmetrised(mesh, *mirror, partition, 24).part_count, 3u);
}

TEST(Symmetrised, TheLimitOnPartsHolds)
{
    const mesh::Mesh mesh = mesh::dumbbell();
    const std::optional<Mirror> mirror = find_mirror(mesh);
    ASSERT_TRUE(mirror);
    const double crease = crease_of({});
    Partition one = parts_by(mesh, 2, [&](Vec3d p) { return p.z > crease ? 1u : 0u; });
    one.boundaries = {{0, 1, CutKind::Salient, k_around_bar}};
    EXPECT_LE(symmetrised(mesh, *mirror, one, 2).part_count, 2u);
    EXPECT_EQ(symmetrised(mesh, *mirror, one, 3).part_count, 3u);
    const Partition each = parts_by(mesh, 4, [&](Vec3d p) {
        return p.z > crease ? (p.x > 0 ? 1u : 2u) : p.z < -crease ? 3u : 0u;
    });
    EXPECT_EQ(symmetrised(mesh, *mirror, each, 2).part_of_triangle, each.part_of_triangle);
}

TEST(Symmetrised, ASymmetricBeastHasSymmetricNames)
{
    const mesh::Mesh mesh = beast(0);
    const std::optional<Mirror> mirror = find_mirror(mesh);
    ASSERT_TRUE(mirror);
    const Partition parts = symmetrised(mesh, *mirror, cut_creases(mesh, decompose(mesh), {}), 24);
    const std::vector<std::uint32_t> names = named_parts(mesh, parts, {}, &*mirror);
    EXPECT_EQ(1 + *std::max_element(names.begin(), names.end()), 6u);  // body, legs, tail
    const auto name_at = [&](Vec3d p) {
        std::uint32_t best = 0;
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            if (norm_sq(mesh::triangle_centroid(mesh, t) - p) < norm_sq(mesh::triangle_centroid(mesh, best) - p)) best = t;
        return names[parts.part_of_triangle[best]];
    };
    const std::vector<Vec3d> ends{{0, 0, 0.6},         {-2.4, 0, 0.7},    {-1.1, 0.55, -1.7},
                                  {-1.1, -0.55, -1.7}, {0.8, 0.65, -1.6}, {0.8, -0.65, -1.6}};
    std::set<std::uint32_t> found;
    for (const Vec3d& end : ends) found.insert(name_at(end));
    EXPECT_EQ(found.size(), ends.size());
    const std::vector<std::pair<std::uint32_t, std::uint32_t>> images{
        {name_at(ends[0]), name_at(ends[0])}, {name_at(ends[1]), name_at(ends[1])}, {name_at(ends[2]), name_at(ends[3])},
        {name_at(ends[3]), name_at(ends[2])}, {name_at(ends[4]), name_at(ends[5])}, {name_at(ends[5]), name_at(ends[4])}};
    double same = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint32_t o = mirror->of_triangle[t];
        if (o == mesh::k_no_triangle) continue;
        const std::pair pair{names[parts.part_of_triangle[t]], names[parts.part_of_triangle[o]]};
        if (std::find(images.begin(), images.end(), pair) != images.end()) same += mesh::triangle_area(mesh, t);
    }
    EXPECT_GT(same, 0.99 * area_of(mesh));
}

}  // namespace
}  // namespace sqmap::decompose
