#include "sqmap/mesh/wrap.h"

#include "mesh/wrap/winding.h"
#include "sqmap/math/box.h"
#include "sqmap/mesh/admission.h"
#include "sqmap/mesh/bvh.h"
#include "sqmap/mesh/error.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

namespace sqmap::mesh {
namespace {

/// Without the triangles whose centroid the predicate takes.
template <class Predicate>
Mesh without(Mesh mesh, Predicate removed)
{
    const Mesh all = mesh;
    mesh.triangles.clear();
    for (std::uint32_t t = 0; t < all.triangles.size(); ++t)
        if (!removed(triangle_centroid(all, t))) mesh.triangles.push_back(all.triangles[t]);
    return mesh;
}

Mesh half_sphere()
{
    return without(sphere(1, 4), [](Vec3d c) { return c.z < 0; });
}

Mesh inside_out(Mesh mesh)
{
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return mesh;
}

/// Triangles that share no vertices.
Mesh loose(const Mesh& mesh)
{
    Mesh soup;
    for (const Triangle& t : mesh.triangles) {
        const auto first = static_cast<std::uint32_t>(soup.vertices.size());
        for (const std::uint32_t v : t) soup.vertices.push_back(mesh.vertices[v]);
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    return soup;
}

/// A cube whose sides stand beyond its edges by some length.
Mesh panels(double beyond)
{
    Mesh soup;
    for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
            const auto first = static_cast<std::uint32_t>(soup.vertices.size());
            for (int k = 0; k < 4; ++k) {
                Vec3d p;
                p[axis] = side;
                p[(axis + 1) % 3] = (k == 1 || k == 2 ? 1 : -1) * (1 + beyond) * side;
                p[(axis + 2) % 3] = (k >= 2 ? 1 : -1) * (1 + beyond);
                soup.vertices.push_back(p);
            }
            soup.triangles.push_back({first, first + 1, first + 2});
            soup.triangles.push_back({first, first + 2, first + 3});
        }
    }
    return soup;
}

/// A sixth of the default's cells: for tests whose subject is not the default tolerance.
constexpr WrapOptions k_coarse{.tolerance = 0.005, .thickness = 0.0075};

WrapResult wrapped(const Mesh& soup, const WrapOptions& options = {}) { return wrap(soup.vertices, soup.triangles, options); }

AdmitResult admitted(const Mesh& mesh, const AdmitOptions& options = {})
{
    std::vector<std::uint32_t> offsets{0};
    std::vector<std::int64_t> indices;
    for (const Triangle& t : mesh.triangles) {
        indices.insert(indices.end(), t.begin(), t.end());
        offsets.push_back(static_cast<std::uint32_t>(indices.size()));
    }
    return admit({mesh.vertices, offsets, indices}, options);
}

void expect_gate_takes(const WrapResult& result)
{
    const AdmitResult gate = admitted(result.mesh);
    EXPECT_NE(gate.admission, Admission::Refused) << gate.diagnosis.message;
    EXPECT_TRUE(gate.solid);
    EXPECT_EQ(gate.facts.boundary_edge_count, 0u);
    EXPECT_EQ(gate.facts.nonmanifold_edge_count, 0u);
    for (const RepairNote& note : gate.repairs) EXPECT_EQ(note.kind, RepairKind::DegenerateFaces) << name_of(note.kind);
    ASSERT_EQ(result.made_up.size(), result.mesh.triangles.size());
}

/// Points farther than 0.5 % of R_max from the input and from what was made up, whose verdict is not that of the generalized
/// winding number.
int wrong_verdicts(const WrapResult& result, const Mesh& soup, int count)
{
    const double far = 0.005 * largest_vertex_distance(soup);
    Mesh all = result.mesh;
    all.triangles.clear();
    for (std::size_t t = 0; t < result.made_up.size(); ++t)
        if (result.made_up[t]) all.triangles.push_back(result.mesh.triangles[t]);
    all = test::together(all, soup);
    const Bvh excluded(all), solid(result.mesh);
    const WindingNumber oracle(soup);
    const Box box = box_of(soup.vertices);
    const Vec3d rim = 0.05 * size(box);
    test::Random random(7);
    int wrong = 0;
    for (int tested = 0; tested < count;) {
        const Vec3d p = random.in_box(box.lo - rim, box.hi + rim);
        if (excluded.closest_point(p, far).distance < far) continue;
        ++tested;
        // Groups are within 2e-3 of the direct sum, as another test shows.
        const double groups = oracle.at(p), winding = std::abs(groups - 0.5) > 0.01 ? groups : oracle.direct(p);
        wrong += (winding > 0.5) != (solid.winding_number(p) > 0) ? 1 : 0;
    }
    return wrong;
}

/// The distance from the input, over R_max, that one in a hundred of the points on triangles that are not made up exceeds.
double deviation(const WrapResult& result, const Mesh& soup)
{
    const Bvh bvh(soup);
    test::Random random(9);
    std::vector<double> areas, distances;
    double sum = 0;
    for (std::uint32_t t = 0; t < result.made_up.size(); ++t)
        areas.push_back(sum += result.made_up[t] ? 0 : triangle_area(result.mesh, t));
    for (int i = 0; i < 5000; ++i) {
        const auto t = std::upper_bound(areas.begin(), areas.end(), random.between(0, sum)) - areas.begin();
        double u = random.uniform(), v = random.uniform();
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const auto& [a, b, c] = result.mesh.triangles[t];
        const auto& x = result.mesh.vertices;
        distances.push_back(bvh.closest_point(x[a] + u * (x[b] - x[a]) + v * (x[c] - x[a])).distance);
    }
    std::sort(distances.begin(), distances.end());
    return distances[distances.size() * 99 / 100] / largest_vertex_distance(soup);
}

double share_made_up(const WrapResult& result)
{
    double made_up = 0, all = 0;
    for (std::uint32_t t = 0; t < result.made_up.size(); ++t) {
        all += triangle_area(result.mesh, t);
        if (result.made_up[t]) made_up += triangle_area(result.mesh, t);
    }
    return made_up / all;
}

TEST(WindingNumber, OfACapIsItsSolidAngle)
{
    const WindingNumber cap(half_sphere());
    EXPECT_NEAR(cap.direct({0, 0, 0}), 0.5, 0.02);  // 2 pi of 4 pi, up to the ragged rim
    const Mesh ball = sphere(1, 3);
    const WindingNumber closed(ball), reversed(inside_out(ball));
    EXPECT_NEAR(closed.direct({0.3, 0.2, 0.1}), 1, 1e-12);
    EXPECT_NEAR(closed.direct({1.3, 0.2, 0.1}), 0, 1e-12);
    EXPECT_NEAR(reversed.direct({0.3, 0.2, 0.1}), -1, 1e-12);
}

TEST(WindingNumber, OfGroupsIsNearTheDirectSum)
{
    const Mesh soup = half_sphere();
    const WindingNumber winding(soup);
    test::Random random(1);
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d p = random.in_box({-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5});
        worst = std::max(worst, std::abs(winding.at(p) - winding.direct(p)));
    }
    EXPECT_LT(worst, 2e-3);
    EXPECT_GT(worst, 0);
}

