// Locales and Boundary Strength against shapes whose areas are known.
#include "decompose/locales.h"

#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace sqmap::decompose {
namespace {

using std::numbers::pi;

/// A surface of revolution about z through points (radius, z); the first is a pole of radius 0, the last may be.
mesh::Mesh revolved(const std::vector<std::pair<double, double>>& profile, std::uint32_t segments)
{
    mesh::Mesh m;
    std::vector<std::uint32_t> first;  // vertex of each ring
    for (const auto& [radius, z] : profile) {
        first.push_back(static_cast<std::uint32_t>(m.vertices.size()));
        for (std::uint32_t i = 0; i < (radius > 0 ? segments : 1); ++i) {
            const double angle = 2 * pi * i / segments;
            m.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
        }
    }
    for (std::size_t r = 0; r + 1 < profile.size(); ++r)
        for (std::uint32_t i = 0; i < segments; ++i) {
            const auto at = [&](std::size_t ring, std::uint32_t k) {
                return first[ring] + (profile[ring].first > 0 ? k % segments : 0);
            };
            if (profile[r].first > 0) m.triangles.push_back({at(r, i), at(r, i + 1), at(r + 1, i)});
            if (profile[r + 1].first > 0) m.triangles.push_back({at(r, i + 1), at(r + 1, i + 1), at(r + 1, i)});
        }
    return m;
}

/// Locales about the pole alone, each width wide.
LocaleBands about_the_pole(const mesh::Mesh& m, double width)
{
    DecomposeOptions options = printed_cuts();
    options.locale_width = width / std::sqrt(mesh::surface_area(m));
    const std::vector<double> curvature(m.triangles.size(), 0);
    return locale_bands(m, {.partition = {}, .protrusion = {}, .curvature = curvature, .salient_vertices = {0}}, options);
}

TEST(BoundaryStrength, OfAFlatDiscIsOne)
{
    std::vector<std::pair<double, double>> profile{{0, 0}};
    for (int r = 1; r <= 40; ++r) profile.emplace_back(0.025 * r, 0);
    const LocaleBands bands = about_the_pole(revolved(profile, 96), 0.1);
    ASSERT_EQ(bands.strength.size(), 1u);
    ASSERT_GE(bands.strength[0].size(), 10u);
    for (std::size_t k = 1; k < 10; ++k) EXPECT_NEAR(bands.strength[0][k], 1, 0.01) << k;
}

// The levels of distance cut triangles: a disc of one ring, whose triangles each lie in ten locales, has the same strength.
TEST(BoundaryStrength, DoesNotDependOnTrianglesLargerThanALocale)
{
    const LocaleBands bands = about_the_pole(revolved({{0, 0}, {1, 0}}, 96), 0.1);
    ASSERT_GE(bands.strength[0].size(), 10u);
    for (std::size_t k = 1; k < 10; ++k) EXPECT_NEAR(bands.strength[0][k], 1, 0.01) << k;
}

TEST(BoundaryStrength, IsZeroAlongACylinderAndRisesToOneWhereItMeetsAPlane)
{
    // A cap of radius 0.4, a tube of length 1.2, and a plane about its end.
    std::vector<std::pair<double, double>> profile{{0, 0}};
    for (int r = 1; r <= 16; ++r) profile.emplace_back(0.025 * r, 0);
    for (int z = 1; z <= 48; ++z) profile.emplace_back(0.4, -0.025 * z);
    for (int r = 1; r <= 40; ++r) profile.emplace_back(0.4 + 0.025 * r, -1.2);
    const LocaleBands bands = about_the_pole(revolved(profile, 96), 0.1);
    const std::vector<double>& strength = bands.strength[0];
    ASSERT_GE(strength.size(), 25u);
    for (std::size_t k = 1; k < 4; ++k) EXPECT_NEAR(strength[k], 1, 0.02) << "cap " << k;
    for (std::size_t k = 6; k < 15; ++k) EXPECT_NEAR(strength[k], 0, 0.02) << "tube " << k;
    for (std::size_t k = 18; k < 25; ++k) EXPECT_NEAR(strength[k], 1, 0.03) << "plane " << k;
}

TEST(BoundaryStrength, IsTheDifferenceOfAreasOverThatOnAPlane)
{
    const std::vector<double> strength = boundary_strength({3 * pi, 5 * pi, 5 * pi, pi}, 0.5);
    ASSERT_EQ(strength.size(), 4u);
    EXPECT_EQ(strength[0], 0);
    EXPECT_NEAR(strength[1], 4, 1e-12);
    EXPECT_EQ(strength[2], 0);
    EXPECT_NEAR(strength[3], -8, 1e-12);
    EXPECT_TRUE(boundary_strength({}, 1).empty());
}

TEST(LocaleBands, GiveEachTriangleItsNearestFeatureAndNoneToAnotherPiece)
{
    mesh::Mesh m = mesh::dumbbell();
    const auto count = static_cast<std::uint32_t>(m.triangles.size());
    const auto vertices = static_cast<std::uint32_t>(m.vertices.size());
    const auto extreme = [&](double sign) {
        std::uint32_t best = 0;
        for (std::uint32_t v = 0; v < vertices; ++v)
            if (sign * m.vertices[v].z > sign * m.vertices[best].z) best = v;
        return best;
    };
    const std::vector<std::uint32_t> features{extreme(-1), extreme(1)};
    for (const Vec3d p : {Vec3d{9, 0, 0}, Vec3d{10, 0, 0}, Vec3d{9, 1, 0}}) m.vertices.push_back(p);
    m.triangles.push_back({vertices, vertices + 1, vertices + 2});
    const std::vector<double> curvature(m.triangles.size(), 0);
    const LocaleBands bands = locale_bands(
        m, {.partition = {}, .protrusion = {}, .curvature = curvature, .salient_vertices = features}, printed_cuts());
    for (std::uint32_t t = 0; t < count; ++t) {
        const double z = mesh::triangle_centroid(m, t).z;
        if (std::abs(z) <= 0.1) continue;
        EXPECT_EQ(bands.feature[t], z < 0 ? 0u : 1u) << t;
    }
    EXPECT_EQ(bands.feature[count], LocaleBands::k_none);
    EXPECT_TRUE(std::isinf(bands.distance[vertices]));
    // All of the mesh that a feature reaches is in its locales.
    double sum = 0;
    for (std::size_t v = 0; v < vertices; ++v) sum = std::max(sum, bands.distance[v]);
    EXPECT_LT(sum / bands.width, static_cast<double>(bands.strength[0].size()));
}

}  // namespace
}  // namespace sqmap::decompose
