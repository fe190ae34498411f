#include "decompose/geodesic.h"

#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sqmap::decompose {
namespace {

// A square sheet of n by n quads, each cut in two.
mesh::Mesh sheet(std::uint32_t n)
{
    mesh::Mesh m;
    for (std::uint32_t i = 0; i <= n; ++i)
        for (std::uint32_t j = 0; j <= n; ++j) m.vertices.push_back({double(i), double(j), 0});
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
            m.triangles.push_back({a, b, b + 1});
            m.triangles.push_back({a, b + 1, a + 1});
        }
    return m;
}

TEST(Geodesic, IsEuclideanOnAFlatSheet)
{
    const mesh::Mesh m = sheet(20);
    GeodesicSolver solver(m);
    std::vector<double> d;
    const std::uint32_t corner = 0;
    solver.run({&corner, 1}, d);
    for (std::size_t v = 0; v < m.vertices.size(); ++v) EXPECT_NEAR(d[v], norm(m.vertices[v]), 1e-9) << v;
}

TEST(Geodesic, IsTheGreatCircleOnASphere)
{
    const double radius = 3;
    const mesh::Mesh m = mesh::sphere(radius, 4);
    GeodesicSolver solver(m);
    std::vector<double> d;
    const std::uint32_t pole = 0;
    solver.run({&pole, 1}, d);
    for (std::size_t v = 1; v < m.vertices.size(); ++v) {
        const double exact = radius * std::acos(std::clamp(dot(m.vertices[0], m.vertices[v]) / (radius * radius), -1.0, 1.0));
        EXPECT_NEAR(d[v], exact, 0.015 * exact) << v;
    }
}

TEST(Geodesic, StopsAtTheLimitAndOutsideTheMask)
{
    const mesh::Mesh m = sheet(10);
    GeodesicSolver solver(m);
    std::vector<double> d;
    const std::uint32_t corner = 0;
    solver.run({&corner, 1}, d, 3.5);
    for (std::size_t v = 0; v < m.vertices.size(); ++v) EXPECT_EQ(d[v] < k_unreached, norm(m.vertices[v]) <= 3.5 + 1e-12) << v;

    // A wall with a gap at the far end: the way around is longer than the straight line.
    std::vector<std::uint32_t> open(m.triangles.size(), 1);
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t)
        if (const Vec3d c = mesh::triangle_centroid(m, t); c.x > 4 && c.x < 5 && c.y < 9) open[t] = 0;
    solver.run({&corner, 1}, d, k_unreached, {open, 1});
    const double around = std::hypot(4, 9) + 1 + std::hypot(5, 9);
    EXPECT_NEAR(d[10 * 11], around, 0.03 * around);  // fast marching bends around corners a little late
}

TEST(Geodesic, FromATriangleStartsAtItsCentroid)
{
    const mesh::Mesh m = sheet(10);
    GeodesicSolver solver(m);
    std::vector<double> d;
    solver.run_from_triangle(77, d);
    const Vec3d c = mesh::triangle_centroid(m, 77);
    for (const auto v : m.triangles[77]) EXPECT_NEAR(d[v], norm(m.vertices[v] - c), 1e-12);
}

}  // namespace
}  // namespace sqmap::decompose