TEST(Wrap, ASphereWithHolesAndNoiseBecomesASolid)
{
    Mesh soup = without(sphere(1, 4), [](Vec3d c) {
        return c.z > 0.9 || norm(c - Vec3d{1, 0, 0}) < 0.3 || norm(c - Vec3d{0, -0.8, -0.6}) < 0.2;
    });
    test::Random random(2);
    for (Vec3d& v : soup.vertices) v += 0.002 * random.direction();
    const WrapResult result = wrapped(soup);
    expect_gate_takes(result);
    EXPECT_EQ(wrong_verdicts(result, soup, 5000), 0);
    EXPECT_LE(deviation(result, soup), 0.002);
    EXPECT_NEAR(share_made_up(result), (0.05 + 0.0225 + 0.01), 0.03);  // of a sphere's area, a cap of chord c has c^2 / 4
    EXPECT_EQ(result.thickness, 0);
}

TEST(Wrap, ASoupOfASphereIsTheSphere)
{
    const Mesh soup = loose(sphere(1, 4));
    const WrapResult result = wrapped(soup, k_coarse);
    expect_gate_takes(result);
    EXPECT_EQ(wrong_verdicts(result, soup, 5000), 0);
    EXPECT_LE(deviation(result, soup), k_coarse.tolerance / 2);
    EXPECT_EQ(share_made_up(result), 0);
    EXPECT_NEAR(volume(result.mesh), volume(sphere(1, 4)), 0.03);
}

TEST(Wrap, AnOpenHalfSphereBecomesAHalfBall)
{
    const Mesh soup = half_sphere();
    const WrapResult result = wrapped(soup, k_coarse);
    expect_gate_takes(result);
    EXPECT_EQ(wrong_verdicts(result, soup, 5000), 0);
    EXPECT_LE(deviation(result, soup), k_coarse.tolerance);
    EXPECT_NEAR(share_made_up(result), 1.0 / 3, 0.02);  // the disc
    EXPECT_NEAR(volume(result.mesh), 2.0 / 3 * std::numbers::pi, 0.06);
}

TEST(Wrap, CrossingPiecesBecomeOneSolid)
{
    const Mesh soup = test::crossing_bars();
    const WrapResult result = wrapped(soup);
    expect_gate_takes(result);
    EXPECT_EQ(wrong_verdicts(result, soup, 5000), 0);
    EXPECT_LE(deviation(result, soup), 0.0002);
    EXPECT_NEAR(volume(result.mesh), 7, 0.02);  // two bars of 4 x 1 x 1 that share a cube
    EXPECT_LE(result.mesh.triangles.size(), 500u);
}

TEST(Wrap, LoosePanelsBecomeABox)
{
    const Mesh soup = panels(-0.01);
    const WrapResult result = wrapped(soup);
    expect_gate_takes(result);
    EXPECT_EQ(wrong_verdicts(result, soup, 5000), 0);
    EXPECT_LE(deviation(result, soup), 0.002);
    const Box box = box_of(result.mesh.vertices);
    EXPECT_NEAR(size(box).x, 2, 0.02);
    EXPECT_NEAR(volume(result.mesh), 8, 0.05);
}

