#include "sqmap/mesh/admission.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/mesh/wrap.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::mesh {
namespace {

/// Rectangles with two triangles each that share no vertices with others.
void add_sheet(Mesh& soup, Vec3d corner, Vec3d u, Vec3d v)
{
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const Vec3d& p : {corner, corner + u, corner + u + v, corner + v}) soup.vertices.push_back(p);
    soup.triangles.push_back({first, first + 1, first + 2});
    soup.triangles.push_back({first, first + 2, first + 3});
}

/// The unit cube of six loose sheets; the upper one, z = 1, begins behind a slit at x = 0.
Mesh cube_of_sheets(double slit)
{
    Mesh soup;
    add_sheet(soup, {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    add_sheet(soup, {slit, 0, 1}, {1 - slit, 0, 0}, {0, 1, 0});
    add_sheet(soup, {0, 0, 0}, {0, 1, 0}, {0, 0, 1});
    add_sheet(soup, {1, 0, 0}, {0, 1, 0}, {0, 0, 1});
    add_sheet(soup, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
    add_sheet(soup, {0, 1, 0}, {0, 0, 1}, {1, 0, 0});
    return soup;
}

Mesh moved(Mesh mesh, Vec3d by, double scale = 1)
{
    for (Vec3d& p : mesh.vertices) p = scale * p + by;
    return mesh;
}

/// Twice the default: for tests whose subject is not the default tolerance, in a fifth of the time.
constexpr double k_twice = 0.004;

OuterResult outer(const Mesh& soup, const OuterOptions& options = {})
{
    return outer_solid(soup.vertices, soup.triangles, options);
}

AdmitResult admitted_outer(const Mesh& soup, AdmitOptions options = {})
{
    options.solid = SolidKind::Outer;
    std::vector<std::uint32_t> offsets{0};
    std::vector<std::int64_t> indices;
    for (const Triangle& t : soup.triangles) {
        indices.insert(indices.end(), t.begin(), t.end());
        offsets.push_back(static_cast<std::uint32_t>(indices.size()));
    }
    return admit({soup.vertices, offsets, indices}, options);
}

/// One body without tunnels, cavities and crossings that holds the soup, and its volume.
void expect_one_ball(const Mesh& soup, double volume, double within, double tolerance)
{
    const AdmitResult result = admitted_outer(soup, {.wrap = {.tolerance = tolerance}});
    ASSERT_EQ(result.admission, Admission::Wrapped) << result.diagnosis.message;
    EXPECT_EQ(result.facts.component_count, 1u);
    EXPECT_EQ(result.facts.genus, 0);
    EXPECT_EQ(result.facts.self_intersecting_pairs, 0u);
    EXPECT_FALSE(first_not_enclosed(soup.vertices, soup.triangles, result.mesh, 0));
    EXPECT_NEAR(result.facts.volume, volume, within * volume);
    EXPECT_TRUE(std::any_of(result.repairs.begin(), result.repairs.end(), [&](const RepairNote& r) {
        return r.kind == RepairKind::Enclosed && r.count == soup.triangles.size();
    }));
}

TEST(Outer, LooseSheetsWithAScrewInsideAndANarrowSlitAreOneBody)
{
    // R_max is about 0.87: the slit is 0.6 % of it.
    const Mesh screw = moved(sphere(1, 2), {0.5, 0.5, 0.5}, 0.1);
    expect_one_ball(test::together(cube_of_sheets(0.005), screw), 1, 0.02, 0.002);
}

TEST(Outer, FlatSidesGetFewTriangles)
{
    const OuterResult result = outer(cube_of_sheets(0));
    EXPECT_LT(result.mesh.triangles.size(), 200u);
}

TEST(Outer, OneSheetIsAPlate)
{
    Mesh soup;
    add_sheet(soup, {0, 0, 0}, {1, 0.2, 0}, {-0.1, 0.7, 0.4});
    const AdmitResult result = admitted_outer(soup);
    ASSERT_EQ(result.admission, Admission::Wrapped) << result.diagnosis.message;
    EXPECT_EQ(result.facts.component_count, 1u);
    EXPECT_EQ(result.facts.genus, 0);
    EXPECT_FALSE(first_not_enclosed(soup.vertices, soup.triangles, result.mesh, 0));
    const double r_max = largest_vertex_distance(soup);
    EXPECT_LE(result.deviation->result_to_input.p99, 0.002 * r_max);
    EXPECT_LE(result.facts.volume, 0.004 * r_max * surface_area(soup) * 1.1);
}

TEST(Outer, CavitiesInCavitiesAreFilled)
{
    Mesh soup = test::together(sphere(1, 4), moved(sphere(1, 3), {}, 0.7));
    soup = test::together(soup, moved(sphere(1, 2), {0.1, 0, 0}, 0.3));
    expect_one_ball(soup, volume(sphere(1, 4)), 0.02, k_twice);
}

/// Half a sphere, open above.
Mesh cup()
{
    const Mesh all = sphere(1, 4);
    Mesh soup{all.vertices, {}};
    for (std::uint32_t t = 0; t < all.triangles.size(); ++t)
        if (triangle_centroid(all, t).z < 0.2) soup.triangles.push_back(all.triangles[t]);
    return soup;
}

TEST(Outer, ACupStaysOpenWhereItsMouthIsWiderThanTheGap)
{
    const AdmitResult result = admitted_outer(cup(), {.wrap = {.tolerance = k_twice}});
    ASSERT_EQ(result.admission, Admission::Wrapped) << result.diagnosis.message;
    EXPECT_EQ(result.facts.genus, 0);
    EXPECT_EQ(Bvh(result.mesh).winding_number({0, 0, 0}), 0);
    EXPECT_EQ(Bvh(result.mesh).winding_number({0, 0, -0.9}), 0);
    EXPECT_LE(result.deviation->result_to_input.p99, k_twice * largest_vertex_distance(cup()));
}

TEST(Outer, AWiderGapClosesTheSlit)
{
    const Mesh soup = cube_of_sheets(0.08);  // 9 % of R_max
    EXPECT_EQ(Bvh(outer(soup, {.tolerance = k_twice}).mesh).winding_number({0.5, 0.5, 0.5}), 0);
    const OuterResult closed = outer(soup, {.tolerance = k_twice, .gap = 0.11});
    EXPECT_EQ(Bvh(closed.mesh).winding_number({0.5, 0.5, 0.5}), 1);
    EXPECT_TRUE(std::any_of(closed.made_up.begin(), closed.made_up.end(), [](std::uint8_t m) { return m != 0; }));
}

/// A cart as games ship it: shells that cross each other, thin sheets a little off them, wheels that stand in both.
Mesh cart()
{
    Mesh soup = test::cube_of({1, 0.45, 0.3});
    soup = test::together(soup, moved(test::cube_of({0.4, 0.44, 0.3}), {-0.55, 0, 0.45}));
    for (const double side : {-0.46, 0.46}) add_sheet(soup, {-1, side, -0.2}, {2, 0, 0}, {0, 0.01, 0.45});
    for (const double x : {-0.6, 0.6}) {
        for (const double y : {-0.47, 0.47}) {
            Mesh wheel = torus({.major_radius = 0.2, .minor_radius = 0.09});
            for (Vec3d& p : wheel.vertices) p = {x + p.x, y - p.z, p.y - 0.3};
            soup = test::together(soup, wheel);
        }
        add_sheet(soup, {x - 0.02, -0.5, -0.3}, {0.04, 0, 0}, {0, 1, 0});
    }
    return soup;
}

TEST(Outer, ShellsThatCrossBecomeFewTrianglesWithoutCrossings)
{
    const Mesh soup = cart();
    const OuterResult result = outer(soup, {.tolerance = 0.003});
    EXPECT_EQ(find_self_intersections(result.mesh).pair_count, 0u);
    EXPECT_LT(result.mesh.triangles.size(), 5'000u);
    EXPECT_FALSE(first_not_enclosed(soup.vertices, soup.triangles, result.mesh, 0));
}

TEST(Outer, TheProofSeesWhatStandsOutAndWhatLiesBeside)
{
    const Mesh solid = sphere(1, 3), needle{{{0, 0, 0}, {0.01, 0, 0}, {0, 0, 1.5}}, {{0, 1, 2}}};
    EXPECT_EQ(first_not_enclosed(needle.vertices, needle.triangles, solid, 0), 0u);
    const Mesh inner = moved(needle, {}, 0.5), beside = moved(needle, {3, 0, 0});
    EXPECT_FALSE(first_not_enclosed(inner.vertices, inner.triangles, solid, 0));
    EXPECT_EQ(first_not_enclosed(beside.vertices, beside.triangles, solid, 0), 0u);
    const Mesh both = test::together(inner, beside);
    EXPECT_EQ(first_not_enclosed(both.vertices, both.triangles, solid, 0), 1u);
    EXPECT_EQ(first_not_enclosed(inner.vertices, inner.triangles, solid, 0.9), 0u);  // nearer to the surface than the margin
}

TEST(Outer, FacesWithoutAreaAreHeldToo)
{
    Mesh soup = sphere(1, 3);
    const auto first = static_cast<std::uint32_t>(soup.vertices.size());
    for (const double x : {1.0, 1.2, 1.4}) soup.vertices.push_back({x, 0, 0});
    soup.triangles.push_back({first, first + 1, first + 2});
    EXPECT_FALSE(first_not_enclosed(soup.vertices, soup.triangles, outer(soup, {.tolerance = k_twice}).mesh, 0));
}

TEST(Outer, IsTheSameOnEveryRun)
{
    const Mesh soup = cube_of_sheets(0.005);
    const OuterResult first = outer(soup, {.tolerance = k_twice}), second = outer(soup, {.tolerance = k_twice});
    EXPECT_EQ(first.mesh.vertices, second.mesh.vertices);
    EXPECT_EQ(first.mesh.triangles, second.mesh.triangles);
}

TEST(Outer, RefusesWhatHasNoAreaAndOptionsOutOfRange)
{
    const Mesh line{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}};
    EXPECT_TRUE(outer(line).mesh.triangles.empty());
    EXPECT_EQ(admitted_outer(line).diagnosis.code, Refusal::Flat);
    EXPECT_THROW((void)outer(sphere(1, 1), {.tolerance = 0}), InvalidInput);
    EXPECT_THROW((void)outer(sphere(1, 1), {.gap = 0.3}), InvalidInput);
    EXPECT_THROW((void)outer(sphere(1, 1), {.max_cells = 10}), InvalidInput);
    EXPECT_EQ(admitted_outer(sphere(1, 3), {.max_cured_faces = 10}).diagnosis.code, Refusal::Limit);
}

}  // namespace
}  // namespace sqmap::mesh
