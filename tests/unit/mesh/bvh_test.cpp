// Rays against triangles: brute force, edges and corners, the ends of a ray.
#include "sqmap/mesh/bvh.h"

#include "sqmap/mesh/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

namespace sqmap::mesh {
namespace {

/// By Cramer's rule, triangle by triangle.
std::optional<double> first_by_force(const Mesh& mesh, const Bvh::Ray& ray)
{
    std::optional<double> first;
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a = mesh.vertices[t[0]], e = mesh.vertices[t[1]] - a, f = mesh.vertices[t[2]] - a, g = ray.origin - a;
        const double determinant = dot(e, cross(ray.direction, f));
        if (determinant == 0) continue;
        const double u = dot(g, cross(ray.direction, f)) / determinant, v = dot(ray.direction, cross(g, e)) / determinant,
                     s = dot(f, cross(g, e)) / determinant;
        if (u >= 0 && v >= 0 && u + v <= 1 && s > ray.from && s < ray.to && (!first || s < *first)) first = s;
    }
    return first;
}

TEST(Bvh, FirstHitIsThatOfBruteForce)
{
    const Mesh torus = mesh::torus();
    const Bvh bvh(torus);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform(-2, 2);
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const Bvh::Ray ray{{uniform(random), uniform(random), uniform(random)},
                           {uniform(random), uniform(random), uniform(random)}};
        const std::optional<double> expected = first_by_force(torus, ray);
        const std::optional<Bvh::Hit> hit = bvh.first_hit(ray);
        ASSERT_EQ(hit.has_value(), expected.has_value());
        ASSERT_EQ(bvh.meets_any(ray), expected.has_value());
        if (!hit) continue;
        ++hits;
        EXPECT_NEAR(hit->t, *expected, 1e-12);
        const Triangle& t = torus.triangles[hit->triangle];
        const Vec3d by_corners =
            (1 - hit->u - hit->v) * torus.vertices[t[0]] + hit->u * torus.vertices[t[1]] + hit->v * torus.vertices[t[2]];
        EXPECT_LT(norm(by_corners - (ray.origin + hit->t * ray.direction)), 1e-12);
    }
    EXPECT_GT(hits, 100);
}

TEST(Bvh, NoRayPassesBetweenTriangles)
{
    // From the centre through every corner, every middle of an edge, and points on edges that doubles do not hold.
    const Mesh ball = mesh::sphere(1, 3);
    const Bvh bvh(ball);
    for (const Triangle& t : ball.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            for (const double share : {0.0, 0.5, 1.0 / 3, 0.123456789}) {
                const Vec3d on_edge = (1 - share) * ball.vertices[t[k]] + share * ball.vertices[t[(k + 1) % 3]];
                for (const double scale : {1.0, 0.7, 1e-3}) {
                    const std::optional<Bvh::Hit> hit = bvh.first_hit({{}, scale * on_edge});
                    ASSERT_TRUE(hit);
                    EXPECT_FALSE(hit->entering);
                    EXPECT_NEAR(hit->t * scale, 1, 1e-9);
                }
            }
}

TEST(Bvh, HitsLieWithinTheRayAndInOrder)
{
    const Mesh torus = mesh::torus();
    const Bvh bvh(torus);
    const Bvh::Ray ray{{-3, 0.01, 0.02}, {1, 0, 0}};
    std::vector<Bvh::Hit> hits;
    bvh.all_hits(ray, hits);
    ASSERT_EQ(hits.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(hits[i].entering, i % 2 == 0);
        EXPECT_GT(hits[i].t, i > 0 ? hits[i - 1].t : 0);
    }
    bvh.all_hits({ray.origin, ray.direction, hits[0].t, hits[3].t}, hits);  // both ends are left out
    EXPECT_EQ(hits.size(), 2u);
    EXPECT_EQ(bvh.first_hit({ray.origin, ray.direction, hits[0].t})->t, hits[1].t);
    EXPECT_FALSE(bvh.meets_any({ray.origin, ray.direction, 0, 1}));
    EXPECT_FALSE(bvh.first_hit({ray.origin, {-1, 0, 0}}));
}

TEST(Bvh, WindingChangesByTheCrossingsBetween)
{
    // Two tori through each other, whose winding numbers are 0, 1 and 2.
    Mesh tori = mesh::torus();
    const auto count = static_cast<std::uint32_t>(tori.vertices.size());
    const std::size_t triangles = tori.triangles.size();
    for (std::uint32_t i = 0; i < count; ++i) tori.vertices.push_back(tori.vertices[i] + Vec3d{0.31, 0.17, 0.11});
    for (std::size_t i = 0; i < triangles; ++i) {
        const Triangle t = tori.triangles[i];
        tori.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
    }
    const Bvh bvh(tori);
    std::mt19937 generator(5);
    std::uniform_real_distribution<double> box(-1.5, 1.5);
    int twice = 0, changed = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d from{box(generator), box(generator), 0.3 * box(generator)};
        const Vec3d to{box(generator), box(generator), 0.3 * box(generator)};
        const std::optional<int> change = bvh.winding_change(from, to);
        ASSERT_TRUE(change);
        EXPECT_EQ(bvh.winding_number(from) + *change, bvh.winding_number(to));
        changed += *change != 0 ? 1 : 0;
        twice += bvh.winding_number(to) == 2 ? 1 : 0;
    }
    EXPECT_GT(changed, 100);
    EXPECT_GT(twice, 10);
    // A point of the surface has no winding number, and edges decide nothing.
    const Mesh ball = mesh::sphere(1, 3);
    EXPECT_FALSE(Bvh(ball).winding_change({}, 2.0 * ball.vertices[0]));
    EXPECT_FALSE(Bvh(ball).winding_change({}, triangle_centroid(ball, 0)));
    EXPECT_EQ(Bvh(ball).winding_change({0.1, 0, 0}, {0.1, 0, 0}), 0);
}

}  // namespace
}  // namespace sqmap::mesh