TEST(Wrap, PanelsThatStandOutBecomeShellsOfTheLeastThickness)
{
    const Mesh soup = panels(0.2);
    const WrapResult result = wrapped(soup, k_coarse);
    expect_gate_takes(result);
    EXPECT_EQ(wrong_verdicts(result, soup, 5000), 0);
    EXPECT_LE(deviation(result, soup), k_coarse.tolerance);
    EXPECT_NEAR(result.thickness, k_coarse.thickness * largest_vertex_distance(soup), 1e-12);
    EXPECT_NEAR(size(box_of(result.mesh.vertices)).x, 2.4 + result.thickness, 0.01);
}

TEST(Wrap, DoubledSheetsBecomeShells)
{
    const Mesh sheet = half_sphere(), soup = test::together(sheet, inside_out(sheet));
    const WrapResult result = wrapped(soup, k_coarse);
    expect_gate_takes(result);
    EXPECT_EQ(wrong_verdicts(result, soup, 5000), 0);
    EXPECT_LE(deviation(result, soup), k_coarse.tolerance);
    const double thickness = k_coarse.thickness * largest_vertex_distance(soup);
    EXPECT_NEAR(result.thickness, thickness, 1e-12);
    EXPECT_NEAR(volume(result.mesh), thickness * surface_area(sheet), 0.1 * thickness * surface_area(sheet));
    const Bvh shell(result.mesh);
    for (std::uint32_t t = 0; t < sheet.triangles.size(); ++t) ASSERT_EQ(shell.winding_number(triangle_centroid(sheet, t)), 1);
}

TEST(Wrap, TheBudgetOfTrianglesWinsOverTheTolerance)
{
    const Mesh soup = loose(test::small_torus());
    WrapOptions few_triangles = k_coarse;
    few_triangles.max_triangles = 400;
    const WrapResult all = wrapped(soup, k_coarse), few = wrapped(soup, few_triangles);
    EXPECT_GT(all.mesh.triangles.size(), 400u);
    EXPECT_LE(few.mesh.triangles.size(), 400u);
    EXPECT_GT(few.bound, all.bound);
    expect_gate_takes(few);
    EXPECT_LE(deviation(few, soup), few.bound / largest_vertex_distance(soup));
}

TEST(Wrap, TheGateWarnsWhereTheToleranceIsMissed)
{
    const auto warns = [](const AdmitOptions& options) {
        const AdmitResult result = admitted(half_sphere(), options);
        EXPECT_EQ(result.admission, Admission::Wrapped);
        return std::any_of(result.warnings.begin(), result.warnings.end(),
                           [](const Warning& w) { return w.kind == WarningKind::Tolerance; });
    };
    EXPECT_FALSE(warns({.wrap = k_coarse}));
    WrapOptions few_triangles = k_coarse;
    few_triangles.max_triangles = 100;
    EXPECT_TRUE(warns({.wrap = few_triangles}));
}

TEST(Wrap, IsTheSameOnEveryRunAndCanonical)
{
    const Mesh soup = panels(0.1);
    const WrapResult first = wrapped(soup, k_coarse), second = wrapped(soup, k_coarse);
    EXPECT_EQ(first.mesh.vertices, second.mesh.vertices);
    EXPECT_EQ(first.mesh.triangles, second.mesh.triangles);
    EXPECT_EQ(first.made_up, second.made_up);
    const Mesh canonical = canonicalized(first.mesh);
    EXPECT_EQ(first.mesh.vertices, canonical.vertices);
    EXPECT_EQ(first.mesh.triangles, canonical.triangles);
}

TEST(Wrap, RefusesWhatIsTooLargeBeforeItStarts)
{
    const Mesh soup = sphere(1, 4);
    try {
        (void)wrapped(soup, {.max_cells = 10'000});
        FAIL() << "took 5120 triangles with 10,000 cells";
    } catch (const RefusedMesh& e) {
        EXPECT_EQ(e.diagnosis().code, Refusal::Limit);
        EXPECT_NE(e.diagnosis().cure.text().find("max_cells"), std::string::npos);
    }
    EXPECT_THROW((void)wrapped(soup, {.tolerance = 0}), InvalidInput);
    EXPECT_THROW((void)wrapped(soup, {.thickness = 0.1}), InvalidInput);
    WrapOptions few_cells = k_coarse;
    few_cells.max_cells = 11'000;
    EXPECT_GT(wrapped(soup, few_cells).cell, wrapped(soup, k_coarse).cell);  // coarser, and stated
}

TEST(Wrap, NothingHasNoSolid)
{
    EXPECT_TRUE(wrap({}, {}).mesh.triangles.empty());
    const std::vector<Vec3d> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    const std::vector<Triangle> triangles{{0, 1, 2}};
    EXPECT_TRUE(wrap(line, triangles).mesh.triangles.empty());
}

}  // namespace
}  // namespace sqmap::mesh
