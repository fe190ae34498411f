#include "sqmap/paper/projection.h"

#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/bake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace sqmap::paper {
namespace {

using shape::Superquadricd;
using std::numbers::pi;
using DoubleAngles = shape::SurfaceAngles<double>;

paper::Map coarse_map(const Superquadricd& sq)
{
    // The foot search does not depend on what is mapped: a small sphere at the centre.
    const mesh::Mesh ball = mesh::sphere(0.01, 1);
    const paper::MapRays rays(ball);
    return paper::bake_map(rays, {}, sq, {.min_level = 6, .max_level = 6, .corrections = false});
}

Superquadricd widened(const shape::Superquadricf& f)
{
    Superquadricd sq;
    sq.a = cast<double>(f.a);
    sq.eps1 = static_cast<double>(f.eps1);
    sq.eps2 = static_cast<double>(f.eps2);
    sq.taper_x = static_cast<double>(f.taper_x);
    sq.taper_y = static_cast<double>(f.taper_y);
    sq.bend = static_cast<double>(f.bend);
    sq.bend_angle = static_cast<double>(f.bend_angle);
    return sq;
}

// Every sample of a fine grid: the distance to the nearest is an upper bound of the distance to the surface.
struct BruteForce {
    std::vector<Vec3d> points;
    explicit BruteForce(const Superquadricd& sq)
    {
        for (int i = 0; i <= 96; ++i)
            for (int j = 0; j < 192; ++j)
                points.push_back(shape::surface_point(sq, DoubleAngles{pi * (i / 96.0 - 0.5), 2 * pi * j / 192.0 - pi}).point);
    }
    double distance(Vec3d p) const
    {
        double best = 1e9;
        for (const Vec3d& q : points) best = std::min(best, norm_sq(q - p));
        return std::sqrt(best);
    }
};

template <class Body>
void for_shapes(Body&& body)
{
    int which = 0;
    for (double eps : {0.1, 0.5, 1.0, 1.5, 2.0})
        for (const Vec3d a : {Vec3d{1, 1, 1}, Vec3d{0.5, 0.7, 1}, Vec3d{0.25, 0.35, 1}}) {
            Superquadricd sq;
            sq.a = a;
            sq.eps1 = eps;
            sq.eps2 = 0.1 + 0.9 * eps;
            if (which % 3 == 1) sq.taper_x = 0.4;
            if (which % 3 == 2) {
                sq.bend = 0.5;
                sq.bend_angle = 0.7;
            }
            ++which;
            body(sq);
        }
}

Vec3d point_at_depth(const Superquadricd& sq, std::mt19937& g, double depth)
{
    std::uniform_real_distribution<double> u(-1, 1);
    const double eta = std::asin(u(g)), omega = pi * u(g);
    const Vec3d q = shape::undeform(sq, shape::surface_point(sq, DoubleAngles{eta, omega}).point);
    return shape::deform(sq, (1 - depth) * q);
}

TEST(Projection, NewtonsFootEndsBelowItsToleranceHoweverShallowThePoint)
{
    // Near the surface rounding of positions is a large share of the distance, by which a step is judged.
    Superquadricd sq;
    sq.a = {0.52, 0.42, 0.7};
    sq.eps1 = 0.79;
    sq.eps2 = 0.6;
    const paper::Map map = coarse_map(sq);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> eta(-1.4, 1.4), omega(-pi, pi), depth(0.005, 0.1);
    for (int i = 0; i < 20000; ++i) {
        const auto s = shape::surface_point(sq, DoubleAngles{eta(random), omega(random)});
        const Vec3f p = cast<float>(s.point - depth(random) * s.normal);
        const shape::Foot<float> foot = find_foot(map.view(), p, Projector::Newton);
        const Vec3d across = cross(cast<double>(foot.normal), cast<double>(p - foot.point));
        EXPECT_LT(norm(across), (1e-5 + 2e-6) * 0.7) << i;
    }
}

TEST(NormalProjection, NewtonFootOfShallowPointsIsTheNearestSurfacePoint)
{
    std::mt19937 g(1);
    for_shapes([&](const Superquadricd& shape) {
        const paper::Map map = coarse_map(shape);
        const Superquadricd sq = widened(map.superquadric);
        const BruteForce brute(sq);
        for (int n = 0; n < 40; ++n) {
            const Vec3d p = point_at_depth(sq, g, 0.03);
            std::uint8_t flags = 0;
            const shape::Foot<float> foot = find_foot(map.view(), cast<float>(p), Projector::Newton, &flags);
            EXPECT_EQ(flags & k_projection_unproven, 0);
            EXPECT_LE(norm(cast<double>(foot.point) - p), 1.01 * brute.distance(p) + 1e-5) << sq.eps1 << ' ' << sq.a.x;
            EXPECT_LT(static_cast<double>(foot.miss), 5e-4);
        }
    });
}

// Deep points have several feet; each is the map's own line. The nearest is found nearly always, a near one otherwise.
TEST(NormalProjection, NewtonFootOfDeepPointsIsAFootAndNearlyTheNearest)
{
    std::mt19937 g(2);
    int other = 0, count = 0;
    for_shapes([&](const Superquadricd& shape) {
        const paper::Map map = coarse_map(shape);
        const Superquadricd sq = widened(map.superquadric);
        const BruteForce brute(sq);
        for (const double depth : {0.3, 0.6})
            for (int n = 0; n < 20; ++n) {
                const Vec3d p = point_at_depth(sq, g, depth);
                std::uint8_t flags = 0;
                const shape::Foot<float> foot = find_foot(map.view(), cast<float>(p), Projector::Newton, &flags);
                const double found = norm(cast<double>(foot.point) - p), nearest = brute.distance(p);
                if ((flags & k_projection_unproven) == 0) {
                    EXPECT_LT(static_cast<double>(foot.miss), 1.1e-3);
                }
                EXPECT_LT(found, 1.6 * nearest + 1e-4);
                ++count;
                other += found > 1.01 * nearest + 1e-4;
            }
    });
    EXPECT_LT(other, count / 12);
}

TEST(NormalProjection, PyramidFindsTheNearestSampleOfTheBaseGridWhenShallow)
{
    std::mt19937 g(3);
    int other = 0, count = 0;
    for_shapes([&](const Superquadricd& shape) {
        const paper::Map map = coarse_map(shape);
        const MapView view = map.view();
        const Superquadricd sq = widened(map.superquadric);
        const std::size_t stride = std::size_t{1} << map.subdivisions;
        for (int n = 0; n < 40; ++n) {
            const Vec3d p = point_at_depth(sq, g, 0.03);
            const auto distance = [&](std::size_t row, std::size_t column) {
                const double i = static_cast<double>(row) / (map.eta_count - 1),
                             j = static_cast<double>(column) / map.omega_count;
                return norm(shape::surface_point(sq, DoubleAngles{pi * (i - 0.5), 2 * pi * j - pi}).point - p);
            };
            double best = 1e9;
            for (std::size_t i = 0; i < map.eta_count; i += stride)
                for (std::size_t j = 0; j < map.omega_count; j += stride) best = std::min(best, distance(i, j));
            const GridFoot foot = pyramid_search(view, cast<float>(p));
            ++count;
            other += distance(foot.row * stride, foot.column * stride) > 1.001 * best + 1e-6;
        }
    });
    EXPECT_LT(other, count / 50);
}

// A sphere inside an ellipsoid: the distance along a normal has a closed form.
TEST(NormalProjection, VerdictsOnASphereInAnEllipsoidAreExactFarFromItsFacets)
{
    const mesh::Mesh ball = mesh::sphere(0.6, 5);
    std::vector<std::uint32_t> all(ball.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    Superquadricd sq;
    sq.a = {0.8, 0.9, 1.1};
    const paper::MapRays rays(ball);
    const paper::Map map = paper::bake_map(rays, all, sq);
    std::mt19937 g(4);
    std::uniform_real_distribution<double> u(-1, 1);
    int contacts = 0, frees = 0;
    for (int n = 0; n < 4000; ++n) {
        const double x = u(g), y = u(g), z = u(g);
        const Vec3d p{0.9 * x, 0.9 * y, 1.1 * z};
        const double r = norm(p);
        for (const Projector projector : {Projector::Newton, Projector::Pyramid}) {
            const PartAnswer a = project(map.view(), cast<float>(p), {.projector = projector});
            if (a.verdict == Verdict::Outside) {
                EXPECT_GT(shape::implicit(widened(map.superquadric), p), 0.9999);
                continue;
            }
            if (std::abs(r - 0.6) < (projector == Projector::Newton ? 0.004 : 0.03)) continue;
            EXPECT_EQ(a.verdict == Verdict::Contact, r < 0.6) << r;
            if (projector == Projector::Pyramid || r > 0.6) continue;
            // Deeper than this the nearest point of the sphere is not the one along the ellipsoid's normal.
            EXPECT_NEAR(norm(cast<double>(a.surface)), 0.6, 0.005);
            EXPECT_GT(dot(cast<double>(a.normal), cast<double>(a.surface)) / 0.6, std::cos(0.06));
        }
        (r < 0.6 ? contacts : frees) += 1;
    }
    EXPECT_GT(contacts, 300);
    EXPECT_GT(frees, 300);
}

TEST(NormalProjection, LayerOneClaimsEverythingInside)
{
    const paper::Map map = coarse_map(Superquadricd{});
    EXPECT_EQ(project(map.view(), {0.5f, 0.2f, 0.1f}, {.layer = query::Layer::One}).verdict, Verdict::Contact);
    EXPECT_EQ(project(map.view(), {1.5f, 0.2f, 0.1f}, {.layer = query::Layer::One}).verdict, Verdict::Outside);
}

TEST(NormalProjection, PointsThatAreNotNumbersAreOutside)
{
    const paper::Map map = coarse_map(Superquadricd{});
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    EXPECT_EQ(project(map.view(), {nan, 0, 0}).verdict, Verdict::Outside);
    EXPECT_EQ(project(map.view(), {0, inf, 0}).verdict, Verdict::Outside);
    const PartAnswer centre = project(map.view(), {0, 0, 0});
    EXPECT_TRUE(std::isfinite(centre.foot_distance));
}

TEST(NormalProjection, OpeningsBehindTheFirstSurfaceAreFreeAndTheNextSurfaceIsContact)
{
    // A thick plate above a thin one, in a flat superquadric whose normals cross both.
    mesh::Mesh plates = mesh::rounded_box({0.9, 0.9, 0.05}, 0.02, 6);
    const mesh::Mesh other = plates;
    const auto first = static_cast<std::uint32_t>(plates.vertices.size());
    for (Vec3d& v : plates.vertices) v.z += 0.4;
    for (const Vec3d& v : other.vertices) plates.vertices.push_back(v + Vec3d{0, 0, 0.1});
    for (const mesh::Triangle& t : other.triangles) plates.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    std::vector<std::uint32_t> all(plates.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    Superquadricd sq;
    sq.a = {1, 1, 0.5};
    sq.eps1 = sq.eps2 = 0.2;
    const paper::MapRays rays(plates);
    const paper::Map map = paper::bake_map(rays, all, sq);
    EXPECT_GT(map.report.gaps, 0u);
    for (float x : {-0.4f, 0.0f, 0.3f})
        for (float y : {-0.3f, 0.1f, 0.4f}) {
            const auto at = [&](float z, bool gaps) { return project(map.view(), {x, y, z}, {.gaps = gaps}); };
            EXPECT_EQ(at(0.47f, true).verdict, Verdict::Free);
            EXPECT_EQ(at(0.40f, true).verdict, Verdict::Contact);
            EXPECT_EQ(at(0.25f, true).verdict, Verdict::Free);
            EXPECT_EQ(at(0.25f, false).verdict, Verdict::Contact);  // the paper's map
            EXPECT_EQ(at(0.10f, true).verdict, Verdict::Contact);
            EXPECT_NEAR(at(0.12f, true).depth_along, 0.03f, 0.003f);
        }
}

TEST(NormalProjection, StepsTowardsTheNearestSurfaceMakeDepthTrue)
{
    // A ball in a much longer ellipsoid: the line to the foot is far from radial.
    const mesh::Mesh ball = mesh::sphere(0.6, 5);
    Superquadricd sq;
    sq.a = {0.65, 0.7, 1.6};
    const paper::MapRays rays(ball);
    const paper::Map map = paper::bake_map(rays, {}, sq);
    std::mt19937 g(6);
    std::uniform_real_distribution<double> u(-0.6, 0.6);
    double along = 0, nearest = 0;
    int count = 0;
    while (count < 500) {
        const double x = u(g), y = u(g), z = u(g);
        const double r = norm(Vec3d{x, y, z});
        if (r > 0.58 || r < 0.35) continue;
        ++count;
        const Vec3f p = cast<float>(Vec3d{x, y, z});
        const PartAnswer plain = project(map.view(), p, {.nearest_steps = 0}), steps = project(map.view(), p);
        EXPECT_EQ(plain.verdict, Verdict::Contact);
        along += std::abs(static_cast<double>(plain.depth) - (0.6 - r));
        nearest += std::abs(static_cast<double>(steps.depth) - (0.6 - r));
    }
    EXPECT_LT(nearest, 0.4 * along);
    EXPECT_LT(nearest / count, 2e-3);
}

TEST(NormalProjection, GateReadsTheBaseGridWhereItIsDenseForItsVertices)
{
    const mesh::Mesh ball = mesh::sphere(0.6, 4);
    Superquadricd sq;
    sq.a = {0.8, 0.9, 1.1};
    const paper::MapRays rays(ball);
    const paper::Map map = paper::bake_map(rays, {}, sq);
    MapView view = map.view();
    const auto distance = [&](query::Layer layer) { return project(view, {0.1f, 0.35f, 0.6f}, {.layer = layer}).map_distance; };
    ASSERT_NE(distance(query::Layer::Two), distance(query::Layer::Three));
    view.vertex_count = 1;
    EXPECT_EQ(distance(query::Layer::Gate), distance(query::Layer::Two));
    view.vertex_count = 1u << 20;
    EXPECT_EQ(distance(query::Layer::Gate), distance(query::Layer::Three));
    const auto gated = [&](std::uint32_t gate) {
        return project(view, {0.1f, 0.35f, 0.6f}, {.layer = query::Layer::Gate, .gate = gate}).map_distance;
    };
    EXPECT_EQ(gated(0), distance(query::Layer::Two));
    view.vertex_count = 1;
    EXPECT_EQ(gated(1u << 20), distance(query::Layer::Three));
}

PartAnswer answer(Verdict verdict, float depth, std::uint8_t flags = 0)
{
    PartAnswer a;
    a.verdict = verdict;
    a.depth = depth;
    a.flags = flags;
    return a;
}

TEST(NormalProjection, OneWitnessFreesAPoint)
{
    const PartAnswer answers[] = {answer(Verdict::Contact, 0.1f), answer(Verdict::Free, -0.1f), answer(Verdict::Outside, 0)};
    EXPECT_FALSE(combine(answers).contact);
}

TEST(NormalProjection, AnUnprovenWitnessDoesNot)
{
    const PartAnswer answers[] = {answer(Verdict::Contact, 0.1f), answer(Verdict::Free, -0.1f, k_projection_unproven)};
    EXPECT_TRUE(combine(answers).contact);
}

TEST(NormalProjection, AFreeAnswerBesideACapIsNoWitness)
{
    const PartAnswer claimed[] = {answer(Verdict::Contact, 0.1f), answer(Verdict::Free, -0.1f, k_projection_by_cap)};
    EXPECT_TRUE(combine(claimed).contact);
    const PartAnswer alone[] = {answer(Verdict::Free, -0.1f, k_projection_by_cap)};
    EXPECT_FALSE(combine(alone).contact);
}

TEST(NormalProjection, DepthComesFromTheNearestTrueSurface)
{
    const PartAnswer answers[] = {answer(Verdict::Contact, 0.01f, k_projection_cap), answer(Verdict::Contact, 0.3f),
                                  answer(Verdict::Contact, 0.2f), answer(Verdict::Outside, 0)};
    const CombinedAnswer c = combine(answers);
    EXPECT_TRUE(c.contact);
    EXPECT_TRUE(c.has_surface);
    EXPECT_EQ(c.part, 2);
}

TEST(NormalProjection, ASurfaceJustAboveThePointIsNearerThanOneFarBelow)
{
    // A contact's own tangent plane may be on the other side of the point: what counts is how far it is.
    const PartAnswer answers[] = {answer(Verdict::Contact, -0.3f), answer(Verdict::Contact, 0.1f)};
    EXPECT_EQ(combine(answers).part, 1);
    const PartAnswer turned[] = {answer(Verdict::Contact, 0.3f), answer(Verdict::Contact, -0.1f)};
    EXPECT_EQ(combine(turned).part, 1);
}

TEST(NormalProjection, ThePartOfAPointIsThatOfTheFirstClaimUntilASurfaceIsFound)
{
    const PartAnswer caps[] = {answer(Verdict::Outside, 0), answer(Verdict::Contact, 0.3f, k_projection_cap),
                               answer(Verdict::Contact, 0.1f, k_projection_cap)};
    EXPECT_EQ(combine(caps).part, 1);
    const PartAnswer misses[] = {answer(Verdict::Contact, 0.01f, k_projection_miss), answer(Verdict::Contact, 0.3f)};
    EXPECT_EQ(combine(misses).part, 1);
}

TEST(NormalProjection, CapsAloneAreContactWithoutASurface)
{
    const PartAnswer answers[] = {answer(Verdict::Contact, 0.01f, k_projection_cap)};
    const CombinedAnswer c = combine(answers);
    EXPECT_TRUE(c.contact);
    EXPECT_FALSE(c.has_surface);
    EXPECT_FALSE(combine({}).contact);
}

TEST(FootSearch, ItsLastBestStepIsWhereTheMapIsAskedToTheBit)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<float> coordinate(-1, 1);
    for_shapes([&](const Superquadricd& sq) {
        const paper::Map map = coarse_map(sq);
        const MapView view = map.view();
        for (int i = 0; i < 20; ++i) {
            const Vec3f p = cast<float>(sq.a.x * Vec3d{coordinate(random), coordinate(random), coordinate(random)});
            for (const Projector projector : {Projector::Newton, Projector::Pyramid, Projector::Printed}) {
                const PartAnswer answer = project(view, p, {.projector = projector});
                std::vector<FootSearchStep> steps(4096);
                const std::size_t count = record_foot_search(view, p, projector, steps);
                ASSERT_LE(count, steps.size());
                if (answer.verdict == Verdict::Outside) {
                    EXPECT_EQ(count, 0u);
                    continue;
                }
                const auto last = std::find_if(steps.rend() - static_cast<std::ptrdiff_t>(count), steps.rend(),
                                               [](const FootSearchStep& step) { return step.better; });
                ASSERT_NE(last, steps.rend());
                EXPECT_EQ(last->angles.eta, answer.angles.eta);
                EXPECT_EQ(last->angles.omega, answer.angles.omega);
                EXPECT_EQ(last->distance, answer.foot_distance);
                // A short span takes the first ones.
                std::vector<FootSearchStep> first(3);
                EXPECT_EQ(record_foot_search(view, p, projector, first), count);
                for (std::size_t k = 0; k < std::min<std::size_t>(3, count); ++k) EXPECT_EQ(first[k].distance, steps[k].distance);
            }
        }
    });
}

TEST(FootSearch, LooksAtAsManySamplesAsTheSearchCounts)
{
    const paper::Map map = coarse_map({.a = {0.5, 0.7, 1}, .eps1 = 0.6, .eps2 = 1.4});
    const MapView view = map.view();
    const PyramidOptions printed{.both_directions = false, .compare_distance = false, .wide_fallback = false, .seeded = false};
    const Vec3f p{0.2f, 0.25f, 0.3f};
    std::vector<FootSearchStep> steps(4096);
    const std::size_t count = record_foot_search(view, p, Projector::Printed, steps);
    // On the base grid; what is finer is layer 3.
    const std::uint32_t base = 1u << view.subdivisions;
    const auto on_base = std::count_if(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(count),
                                       [&](const FootSearchStep& step) { return step.stride >= base; });
    EXPECT_EQ(on_base, pyramid_search(view, p, printed).evaluations + (view.subdivisions > 0 ? 0 : 1));
}

}  // namespace
}  // namespace sqmap::paper
