#include "sqmap/haptic/patch.h"

#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sqmap::haptic {
namespace {

double total(const PatchPoints& p) { return std::accumulate(p.weights.begin(), p.weights.end(), 0.); }

/// Every triangle split in four, without looking for shared edges.
mesh::Mesh finer(const mesh::Mesh& in)
{
    mesh::Mesh out;
    for (const mesh::Triangle& t : in.triangles) {
        const auto at = static_cast<std::uint32_t>(out.vertices.size());
        const Vec3d a = in.vertices[t[0]], b = in.vertices[t[1]], c = in.vertices[t[2]];
        out.vertices.insert(out.vertices.end(), {a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)});
        for (const mesh::Triangle& s : {mesh::Triangle{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}})
            out.triangles.push_back({at + s[0], at + s[1], at + s[2]});
    }
    return out;
}

TEST(PatchPoints, WithoutASpacingAreTheVerticesWithTheSurfaceSharedAmongThem)
{
    const mesh::Mesh ball = mesh::sphere(0.02, 3);
    const PatchPoints p = patch_points(ball.vertices, ball.triangles, 0);
    EXPECT_EQ(p.points, ball.vertices);
    double area = 0;
    for (std::uint32_t t = 0; t < ball.triangles.size(); ++t) area += mesh::triangle_area(ball, t);
    EXPECT_NEAR(total(p), area, 1e-6 * area);
}

TEST(PatchPoints, LieNoFartherApartThanTheSpacingAndKeepTheArea)
{
    // One triangle with a right angle: its area has a closed form.
    const std::vector<Vec3d> corners{{0, 0, 0}, {0.03, 0, 0}, {0, 0.04, 0}};
    const std::vector<mesh::Triangle> one{{0, 1, 2}};
    for (const double spacing : {0.06, 0.02, 0.003}) {
        const PatchPoints p = patch_points(corners, one, spacing);
        EXPECT_NEAR(total(p), 0.0006, 1e-9);
        for (const Vec3d& q : corners) EXPECT_EQ(std::count(p.points.begin(), p.points.end(), q), 1);
        // The longest edge is 5 cm; halved until it is short enough.
        const auto n = static_cast<std::size_t>(std::pow(2, std::max(0., std::ceil(std::log2(0.05 / spacing)))));
        EXPECT_EQ(p.points.size(), (n + 1) * (n + 2) / 2) << spacing;
    }
}

TEST(PatchPoints, OfACoarseAndAFinerMeshOfOneSurfaceAreTheSame)
{
    const mesh::Mesh coarse = mesh::sphere(0.05, 2), fine = finer(coarse);
    const PatchPoints a = patch_points(coarse.vertices, coarse.triangles, 0.004);
    const PatchPoints b = patch_points(fine.vertices, fine.triangles, 0.004);
    // The finer one does not share its corners: what lies in one place is one point.
    const auto by_place = [](const PatchPoints& p) {
        std::vector<std::pair<std::array<double, 3>, double>> all, out;
        for (std::size_t i = 0; i < p.points.size(); ++i)
            all.push_back({{p.points[i].x, p.points[i].y, p.points[i].z}, p.weights[i]});
        std::sort(all.begin(), all.end());
        for (const auto& [place, weight] : all)
            if (!out.empty() && out.back().first == place)
                out.back().second += weight;
            else
                out.push_back({place, weight});
        return out;
    };
    const auto x = by_place(a), y = by_place(b);
    ASSERT_EQ(x.size(), y.size());
    ASSERT_GT(x.size(), 4 * coarse.vertices.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        EXPECT_EQ(x[i].first, y[i].first);
        EXPECT_NEAR(x[i].second, y[i].second, 1e-5 * x[i].second);
    }
}

TEST(PatchPoints, AreNeverMoreThanAsked)
{
    const mesh::Mesh ball = mesh::sphere(0.05, 2);
    const PatchPoints p = patch_points(ball.vertices, ball.triangles, 1e-9, 5000);
    EXPECT_LE(p.points.size(), 5000u);
    EXPECT_GT(p.points.size(), 1000u);
}

}  // namespace
}  // namespace sqmap::haptic
