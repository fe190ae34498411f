// Equations 11, 12 and 17 to 22, the lemma of section 5 and its corollaries, on the baked paper map.
#include "paper/bake/regions.h"
#include "paper/model/codes.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/bake.h"
#include "sqmap/paper/projection.h"
#include "support/decoded.h"
#include "unit/fit/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sqmap {
namespace {

using fit::test::all_triangles;
using paper::Map;
using paper::MapRays;
using shape::Superquadricd;
using std::numbers::pi;

Map at_level(const mesh::Mesh& m, const Superquadricd& sq, int level, bool corrections = false)
{
    const MapRays rays(m);
    return paper::bake_map(rays, all_triangles(m), sq, {.min_level = level, .max_level = level, .corrections = corrections});
}

double q2_share(const mesh::Mesh& m, const Superquadricd& sq)
{
    const mesh::Bvh bvh(m);
    const std::vector<std::uint32_t> all = all_triangles(m);
    return paper::hidden_from_feet({bvh, m, all}, paper::ExactFeet(sq));
}

// Fig. 4: two balls in one superquadric.
mesh::Mesh two_spheres()
{
    mesh::Mesh m = mesh::sphere(0.5, 4);
    const auto first = static_cast<std::uint32_t>(m.vertices.size());
    const mesh::Mesh other = m;
    for (const Vec3d& v : other.vertices) m.vertices.push_back(v + Vec3d{0, 0, 0.8});
    for (const mesh::Triangle& t : other.triangles) m.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    return m;
}

Superquadricd around_two_spheres()
{
    Superquadricd sq;
    sq.a = {0.62, 0.62, 0.95};
    sq.eps1 = 0.6;
    sq.translation = {0, 0, 0.4};
    return sq;
}

TEST(Paper, Fig4MapOfTwoSpheresMatchesTheClosedForm)
{
    const Superquadricd sq = around_two_spheres();
    const Map map = at_level(two_spheres(), sq, 6);
    double mean = 0, largest = 0, waist = 0;
    int count = 0;
    for (std::uint32_t i = 1; i + 1 < map.eta_count; ++i)
        for (std::uint32_t j = 0; j < map.omega_count; j += 3) {
            const shape::SurfaceAngles<double> at{pi * (double(i) / (map.eta_count - 1) - 0.5),
                                                  2 * pi * j / map.omega_count - pi};
            const auto s = shape::surface_point(sq, at);
            double expected = 1e9;
            for (const double z : {0.0, 0.8}) {
                const Vec3d p = s.point - Vec3d{0, 0, z};
                const double b = -dot(p, s.normal), q = b * b - (dot(p, p) - 0.25);
                if (q >= 0) expected = std::min(expected, -b - std::sqrt(q));
            }
            const std::uint16_t code = map.distance[std::size_t{i} * map.omega_count + j];
            ASSERT_EQ(paper::ray_of(code), paper::MapRay::Surface);
            const double stored = double(map.distance_scale) * code;
            mean += std::abs(stored - expected);
            largest = std::max(largest, stored);
            if (i == map.eta_count / 2) waist = std::max(waist, stored);
            ++count;
        }
    EXPECT_LT(mean / count, 1.5e-3);   // facets of the mesh
    EXPECT_GT(waist, 0.75 * largest);  // white in Fig. 4c: the gap between the balls
}

TEST(Paper, Eq11MeasuresAlongTheNormalNotToTheNearestPoint)
{
    const Superquadricd sq = around_two_spheres();
    const mesh::Mesh m = two_spheres();
    const Map map = at_level(m, sq, 5);
    const mesh::Bvh bvh(m);
    double difference = 0;
    for (std::uint32_t i = 1; i + 1 < map.eta_count; ++i) {
        const shape::SurfaceAngles<double> at{pi * (double(i) / (map.eta_count - 1) - 0.5), -pi};
        const double stored = double(map.distance_scale) * map.distance[std::size_t{i} * map.omega_count];
        const double nearest = bvh.closest_point(shape::surface_point(sq, at).point).distance;
        EXPECT_GE(stored, nearest - 1e-4);
        difference = std::max(difference, stored - nearest);
    }
    EXPECT_GT(difference, 0.05);
}

TEST(Paper, Eq12OffsetIsZeroOnASphereInASphereAndPositiveOnBumps)
{
    const Map smooth = at_level(mesh::sphere(0.5, 6), Superquadricd{}, 4);
    double largest = 0;
    for (std::size_t i = 0; i < 32 * smooth.hits.size(); ++i)
        largest = std::max(largest, double(smooth.offset_scale) * paper::offset_steps(smooth.view(), i));
    EXPECT_LT(largest, 0.02);  // facets only
    // A box corner close to the superquadric is a local minimum of the map, where grad D = 0 but delta is wanted.
    Superquadricd sq;
    sq.a = {1.1, 1.1, 1.1};
    const Map box = at_level(mesh::rounded_box({0.6, 0.6, 0.6}, 0.05, 6), sq, 5);
    largest = 0;
    int minima = 0;
    for (std::size_t i = 0; i < 32 * box.hits.size(); ++i) {
        const std::uint32_t steps = paper::offset_steps(box.view(), i);
        largest = std::max(largest, double(box.offset_scale) * steps);
        minima += steps > 0;
    }
    EXPECT_GT(largest, 0.02);
    EXPECT_LT(minima, static_cast<int>(box.normal.size() / 8));
}

TEST(Paper, Eq12OffsetIsOffUnlessAskedForAndOnlyBringsContactEarlier)
{
    Superquadricd sq;
    sq.a = {1.1, 1.1, 1.1};
    const Map map = at_level(mesh::rounded_box({0.6, 0.6, 0.6}, 0.05, 6), sq, 5);
    int nearer = 0;
    for (int n = 0; n < 3000; ++n) {
        const shape::SurfaceAnglesf at{static_cast<float>(1.5 * std::sin(0.37 * n)),
                                       static_cast<float>(3.1 * std::sin(0.11 * n))};
        const float plain = paper::sample_map(map.view(), at, {}).distance;
        const float offset = paper::sample_map(map.view(), at, {.offset = true}).distance;
        EXPECT_LE(offset, plain);
        nearer += offset < plain;
    }
    EXPECT_GT(nearer, 0);
}

TEST(Paper, Eq17To19PyramidCosts8EvaluationsALevelAndOneMore)
{
    const Map map = at_level(mesh::sphere(0.5, 3), Superquadricd{}, 8);
    // Base grid 129 by 256: N_L = int(max(log2(129/16), log2(256/32))) = 3.
    const paper::GridFoot printed =
        paper::pyramid_search(map.view(), {0.3f, 0.5f, 0.4f},
                              {.both_directions = false, .compare_distance = false, .wide_fallback = false, .seeded = false});
    EXPECT_EQ(printed.evaluations, 8 * 3 + 1);
    EXPECT_GT(printed.collinearity, 0.99f);
}

// Lemma and corollary 1, forward: on an injective projection the error goes to zero with the sampling density.
double map_error(const Map& map, const mesh::Mesh& m)
{
    const MapRays rays(m);
    Superquadricd sq;
    sq.a = cast<double>(map.superquadric.a);
    sq.translation = cast<double>(map.superquadric.translation);
    sq.eps1 = double(map.superquadric.eps1);
    sq.eps2 = double(map.superquadric.eps2);
    double sum = 0;
    int count = 0;
    for (int n = 0; n < 4000; ++n) {
        const shape::SurfaceAngles<double> at{std::asin(0.98 * std::sin(0.37 * n)), 3.1 * std::sin(0.11 * n)};
        const auto s = shape::surface_point(sq, at);
        const MapRays::Surface exact = rays.surface_along(s.point, -s.normal, {10, 1e-6});
        const paper::MapSample stored =
            paper::sample_map(map.view(), {static_cast<float>(at.eta), static_cast<float>(at.omega)}, {});
        if (exact.kind != MapRays::Kind::Hit || !std::isfinite(stored.distance)) continue;
        sum += std::abs(exact.distance - double(stored.distance));
        ++count;
    }
    return sum / count;
}

// Corollary 1 and 2 on the whole surface: how far mesh points are from the surface the map represents (eq. 20).
double representation_error(const Map& map, const mesh::Mesh& m)
{
    double sum = 0, area = 0;
    for (std::uint32_t t = 0; t < m.triangles.size(); ++t) {
        const double w = mesh::triangle_area(m, t);
        const auto a = paper::project(map.view(), cast<float>(mesh::triangle_centroid(m, t)), {.corrections = false});
        if (a.verdict == paper::Verdict::Outside) continue;
        sum += w * std::min(std::abs(static_cast<double>(a.depth_along)), 1.0);
        area += w;
    }
    return sum / area;
}

TEST(Paper, LemmaInjectiveProjectionRepresentsEverySurfacePoint)
{
    // Convex: y(x) - D(y) n(y) = x for every mesh point, as closely as the sampling allows.
    const mesh::Mesh m = mesh::sphere(0.6, 5);
    Superquadricd sq;
    sq.a = {0.7, 0.8, 1.0};
    const Map map = at_level(m, sq, 7);
    EXPECT_EQ(q2_share(m, sq), 0.0);
    EXPECT_LT(representation_error(map, m), 2e-4);
}

TEST(Paper, Corollary1ErrorVanishesWithDensity)
{
    const mesh::Mesh m = mesh::sphere(0.6, 5);
    Superquadricd sq;
    sq.a = {0.7, 0.8, 1.0};
    const double coarse = map_error(at_level(m, sq, 4), m), middle = map_error(at_level(m, sq, 5), m),
                 fine = map_error(at_level(m, sq, 6), m);
    EXPECT_LT(middle, 0.5 * coarse);
    EXPECT_LT(fine, 0.5 * middle);
}

TEST(Paper, Corollary2RegionsOfTypeQ2LeaveAFloor)
{
    // A ring in a tall cylinder: the inner side's feet lie outwards, behind the ring. (In a flat one they lie above and
    // below: the same mesh is of type Q1 there.)
    const mesh::Mesh m = mesh::torus({.major_radius = 1, .minor_radius = 0.35});
    Superquadricd sq;
    sq.a = {1.4, 1.4, 1.8};
    sq.eps1 = 0.3;
    const Map coarse = at_level(m, sq, 5), fine = at_level(m, sq, 7);
    EXPECT_GT(q2_share(m, sq), 0.2);
    EXPECT_GT(representation_error(fine, m), 0.5 * representation_error(coarse, m));
    EXPECT_GT(representation_error(fine, m), 1e-2);
    sq.a = {1.4, 1.4, 0.5};
    EXPECT_EQ(q2_share(m, sq), 0.0);
}

TEST(Paper, Corollary2ConcaveRegionsOfTypeQ1DoNot)
{
    // The two balls' waist is concave but every point of it sees its foot.
    const mesh::Mesh m = two_spheres();
    const Superquadricd sq = around_two_spheres();
    const Map coarse = at_level(m, sq, 4), fine = at_level(m, sq, 7);
    // Buried caps of the two balls are no surface: measured on the map, not on them.
    EXPECT_LT(map_error(fine, m), 0.25 * map_error(coarse, m));
}

}  // namespace
}  // namespace sqmap
