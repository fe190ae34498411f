// Cloth that feels itself.
#include "sqmap/sim/cloth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace sqmap::sim {
namespace {

constexpr double k_step = 1.0 / 240;

TEST(SelfContacts, GarmentsOfSeveralPiecesAreSetUp)
{
    // Bullet's own tree of faces was joined for ever.
    Cloth cloth(shirt({.vertices = 400}), fabric("cotton"), {.self_collision = true});
    EXPECT_EQ(cloth.step(k_step, {}).status, k_cloth_ok);
}

/// A sheet whose left half is held level, whose right end is carried over it and laid down; the most crossings of any step.
std::size_t folded(bool self)
{
    const Garment g = sheet({{0, 0, 0}, 0.6, 0.4, 0, 0, 400});
    Cloth cloth(g, fabric("cotton"), {.self_collision = self});
    std::vector<std::uint32_t> left;
    std::uint32_t right = 0;
    for (std::uint32_t i = 0; i < g.start.size(); ++i) {
        if (g.start[i].x < 0) left.push_back(i);
        if (g.start[i].x - 1e-3 * std::abs(g.start[i].z) > g.start[right].x - 1e-3 * std::abs(g.start[right].z)) right = i;
    }
    cloth.pin(left, Cloth::k_world, {});
    cloth.grasp(right, 0.05, g.start[right]);
    std::size_t largest = 0;
    std::uint32_t status = 0;
    constexpr int k_steps = 480;
    for (int i = 1; i <= k_steps; ++i) {
        const double turn = std::numbers::pi * i / k_steps;
        cloth.drag({0.27 * std::cos(turn) + 0.03, 0.25 * std::sin(turn) + 0.01, 0});
        if (i == k_steps) cloth.release();
        status |= cloth.step(k_step, {}).status;
        largest = std::max(largest, cloth.crossings());
    }
    for (int i = 0; i < 120; ++i) status |= cloth.step(k_step, {}).status;
    EXPECT_EQ(status, 0u);
    return std::max(largest, cloth.crossings());
}

TEST(SelfContacts, ASheetThatIsFoldedOverNeverGoesThroughItself)
{
    EXPECT_GT(folded(false), 20u);
    EXPECT_EQ(folded(true), 0u);
}

TEST(SelfContacts, WhatComesFastDoesNotPass)
{
    // A strip falls from half a metre on another that is stretched out below: 3 m/s, 13 mm a step, six thicknesses.
    Garment g = sheet({{0, 0, 0}, 0.6, 0.6, 0, 0, 300});
    const Garment strip = sheet({{0.02, 0.5, 0.01}, 0.2, 0.2, 0, 0, 100});
    const auto first = static_cast<std::uint32_t>(g.start.size());
    std::vector<std::uint32_t> rim;
    for (std::uint32_t i = 0; i < first; ++i)
        if (std::max(std::abs(g.start[i].x), std::abs(g.start[i].z)) > 0.299) rim.push_back(i);
    g.start.insert(g.start.end(), strip.start.begin(), strip.start.end());
    g.flat.insert(g.flat.end(), strip.flat.begin(), strip.flat.end());
    for (const auto& t : strip.triangles) g.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    for (const bool self : {false, true}) {
        Fabric cotton = fabric("cotton");
        cotton.damping = 0;
        Cloth cloth(g, cotton, {.self_collision = self});
        cloth.pin(rim, Cloth::k_world, {});
        std::size_t largest = 0;
        for (int i = 0; i < 240; ++i) {
            cloth.step(k_step, {});
            largest = std::max(largest, cloth.crossings());
        }
        double lowest = INFINITY;
        for (std::uint32_t i = first; i < cloth.size(); ++i) lowest = std::min(lowest, cloth.positions()[i].y);
        EXPECT_EQ(lowest > -0.3, self) << lowest;
        EXPECT_EQ(largest == 0, self) << largest;
    }
}

TEST(SelfContacts, WhatLiesOnItselfIsAThicknessApartAndComesToRest)
{
    Garment g = sheet({{0, 0, 0}, 0.4, 0.4, 0, 0, 300});
    const Garment upper = sheet({{0.01, 0.01, 0.007}, 0.2, 0.2, 0, 0, 100});
    const auto first = static_cast<std::uint32_t>(g.start.size());
    std::vector<std::uint32_t> lower(first);
    for (std::uint32_t i = 0; i < first; ++i) lower[i] = i;
    g.start.insert(g.start.end(), upper.start.begin(), upper.start.end());
    g.flat.insert(g.flat.end(), upper.flat.begin(), upper.flat.end());
    for (const auto& t : upper.triangles) g.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    const Fabric cotton = fabric("cotton");
    Cloth cloth(g, cotton, {.self_collision = true});
    cloth.pin(lower, Cloth::k_world, {});
    StepReport r;
    for (int i = 0; i < 480; ++i) r = cloth.step(k_step, {});
    EXPECT_LT(r.fastest, 0.05);
    for (std::uint32_t i = first; i < cloth.size(); ++i) EXPECT_NEAR(cloth.positions()[i].y, cotton.thickness, 2e-4);
}

}  // namespace
}  // namespace sqmap::sim
