#include "sqmap/haptic/patch.h"

#include "sqmap/mesh/shapes.h"
#include "touching.h"

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
    const auto by_position = [](const PatchPoints& p) {
        std::vector<std::pair<std::array<double, 3>, double>> all, out;
        for (std::size_t i = 0; i < p.points.size(); ++i)
            all.push_back({{p.points[i].x, p.points[i].y, p.points[i].z}, p.weights[i]});
        std::sort(all.begin(), all.end());
        for (const auto& [position, weight] : all)
            if (!out.empty() && out.back().first == position)
                out.back().second += weight;
            else
                out.push_back({position, weight});
        return out;
    };
    const auto x = by_position(a), y = by_position(b);
    ASSERT_EQ(x.size(), y.size());
    ASSERT_GT(x.size(), 4 * coarse.vertices.size());
    for (std::size_t i = 0; i < x.size(); ++i) {
        EXPECT_EQ(x[i].first, y[i].first);
        EXPECT_NEAR(x[i].second, y[i].second, 1e-5 * x[i].second);
    }
}

TEST(PatchPoints, AreNeverMoreThanTheLimit)
{
    const mesh::Mesh ball = mesh::sphere(0.05, 2);
    const PatchPoints p = patch_points(ball.vertices, ball.triangles, 1e-9, 5000);
    EXPECT_LE(p.points.size(), 5000u);
    EXPECT_GT(p.points.size(), 1000u);
}

TEST(DenserSets, HaveMorePointsEachAndNeverMoreThanTheLimit)
{
    const mesh::Mesh ball = mesh::sphere(0.02, 2);
    std::size_t before = ball.vertices.size();
    const DenserSets sets(ball.vertices, ball.triangles);
    ASSERT_GT(sets.points().size(), 1u);
    for (const DenserPoints& d : sets.points()) {
        EXPECT_GT(d.probe->size(), before);
        EXPECT_EQ(d.weights.size(), d.probe->size());
        before = d.probe->size();
    }
    EXPECT_EQ(sets.max_points(), before);
    EXPECT_LE(DenserSets(ball.vertices, ball.triangles, 2000).max_points(), 2000u);
    EXPECT_TRUE(DenserSets(ball.vertices, ball.triangles, 10).points().empty());
}

/// A coarse ball, its triangles 6 mm wide, above the flat top of a box.
struct Pressed {
    explicit Pressed(double spacing, std::uint32_t max_touching)
        : patch(patch_points(ball.vertices, ball.triangles, spacing)),
          probe(patch.points),
          sets(ball.vertices, ball.triangles),
          zone{.probe = &probe, .weights = patch.weights, .denser = sets.points(), .max_touching = max_touching},
          state(std::span(&zone, 1))
    {
        if (max_touching == 0) state = State(std::span(&(zone.denser = {}, zone), 1));
    }
    Vec3d force(double depth)
    {
        const TouchedBody solid = test::frictionless(test::box());
        const Pose pose = test::shifted({0.0031, 0.0017, 0.03 + 0.02 - depth});
        Wrench w;
        (void)step(state, {.touched = std::span(&solid, 1), .poses = std::span(&pose, 1)}, std::span(&w, 1));
        return w.force;
    }
    [[nodiscard]] const ZoneReport& report() const { return state.report(0); }

    mesh::Mesh ball = mesh::sphere(0.02, 2);
    PatchPoints patch;
    query::Probe probe;
    DenserSets sets;
    Zone zone;
    State state;
};

TEST(DenserPoints, PressLightlyAsTheSurfaceIsAndNotAsItsMeshIs)
{
    Pressed coarse(0, 0), chosen(0, 600), fine(0.0005, 0);
    Vec3d a, b, c;
    for (int i = 0; i < 200; ++i) a = coarse.force(0.001), b = chosen.force(0.001), c = fine.force(0.001);
    EXPECT_GT(norm(a - c), 0.1 * norm(c));
    EXPECT_LT(norm(b - c), 0.05 * norm(c));
    EXPECT_EQ(chosen.report().points, chosen.sets.points().size());
}

TEST(DenserPoints, AreFewerWhereManyTouchAndTheZonesOwnOnceItIsFree)
{
    Pressed ball(0, 100);
    for (int i = 0; i < 20; ++i) (void)ball.force(0.0005);
    EXPECT_GT(ball.report().points, 0u);
    const std::uint32_t light = ball.report().points;
    for (int i = 0; i < 20; ++i) {
        (void)ball.force(0.015);
        const bool few = ball.report().points == 0 || ball.report().contacts <= 100;
        EXPECT_TRUE(few || i < static_cast<int>(light)) << i;
    }
    EXPECT_LT(ball.report().points, light);
    (void)ball.force(0.0005);
    (void)ball.force(-0.01);
    (void)ball.force(0.0005);
    EXPECT_EQ(ball.report().points, 0u);
}

TEST(DenserPoints, AreTakenWithoutAJumpOfTheForce)
{
    Pressed ball(0, 600);
    std::vector<double> forces;
    for (int i = 0; i < 200; ++i) forces.push_back(norm(ball.force(0.001)));
    const auto [least, largest] = std::minmax_element(forces.begin(), forces.end());
    ASSERT_GT(*largest - *least, 0.01);
    // After each 10 ms 1/e of a change is left: a tenth a tick.
    for (std::size_t i = 1; i < forces.size(); ++i) EXPECT_LT(std::fabs(forces[i] - forces[i - 1]), 0.12 * (*largest - *least));
}

}  // namespace
}  // namespace sqmap::haptic
