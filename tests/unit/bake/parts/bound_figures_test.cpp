#include "bake/parts/bound_figures.h"

#include "fit/polytope.h"
#include "mesh/convex_hull.h"
#include "sqmap/query/point.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sqmap::bake {
namespace {

constexpr std::size_t k_superquadric = 0, k_polytope = 1, k_both = 2;

bool superquadric_holds(const model::ModelView& m, std::size_t part, Vec3d p)
{
    return shape::implicit(shape::cast<double>(model::superquadric_of(m.parts[part])), p) <= 1;
}
bool polytope_holds(const model::ModelView& m, std::size_t part, Vec3d p)
{
    return std::ranges::all_of(model::polytope_of(m, part),
                               [&](const HalfSpacef& side) { return holds(std::vector{cast<double>(side)}, p); });
}

/// Every figure against random points of a box, which share no code with them.
TEST(BoundFigures, AreThoseOfRandomPoints)
{
    const test::Baked b = test::baked(test::small_hand());
    const model::ModelView m = b.in_model_space();
    const std::size_t parts = m.parts.size();
    ASSERT_EQ(m.bound_figures.size(), parts + 1);
    Box box;
    for (const Vec3d& v : b.mesh.vertices) extend(box, v);
    const Vec3d border = 0.4 * size(box), lo = box.lo - border, hi = box.hi + border;
    const double cube = (hi.x - lo.x) * (hi.y - lo.y) * (hi.z - lo.z);
    test::Random random(6);
    constexpr int k_points = 300000;
    std::vector<std::array<int, 3>> count(parts + 1);
    for (int i = 0; i < k_points; ++i) {
        const Vec3d p = random.in_box(lo, hi);
        bool in_some[3] = {};
        for (std::size_t part = 0; part < parts; ++part) {
            const bool in[3] = {superquadric_holds(m, part, p), polytope_holds(m, part, p), false};
            for (std::size_t k = 0; k < 3; ++k) {
                const bool is_in = k == k_both ? in[0] && in[1] : in[k];
                count[part][k] += is_in ? 1 : 0;
                in_some[k] = in_some[k] || is_in;
            }
        }
        for (std::size_t k = 0; k < 3; ++k) count[parts][k] += in_some[k] ? 1 : 0;
    }
    for (std::size_t part = 0; part <= parts; ++part)
        for (std::size_t k = 0; k < 3; ++k) {
            const double n = count[part][k], volume = cube * n / k_points, error = cube * std::sqrt(n) / k_points;
            const double tolerance = 4 * (error + static_cast<double>(m.bound_figures[part].standard_error)) + 1e-3 * volume;
            EXPECT_NEAR(static_cast<double>(m.bound_figures[part].volume[k]), volume, tolerance) << part << ' ' << k;
        }
    EXPECT_NEAR(static_cast<double>(m.bound_figures[parts].solid_volume), mesh::volume(b.mesh), 1e-5);
}

TEST(BoundFigures, AreOrderedAsTheBoundsAre)
{
    for (const test::Shape& shape : test::small_shapes()) {
        const test::Baked b = test::baked(shape.mesh);
        double solid = 0;
        for (std::size_t i = 0; i < b.result.model.bound_figures.size(); ++i) {
            const model::BoundFigures& f = b.result.model.bound_figures[i];
            EXPECT_LE(f.volume[k_both], 1.001f * f.volume[k_superquadric]) << shape.name;
            EXPECT_LE(f.volume[k_both], f.volume[k_polytope] + 4 * f.standard_error) << shape.name;
            // No bound is smaller than what it holds.
            EXPECT_GE(f.volume[k_both], f.solid_volume - 4 * f.standard_error) << shape.name;
            for (const float excess : f.excess) EXPECT_GE(excess, 0);
            EXPECT_LE(f.excess[k_both], 1.0001f * f.excess[k_superquadric] + 1e-5f) << shape.name;
            EXPECT_LE(f.excess[k_both], 1.0001f * f.excess[k_polytope] + 1e-5f) << shape.name;
            if (i < b.result.model.parts.size()) solid += static_cast<double>(f.solid_volume);
        }
        EXPECT_NEAR(solid, static_cast<double>(b.result.model.bound_figures.back().solid_volume), 1e-4 * solid) << shape.name;
    }
}

TEST(BoundFigures, OfASurfaceHaveNoSolid)
{
    mesh::Mesh half = test::small_sphere();
    std::erase_if(half.triangles, [&](const mesh::Triangle& t) { return half.vertices[t[0]].z > 0.3; });
    const BakeResult surface = bake(mesh::canonicalized(half), false, {});
    ASSERT_FALSE(surface.model.bound_figures.empty());
    for (const model::BoundFigures& f : surface.model.bound_figures) {
        EXPECT_EQ(f.solid_volume, 0);
        EXPECT_GT(f.volume[k_both], 0);
    }
}

/// Support excess of a part's polytope as bounding_polytope alone gives it, for the superquadric of the model.
double greedy_excess(const test::Baked& b, const mesh::Mesh& hull)
{
    const auto sq = shape::cast<double>(model::superquadric_of(b.in_model_space().parts[0]));
    std::vector<HalfSpaced> sides;
    for (const HalfSpacef& side : fit::bounding_polytope(hull, hull.vertices, sq)) sides.push_back(cast<double>(side));
    return mesh::farthest_from_hull(hull, mesh::polytope_corners(sides));
}

// The hull of four balls, as a link of a robot is: one part, for which twenty sides are few.
TEST(BoundFigures, OfARoundConvexPartAreThoseOfSidesTurnedForTheLeastExcess)
{
    std::vector<Vec3d> points;
    for (const Vec3d& middle : {Vec3d{0, 0, 0}, Vec3d{0, 0.2, 1}, Vec3d{0.9, 0, 1.1}, Vec3d{0.2, 1.1, 0.3}})
        for (const Vec3d& p : mesh::sphere(0.4, 2).vertices) points.push_back(middle + p);
    const test::Baked b = test::baked(mesh::canonicalized(mesh::convex_hull(points)));
    ASSERT_EQ(b.in_model_space().parts.size(), 1u);
    const model::BoundFigures& whole = b.in_model_space().bound_figures.back();
    EXPECT_LT(static_cast<double>(whole.excess[k_polytope]), 0.75 * greedy_excess(b, mesh::convex_hull(b.mesh.vertices)));
    EXPECT_LT(whole.excess[k_both] / b.in_model_space().header.r_max, 0.035f);
}

}  // namespace
}  // namespace sqmap::bake
