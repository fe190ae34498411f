#include "sqmap/sim/garment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace sqmap::sim {
namespace {

double area(const Garment& g)
{
    double sum = 0;
    for (const auto& t : g.triangles) sum += 0.5 * norm(cross(g.flat[t[1]] - g.flat[t[0]], g.flat[t[2]] - g.flat[t[0]]));
    return sum;
}

/// Every edge has one triangle or two, every vertex some, and start and flat have the same edges where the start is flat.
void expect_sound(const Garment& g)
{
    ASSERT_EQ(g.start.size(), g.flat.size());
    std::map<std::array<std::uint32_t, 2>, int> edges;
    std::vector<int> uses(g.start.size());
    for (const auto& t : g.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            ASSERT_LT(t[k], g.start.size());
            ++uses[t[k]];
            ++edges[{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])}];
        }
    for (const int n : uses) EXPECT_GT(n, 0);
    for (const auto& [ends, n] : edges) {
        EXPECT_LE(n, 2);
        EXPECT_NEAR(norm(g.start[ends[0]] - g.start[ends[1]]), norm(g.flat[ends[0]] - g.flat[ends[1]]), 1e-12);
    }
}

TEST(Garment, ASheetHasItsAreaAndAboutItsVertices)
{
    const Garment g = sheet({{1, 2, 3}, 1.2, 0.8, 0, 0, 1000});
    expect_sound(g);
    EXPECT_NEAR(area(g), 0.96, 1e-12);
    EXPECT_NEAR(static_cast<double>(g.start.size()), 1000, 100);
    for (const Vec3d& p : g.start) EXPECT_EQ(p.y, 2);
}

TEST(Garment, APonchoIsASheetLessItsHole)
{
    const Garment g = sheet({{0, 1, 0}, 1, 1, 0.2, 0.1, 20000});
    expect_sound(g);
    EXPECT_NEAR(area(g), 1 - std::numbers::pi * 0.2 * 0.1, 0.004);
}

TEST(Garment, ASkirtIsARingWhoseWaistIsItsInnerEdge)
{
    const Garment g = skirt({{0, 1, 0}, 0.15, 0.5, 8000});
    expect_sound(g);
    EXPECT_NEAR(area(g), std::numbers::pi * (0.65 * 0.65 - 0.15 * 0.15), 0.01);
    EXPECT_NEAR(static_cast<double>(g.start.size()), 8000, 400);
    for (const std::uint32_t v : g.waist) EXPECT_NEAR(std::hypot(g.start[v].x, g.start[v].z), 0.15, 1e-12);
}

TEST(Garment, AShirtsSeamsJoinTheSamePositionsOfBothPanelsAndLeaveOpenings)
{
    const ShirtPattern p;
    const Garment g = shirt(p);
    expect_sound(g);
    EXPECT_NEAR(area(g), 2 * (p.chest * p.length + (p.span - p.chest) * p.sleeve), 0.05);
    ASSERT_EQ(g.seams.size(), 2u);
    double neck = 1, hem = 0;
    for (const Seam& seam : g.seams) {
        EXPECT_GT(seam.pairs.size(), 10u);
        for (const auto& [a, b] : seam.pairs) {
            EXPECT_EQ(g.flat[a], g.flat[b]);
            EXPECT_NEAR(norm(g.start[a] - g.start[b]), 2 * p.gap, 1e-12);
            if (seam.name == "shoulders") neck = std::min(neck, std::abs(g.start[a].x));
            if (seam.name == "sides" && std::abs(g.start[a].x) < 0.4 * p.chest) hem = 1;
        }
    }
    EXPECT_NEAR(neck, 0.5 * p.neck, 0.02);
    EXPECT_EQ(hem, 0);
}

TEST(Garment, SizesThatMakeNoClothAreRefusedAndFabricsAreNamed)
{
    EXPECT_THROW((void)sheet({{}, -1, 1, 0, 0, 100}), std::invalid_argument);
    EXPECT_THROW((void)sheet({{}, 1, 1, 2, 2, 100}), std::invalid_argument);
    EXPECT_THROW((void)skirt({{}, 0, 1, 100}), std::invalid_argument);
    EXPECT_THROW((void)shirt({.span = 0.1}), std::invalid_argument);
    EXPECT_GT(fabric("denim").density, fabric("silk").density);
    EXPECT_THROW((void)fabric("tin"), std::invalid_argument);
}

}  // namespace
}  // namespace sqmap::sim
