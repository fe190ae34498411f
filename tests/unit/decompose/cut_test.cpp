#include "decompose/cut.h"

#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sqmap::decompose {
namespace {

double weight_of(const CutSurface& s, const std::vector<std::uint8_t>& near, double radius)
{
    double sum = 0;
    for (std::uint32_t t = 0; t < near.size(); ++t)
        for (int e = 0; e < 3; ++e)
            if (const auto o = s.graph.neighbours[t][e]; o != mesh::k_no_triangle && o > t && near[o] != near[t])
                sum += s.edge_length[t][e] / (1 + radius * s.edge_concavity[t][e]);
    return sum;
}

TEST(BestCut, IsTheLeastOfAllCutsOfASmallBand)
{
    const mesh::Mesh m = mesh::sphere(1, 0);  // 20 triangles: every subset of a free band can be tried
    const CutSurface s(m);
    std::vector<double> field;
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t)
        field.push_back(mesh::triangle_centroid(m, t).z + 0.3 * mesh::triangle_centroid(m, t).x);
    const double level = 0.1, band = 0.5, radius = 1;
    const auto near = best_cut(s, all_triangles(s), field, {level, band, radius});
    std::vector<std::uint32_t> free;
    std::vector<std::uint8_t> trial(field.size());
    for (std::uint32_t t = 0; t < field.size(); ++t) {
        trial[t] = field[t] < level;
        if (std::abs(field[t] - level) < band)
            free.push_back(t);
        else
            EXPECT_EQ(near[t], trial[t]);
    }
    ASSERT_GE(free.size(), 6u);
    ASSERT_LE(free.size(), 16u);
    double least = 1e9;
    for (std::uint32_t bits = 0; bits < (1u << free.size()); ++bits) {
        for (std::size_t i = 0; i < free.size(); ++i) trial[free[i]] = (bits >> i) & 1;
        least = std::min(least, weight_of(s, trial, radius));
    }
    EXPECT_NEAR(weight_of(s, near, radius), least, 1e-9);
}

TEST(BestCut, OfADumbbellIsAroundTheBar)
{
    const mesh::Mesh m = mesh::dumbbell();
    const CutSurface s(m);
    std::vector<double> field;
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t) field.push_back(mesh::triangle_centroid(m, t).z);
    const auto near = best_cut(s, all_triangles(s), field, {1.2, 1.1, 0.35});
    for (std::uint32_t t = 0; t < near.size(); ++t)
        for (int e = 0; e < 3; ++e)
            if (near[s.graph.neighbours[t][e]] != near[t])
                for (const int c : {e, (e + 1) % 3}) {
                    const Vec3d v = m.vertices[m.triangles[t][c]];
                    EXPECT_LT(std::hypot(v.x, v.y), 0.45);
                }
}

TEST(MeanConcavity, TellsACreaseFromARidge)
{
    const mesh::Mesh m = mesh::dumbbell();
    const CutSurface s(m);
    const auto all = all_triangles(s);
    const auto cut_at = [&](double z) {
        std::vector<std::uint8_t> near;
        for (const auto t : all) near.push_back(mesh::triangle_centroid(m, t).z < z);
        return mean_concavity(s, all, near, 0.35);
    };
    const double crease = 1.8 - std::sqrt(1 - 0.35 * 0.35);  // where the bar meets the ball
    EXPECT_GT(cut_at(crease), 0.3);
    EXPECT_LT(cut_at(1.8), 0.05);  // the ball's equator
}

TEST(PartSurface, HasTheWholesEdgesButForItsBorder)
{
    const mesh::Mesh m = mesh::dumbbell();
    const CutSurface whole(m);
    std::vector<std::uint32_t> upper, number(m.triangles.size(), mesh::k_no_triangle);
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t)
        if (mesh::triangle_centroid(m, t).z > 0.5) {
            number[t] = static_cast<std::uint32_t>(upper.size());
            upper.push_back(t);
        }
    const PartSurface part(whole, upper);
    const CutSurface& own = part.surface();
    ASSERT_EQ(own.mesh.triangles.size(), upper.size());
    EXPECT_LT(own.mesh.vertices.size(), m.vertices.size());
    EXPECT_EQ(own.total_area, whole.area_of(upper));
    std::size_t on_border = 0;
    for (std::uint32_t t = 0; t < upper.size(); ++t) {
        EXPECT_EQ(mesh::triangle_centroid(own.mesh, t), mesh::triangle_centroid(m, upper[t]));
        for (int e = 0; e < 3; ++e) {
            const std::uint32_t across = number[whole.graph.neighbours[upper[t]][e]];
            EXPECT_EQ(own.graph.neighbours[t][e], across);
            on_border += across == mesh::k_no_triangle ? 1 : 0;
            EXPECT_EQ(own.edge_length[t][e], whole.edge_length[upper[t]][e]);
            EXPECT_EQ(own.edge_concavity[t][e], whole.edge_concavity[upper[t]][e]);
        }
    }
    EXPECT_GT(on_border, 0u);
}

double volume_of(const mesh::Mesh& m)
{
    const CutSurface s(m);
    return ellipsoid_volume(s, all_triangles(s));
}

TEST(EllipsoidVolume, DoesNotTurnWithTheMeshAndGrowsWithItsCube)
{
    const mesh::Mesh m = mesh::ellipsoid({1, 2, 3}, 3);
    const double volume = volume_of(m);
    mesh::Mesh turned = m;
    for (Vec3d& v : turned.vertices) v = 2.0 * Vec3d{0.6 * v.x - 0.8 * v.y, 0.8 * v.x + 0.6 * v.y, v.z} + Vec3d{5, 6, 7};
    EXPECT_NEAR(volume_of(turned) / volume, 8, 1e-9);
    // A ball is its own ellipsoid of inertia: half the radius, an eighth of the volume.
    const mesh::Mesh ball = mesh::sphere(1, 3), half = mesh::sphere(0.5, 3);
    EXPECT_NEAR(volume_of(half) / volume_of(ball), 0.125, 1e-9);
}

}  // namespace
}  // namespace sqmap::decompose
