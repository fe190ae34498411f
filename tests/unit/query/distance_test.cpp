// Signed distances against the exact oracle in double.
#include "sqmap/query/distance.h"

#include "bake/bake.h"
#include "math/random.h"
#include "math/triangle.h"
#include "sqmap/haptic/step.h"
#include "sqmap/io/model_file.h"
#include "sqmap/math/rotation.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/mesh/solid.h"

#include "support/parsed.h"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

namespace sqmap::query {
namespace {

/// A shape far from the origin in units of its own, its model and the oracle.
struct Baked {
    mesh::Mesh mesh;
    double r_max, band;
    std::vector<std::uint64_t> words;
    model::ModelView view;
    std::unique_ptr<mesh::Solid> solid;

    explicit Baked(mesh::Mesh shape, bake::BakeOptions options = {}) : mesh(std::move(shape))
    {
        for (Vec3d& v : mesh.vertices) v = 3.0 * v + Vec3d{10, -20, 5};
        r_max = mesh::largest_vertex_distance(mesh);
        band = 0.01 * options.band * r_max;
        const std::vector<std::byte> bytes = io::serialize(bake::bake(mesh, true, options).model);
        words.resize((bytes.size() + 7) / 8);
        std::memcpy(words.data(), bytes.data(), bytes.size());
        const std::span<const std::byte> all(reinterpret_cast<const std::byte*>(words.data()), bytes.size());
        EXPECT_EQ(model::parse(all, view), model::ParseStatus::Ok);
        solid = std::make_unique<mesh::Solid>(mesh, mesh::find_self_intersections(mesh).crossed);
    }
    double truth(Vec3d p) const { return (solid->inside(p) ? -1 : 1) * solid->closest_boundary(p).distance; }
    /// About the surface by up to so much of R_max, on both sides.
    std::vector<Vec3d> points_about(double share, std::size_t count, std::uint64_t seed = 1) const
    {
        SplitMix64 random(seed);
        std::vector<Vec3d> points;
        for (std::size_t i = 0; i < count; ++i) {
            const mesh::Triangle& t = mesh.triangles[random.bits() % mesh.triangles.size()];
            const auto& v = mesh.vertices;
            const double a = random.uniform(), b = (1 - a) * random.uniform();
            const Vec3d n = normalized(cross(v[t[1]] - v[t[0]], v[t[2]] - v[t[0]]));
            points.push_back(v[t[0]] + a * (v[t[1]] - v[t[0]]) + b * (v[t[2]] - v[t[0]]) +
                             random.between(-share, share) * r_max * n);
        }
        return points;
    }
    std::vector<Vec3d> points_around(double extent, std::size_t count) const
    {
        SplitMix64 random(5);
        std::vector<Vec3d> points;
        const Vec3d middle = mesh.vertices.front();
        for (std::size_t i = 0; i < count; ++i)
            points.push_back(middle +
                             extent * r_max * Vec3d{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)});
        return points;
    }
};

mesh::Mesh crossing_boxes()
{
    mesh::Mesh mesh = mesh::rounded_box({0.5, 0.3, 0.25}, 0.05, 3);
    const mesh::Mesh other = mesh::rounded_box({0.2, 0.65, 0.15}, 0.04, 3);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const Mat3d turned = rotation_by(Vec3d{0.1, 0.2, 0.3});
    for (const Vec3d& v : other.vertices) mesh.vertices.push_back(turned * v);
    for (const mesh::Triangle& t : other.triangles) mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    return mesh;
}

const Baked& hand()
{
    static const Baked baked(mesh::polygonized(mesh::hand_capsules(), 0.05));
    return baked;
}
const Baked& boxes()
{
    static const Baked baked(crossing_boxes());
    return baked;
}

class DistanceOf : public testing::TestWithParam<const Baked& (*)()> {};

TEST_P(DistanceOf, IsExactWithinTheBandOnBothSides)
{
    const Baked& b = GetParam()();
    const std::vector<Vec3d> points = b.points_about(0.049, 20000);
    std::vector<SignedDistance> answers(points.size());
    distances(b.view, points, answers, k_baked_band);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const SignedDistance& a = answers[i];
        const double truth = b.truth(points[i]);
        if (std::abs(truth) > b.band) continue;  // about a buried triangle
        ASSERT_EQ(a.known, DistanceKind::Exact);
        ASSERT_LE(std::abs(std::abs(a.distance) - std::abs(truth)), 1e-5 * b.r_max);
        if (std::abs(truth) < 1e-5 * b.r_max) continue;
        ASSERT_EQ(a.distance < 0, truth < 0) << truth;
        EXPECT_NEAR(norm(a.gradient), 1, 1e-6);
        EXPECT_NEAR(norm(points[i] - a.witness), std::abs(truth), 2e-5 * b.r_max);
        if (std::abs(truth) > 1e-3 * b.r_max) {
            EXPECT_GT(dot(a.gradient, points[i] - a.witness) * (truth < 0 ? -1 : 1), 0.999 * std::abs(truth));
        }
        ASSERT_GE(a.part, 0);
        ASSERT_LT(static_cast<std::size_t>(a.part), b.view.parts.size());
    }
}

TEST_P(DistanceOf, IsBoundedBeyondTheBand)
{
    const Baked& b = GetParam()();
    std::size_t bounds = 0;
    for (const double extent : {0.7, 2.0, 20.0, 1e6})
        for (const Vec3d& p : b.points_around(extent, 3000)) {
            const SignedDistance a = distance(b.view, p, k_baked_band);
            const double truth = b.truth(p);
            if (std::abs(truth) > 1e-5 * b.r_max) {
                ASSERT_EQ(a.distance < 0, truth < 0);
            }
            if (a.known == DistanceKind::Exact) {
                ASSERT_NEAR(a.distance, truth, 1e-5 * b.r_max);
                continue;
            }
            ++bounds;
            ASSERT_EQ(a.known, DistanceKind::LowerBound);
            ASSERT_GT(std::abs(truth), b.band) << "within the band all is exact";
            ASSERT_LE(std::abs(a.distance), std::abs(truth));
            ASSERT_GE(std::abs(a.distance), 0.5 * std::abs(truth));
        }
    EXPECT_GT(bounds, 6000u);
}

TEST_P(DistanceOf, IsExactFartherOutWhereAsked)
{
    const Baked& b = GetParam()();
    for (const Vec3d& p : b.points_around(0.9, 500)) {
        const SignedDistance a = distance(b.view, p, b.r_max);
        if (std::abs(b.truth(p)) > b.r_max) continue;
        ASSERT_EQ(a.known, DistanceKind::Exact);
        ASSERT_NEAR(a.distance, b.truth(p), 1e-5 * b.r_max);
    }
}

void expect_same(const SignedDistance& a, const SignedDistance& b)
{
    ASSERT_EQ(a.known, b.known);
    ASSERT_EQ(a.status, b.status);
    ASSERT_EQ(a.distance, b.distance);
    ASSERT_EQ(a.part, b.part);
    ASSERT_EQ(norm(a.witness - b.witness), 0);
    ASSERT_EQ(norm(a.gradient - b.gradient), 0);
}

TEST_P(DistanceOf, OnePointIsAsABatchToTheBit)
{
    const Baked& b = GetParam()();
    std::vector<Vec3d> points = b.points_about(0.08, 9000);
    // Ties: on vertices, and on the middles of edges.
    for (std::size_t i = 0; i < 500; ++i) {
        const mesh::Triangle& t = b.mesh.triangles[7 * i % b.mesh.triangles.size()];
        points.push_back(b.mesh.vertices[t[0]]);
        points.push_back(0.5 * (b.mesh.vertices[t[0]] + b.mesh.vertices[t[1]]));
    }
    std::vector<SignedDistance> answers(points.size()), few(points.size());
    distances(b.view, points, answers, k_baked_band);
    for (std::size_t i = 0; i < points.size(); i += 100)
        distances(b.view, std::span(points).subspan(i, 100), std::span(few).subspan(i, 100), k_baked_band);
    for (std::size_t i = 0; i < points.size(); ++i) {
        expect_same(distance(b.view, points[i], k_baked_band), answers[i]);
        expect_same(few[i], answers[i]);
        if (HasFatalFailure()) return;
    }
}

TEST_P(DistanceOf, ManyPointsInOneCallAreAsOneByOneToTheBit)
{
    const Baked& b = GetParam()();
    SplitMix64 random(21);
    std::vector<Vec3d> points;
    for (int i = 0; i < 9000; ++i) {
        const double reach = i % 3 == 0 ? 20 * b.r_max : b.r_max;
        const auto next = [&] { return random.between(-reach, reach); };
        points.push_back(b.mesh.vertices[random.bits() % b.mesh.vertices.size()] + Vec3d{next(), next(), next()});
    }
    points[1] = {1e300, -1e300, 1e300};
    points[2] = b.mesh.vertices[0];
    points.back().x = std::numeric_limits<double>::quiet_NaN();
    std::vector<SignedDistance> in_float(points.size()), in_double(points.size());
    const Body body{&b.view, nullptr, {rotation_by(Vec3d{1, 2, 3}), {3, 4, 5}}};
    for (Vec3d& p : points) p = apply(body.pose, p);
    distances(body, points, in_float);
    exact_distances(body, points, in_double);
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        expect_same(distance(body, points[i]), in_float[i]);
        expect_same(exact_distance(body, points[i]), in_double[i]);
        if (HasFatalFailure()) return;
    }
    EXPECT_EQ(in_float.back().status, k_not_finite);
    EXPECT_EQ(in_double.back().status, k_not_finite);
    EXPECT_EQ(in_double.back().part, -1);
}

TEST_P(DistanceOf, AProbeIsAsItsPoints)
{
    const Baked& b = GetParam()();
    const std::vector<Vec3d> points = b.points_about(0.06, 2500);
    const Pose pose{rotation_by(Vec3d{0.4, 0.1, -0.3}), {1, 2, 3}};
    std::vector<Vec3d> local;
    for (const Vec3d& p : points) local.push_back(apply(inverse(pose), p));
    const Probe probe(local);
    std::vector<SignedDistance> answers(points.size());
    distances({&b.view}, {nullptr, &probe, pose}, answers);
    double nearest = INFINITY;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double truth = b.truth(points[i]);
        if (answers[i].known == DistanceKind::Exact) {
            ASSERT_NEAR(answers[i].distance, truth, 1e-5 * b.r_max);
        }
        nearest = std::min(nearest, truth);
    }
    EXPECT_LT(nearest, 0);
    EXPECT_TRUE(is_nearer({&b.view}, {nullptr, &probe, pose}, 1e-9));
}

TEST_P(DistanceOf, IsTheSameOnEveryInstructionSet)
{
    const Baked& b = GetParam()();
    const std::vector<Vec3d> points = b.points_about(0.07, 5000);
    std::vector<SignedDistance> first(points.size()), answers(points.size());
    distances(b.view, points, first, k_baked_band);
    for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1) {
        hwy::SetSupportedTargetsForTest(left & -left);
        distances(b.view, points, answers, k_baked_band);
        hwy::SetSupportedTargetsForTest(0);
        for (std::size_t i = 0; i < points.size(); ++i) expect_same(first[i], answers[i]);
    }
}

TEST_P(DistanceOf, AnswersInTheFrameOfThePoses)
{
    const Baked& b = GetParam()();
    const Pose pose{rotation_by(Vec3d{0.7, -0.4, 1.1}), {3, -40, 8}}, relative{rotation_by(Vec3d{-0.2, 0.5, 0.3}), {0.4, 1, -2}};
    const Body body{&b.view, nullptr, pose};
    const std::vector<Vec3d> points = b.points_about(0.3, 3000);
    const auto expect_posed = [&](const SignedDistance& own, const SignedDistance& posed) {
        // The position is rounded to float after the poses.
        ASSERT_NEAR(own.distance, posed.distance, own.known == DistanceKind::Exact ? 1e-6 * b.r_max : 0.01 * b.r_max);
    };
    std::vector<Vec3d> world;
    for (const Vec3d& p : points) world.push_back(apply(pose, p));
    std::vector<SignedDistance> own(points.size()), posed(points.size()), probed(points.size());
    distances(b.view, points, own, k_baked_band);
    distances(body, world, posed, k_baked_band);
    std::vector<Vec3d> local;
    for (const Vec3d& p : points) local.push_back(apply(inverse(relative), p));
    const Probe probe(local);
    distances(body, {nullptr, &probe, compose(pose, relative)}, probed);
    for (std::size_t i = 0; i < points.size(); ++i) {
        expect_posed(own[i], posed[i]);
        expect_posed(own[i], probed[i]);
        if (HasFatalFailure()) return;
        if (posed[i].known == DistanceKind::Exact && std::abs(posed[i].distance) > 1e-3 * b.r_max) {
            ASSERT_NEAR(norm(posed[i].witness + posed[i].distance * posed[i].gradient - world[i]), 0, 1e-5 * b.r_max);
        }
    }
    EXPECT_EQ(is_nearer(body, {nullptr, &probe, compose(pose, relative)}, 0.01 * b.r_max),
              is_nearer({&b.view}, {nullptr, &probe, relative}, 0.01 * b.r_max));
}

INSTANTIATE_TEST_SUITE_P(Shapes, DistanceOf, testing::Values(hand, boxes),
                         [](const auto& shape) { return shape.index == 0 ? "Hand" : "CrossingBoxes"; });

/// Posed where its nearest point is about a reach away, each side of it: as the distances of its points.
void expect_nearer_as_distances(const model::ModelView& model, const mesh::Mesh& mesh, const Probe& probe, std::uint64_t seed)
{
    const double r_max = mesh::largest_vertex_distance(mesh);
    SplitMix64 random(seed);
    const auto any_direction = [&] { return Vec3d{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)}; };
    std::vector<SignedDistance> answers(probe.size());
    std::size_t near = 0, far = 0;
    for (int i = 0; i < 60; ++i) {
        const Vec3d on = mesh.vertices[random.bits() % mesh.vertices.size()];
        const Pose pose{rotation_by(2.0 * any_direction()), on + (i % 2 == 0 ? 0.4 : 1.5) * r_max * any_direction()};
        distances({&model}, {nullptr, &probe, pose}, answers);
        // Bounds are no farther than the truth: a reach below the least of them is met by none.
        double least = INFINITY, least_known = INFINITY;
        for (const SignedDistance& a : answers) {
            least = std::min(least, a.distance);
            if (a.known == DistanceKind::Exact) least_known = std::min(least_known, a.distance);
        }
        if (least > 1e-4 * r_max) {
            EXPECT_FALSE(is_nearer({&model}, {nullptr, &probe, pose}, least - 1e-5 * r_max)) << i;
            ++far;
        }
        const double reach = std::max(least_known, 0.0) + 1e-5 * r_max;
        if (std::isfinite(least_known)) {
            EXPECT_TRUE(is_nearer({&model}, {nullptr, &probe, pose}, reach)) << i;
            ++near;
        }
    }
    EXPECT_GT(near, 10u);
    EXPECT_GT(far, 5u);
}

TEST(Distance, IsNearerAgreesWithTheDistancesOnEveryShape)
{
    for (const test::Shape& shape : test::small_shapes()) {
        SCOPED_TRACE(shape.name);
        const test::Parsed parsed(shape.mesh);
        const double size = mesh::largest_vertex_distance(shape.mesh);
        expect_nearer_as_distances(parsed.view(), shape.mesh, Probe(mesh::sphere(0.3 * size, 3).vertices), 1);
        expect_nearer_as_distances(parsed.view(), shape.mesh, Probe(shape.mesh.vertices), 2);
    }
}

TEST(Distance, IsNearerAgreesWithTheDistancesOnRealMeshes)
{
    for (const char* name : {"horse_5946.obj", "fandisk_8000.obj"}) {
        const std::optional<mesh::Mesh> real = test::shared_mesh_too(name);
        if (!real) continue;
        SCOPED_TRACE(name);
        const test::Parsed parsed(*real);
        const double size = mesh::largest_vertex_distance(*real);
        expect_nearer_as_distances(parsed.view(), *real, Probe(mesh::sphere(0.2 * size, 3).vertices), 3);
    }
}

TEST(Distance, IsExactFarFromTheObjectWhereAsked)
{
    // On the axis of a ring the surface is farther than the bounding sphere says.
    const mesh::TorusOptions ring{.major_radius = 1, .minor_radius = 0.25};
    const test::Parsed parsed(mesh::torus(ring));
    const Probe point(std::vector<Vec3d>{{}});
    for (const double z : {0.0, 1.0, 4.0, 10.0, 300.0}) {
        const double truth = std::hypot(1, z) - 0.25, slack = 0.003 + 1e-6 * z;  // flat faces lie within the ring
        const SignedDistance far = distance(parsed.view(), {0, 0, z}, 1000);
        EXPECT_EQ(far.known, DistanceKind::Exact) << z;
        EXPECT_NEAR(far.distance, truth, slack) << z;
        EXPECT_NEAR(norm(far.witness - Vec3d{0, 0, z}), truth, slack) << z;
        const Body touched{.model = &parsed.view()}, collider{.probe = &point, .pose = {{}, {0, 0, z}}};
        EXPECT_FALSE(is_nearer(touched, collider, truth - slack)) << z;
        EXPECT_TRUE(is_nearer(touched, collider, truth + slack)) << z;
    }
}

TEST(Distance, ReportsHowNearAProbeIs)
{
    const Baked& b = hand();
    const std::vector<Vec3d> ball = mesh::sphere(0.05 * b.r_max, 2).vertices;
    const Probe probe(ball);
    for (const Vec3d& p : b.points_around(0.8, 60)) {
        double nearest = INFINITY;
        for (const Vec3d& v : ball) nearest = std::min(nearest, b.truth(p + v));
        for (const double reach : {0.01 * b.r_max, 0.1 * b.r_max, 0.5 * b.r_max})
            if (std::abs(nearest - reach) > 1e-4 * b.r_max) {
                EXPECT_EQ(is_nearer({&b.view}, {nullptr, &probe, {{}, p}}, reach), nearest < reach) << nearest << ' ' << reach;
            }
    }
    EXPECT_FALSE(is_nearer({&b.view}, {nullptr, &probe, {{}, {NAN, 0, 0}}}, 1));
    EXPECT_FALSE(is_nearer({&b.view}, {nullptr, &probe, {{}, b.mesh.vertices.front()}}, 0));
}

TEST(Distance, WithoutAModelOrAPoseIsNowhere)
{
    const Baked& b = hand();
    const SignedDistance nothing = distance(Body{}, {1, 2, 3});
    EXPECT_EQ(nothing.distance, std::numeric_limits<double>::max());
    EXPECT_EQ(nothing.known, DistanceKind::LowerBound);
    EXPECT_EQ(distance(Body{&b.view, nullptr, {{}, {NAN, 0, 0}}}, {1, 2, 3}).status, k_not_finite);
    const Probe probe(b.mesh.vertices);
    std::vector<SignedDistance> answers(probe.size());
    distances(Body{}, {nullptr, &probe}, answers);
    distances(Body{&b.view}, Body{}, answers);
    distances({&b.view}, {nullptr, &probe}, std::span(answers).first(1));
    EXPECT_EQ(answers[0].distance, 0);
    EXPECT_FALSE(is_nearer(Body{}, {nullptr, &probe}, 1));
    EXPECT_FALSE(is_nearer({&b.view}, Body{}, 1));
    distances({&b.view, nullptr, {{}, {0, INFINITY, 0}}}, {nullptr, &probe}, answers);
    for (const SignedDistance& a : answers) EXPECT_EQ(a.status, k_not_finite);
}

/// About the surface, and up to ten times the object's size away.
std::vector<Vec3d> points_near_and_far(const Baked& b)
{
    std::vector<Vec3d> points = b.points_about(0.3, 1500);
    for (const double extent : {1.0, 10.0}) {
        const std::vector<Vec3d> more = b.points_around(extent, 500);
        points.insert(points.end(), more.begin(), more.end());
    }
    return points;
}

TEST(ExactDistance, IsThatOfDoubleAtAnyDistance)
{
    const Baked& b = hand();
    const std::vector<Vec3d> points = points_near_and_far(b);
    std::vector<SignedDistance> answers(points.size());
    exact_distances(b.view, points, answers);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const SignedDistance& a = answers[i];
        ASSERT_EQ(a.known, DistanceKind::Exact);
        ASSERT_NEAR(a.distance, b.truth(points[i]), 1e-12 * b.r_max);
        ASSERT_NEAR(norm(a.witness - points[i]), std::abs(a.distance), 1e-12 * b.r_max);
        ASSERT_NEAR(norm(a.gradient), 1, 1e-9);
        // The witness point is on the triangle that is named.
        const mesh::Triangle& t = b.mesh.triangles[static_cast<std::size_t>(a.triangle)];
        const auto& v = b.mesh.vertices;
        const Vec3d q = closest_point_on_triangle(a.witness, v[t[0]], v[t[1]], v[t[2]]);
        ASSERT_NEAR(norm(q - a.witness), 0, 1e-12 * b.r_max);
    }
    for (std::size_t i = 0; i < points.size(); i += 17) expect_same(exact_distance(b.view, points[i]), answers[i]);
}

TEST(ExactDistance, IsTheSameOnEveryInstructionSet)
{
    for (const Baked* b : {&hand(), &boxes()}) {
        const std::vector<Vec3d> points = points_near_and_far(*b);
        std::vector<SignedDistance> first(points.size()), answers(points.size());
        exact_distances(b->view, points, first);
        for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS; left != 0; left &= left - 1) {
            hwy::SetSupportedTargetsForTest(left & -left);
            exact_distances(b->view, points, answers);
            hwy::SetSupportedTargetsForTest(0);
            for (std::size_t i = 0; i < points.size(); ++i) expect_same(first[i], answers[i]);
        }
    }
}

/// More triangles tie about such a corner than a query remembers.
TEST(ExactDistance, IsThatToACornerOfManyTriangles)
{
    for (const std::uint32_t sides : {24u, 700u}) {
        mesh::Mesh cone{{{0, 0, 1}, {0, 0, 0}}, {}};
        for (std::uint32_t i = 0; i < sides; ++i) {
            const double angle = 2 * std::numbers::pi * i / sides;
            cone.vertices.push_back({std::cos(angle), std::sin(angle), 0});
            const std::uint32_t here = 2 + i, next = 2 + (i + 1) % sides;
            cone.triangles.push_back({0, here, next});
            cone.triangles.push_back({1, next, here});
        }
        const Baked b(std::move(cone));
        const Vec3d apex = b.mesh.vertices[0];
        SplitMix64 random(3);
        for (int i = 0; i < 50; ++i) {
            const Vec3d p = apex + Vec3d{random.between(-0.1, 0.1), random.between(-0.1, 0.1), random.between(0.2, 2)};
            const SignedDistance a = exact_distance(b.view, p);
            ASSERT_EQ(a.known, DistanceKind::Exact);
            ASSERT_NEAR(a.distance, norm(p - apex), 1e-13 * norm(p));
            ASSERT_EQ(a.witness, apex);
            const mesh::Triangle& t = b.mesh.triangles[static_cast<std::size_t>(a.triangle)];
            ASSERT_EQ(t[0] * t[1] * t[2], 0u);
        }
    }
}

TEST(ExactDistance, IsOfTheUnionOfBodiesThatCross)
{
    const Baked& b = boxes();
    const std::vector<Vec3d> points = points_near_and_far(b);
    std::size_t precise = 0;
    for (const Vec3d& p : points) {
        const SignedDistance a = exact_distance(b.view, p);
        const double truth = b.truth(p);
        ASSERT_NEAR(a.distance, truth, 1e-6 * b.r_max);  // where the bodies cross the surface is stored in float
        precise += std::abs(a.distance - truth) < 1e-12 * b.r_max ? 1 : 0;
    }
    EXPECT_GT(static_cast<double>(precise), 0.9 * static_cast<double>(points.size()));
}

TEST(ExactDistance, HasFiniteDifferencesThatAreItsGradient)
{
    const Baked& b = hand();
    const double h = 1e-7 * b.r_max;
    std::size_t good = 0, count = 0;
    for (const Vec3d& p : b.points_about(0.2, 2000)) {
        const SignedDistance a = exact_distance(b.view, p);
        const double along =
            exact_distance(b.view, p + h * a.gradient).distance - exact_distance(b.view, p - h * a.gradient).distance;
        ++count;
        good += std::abs(along / (2 * h) - 1) < 1e-6 ? 1 : 0;
    }
    EXPECT_GT(static_cast<double>(good), 0.999 * static_cast<double>(count));  // but at the medial axis
}

TEST(ExactDistance, SaysWhereItIsInFloat)
{
    const Baked b(mesh::polygonized(mesh::hand_capsules(), 0.05), {.keep_input = false});
    for (const Vec3d& p : b.points_about(0.3, 500)) {
        const SignedDistance a = exact_distance(b.view, p);
        ASSERT_EQ(a.known, DistanceKind::ExactInFloat);
        ASSERT_NEAR(a.distance, b.truth(p), 2e-7 * b.r_max);
    }
}

TEST(ExactDistance, IsTheSameInEveryFrame)
{
    const Baked& b = hand();
    const Body body{&b.view, nullptr, {rotation_by(Vec3d{0.3, -0.5, 0.2}), {3, 4, -5}}};
    for (const Vec3d& p : b.points_about(0.2, 500)) {
        const SignedDistance own = exact_distance(b.view, p), posed = exact_distance(body, apply(body.pose, p));
        ASSERT_NEAR(own.distance, posed.distance, 1e-12 * b.r_max);
        ASSERT_NEAR(norm(apply(body.pose, own.witness) - posed.witness), 0, 1e-6 * b.r_max);
    }
}

TEST(ExactDistance, FollowsAViewInOtherUnits)
{
    const Baked& b = hand();
    const double metres = 0.01;
    const model::ModelView small = haptic::in_metres(b.view, metres), unit = model::normalized(b.view);
    for (const Vec3d& p : b.points_about(0.2, 500)) {
        const double truth = exact_distance(b.view, p).distance;
        const SignedDistance in_metres = exact_distance(small, metres * p);
        ASSERT_EQ(in_metres.known, DistanceKind::ExactInFloat);
        ASSERT_NEAR(in_metres.distance, metres * truth, 2e-7 * metres * b.r_max);
        const Vec3d there = cast<double>(model::to_model_space(b.view.header, p));
        ASSERT_NEAR(b.view.header.unit * exact_distance(unit, there).distance, truth, 1e-6 * b.r_max);
    }
}

TEST(Distance, AnswersAnyPoint)
{
    const Baked& b = hand();
    constexpr double k_max = std::numeric_limits<double>::max(), k_nan = std::numeric_limits<double>::quiet_NaN();
    for (const Vec3d& p : {Vec3d{k_nan, 0, 0}, Vec3d{0, INFINITY, 0}, Vec3d{0, 0, -INFINITY}}) {
        const SignedDistance a = distance(b.view, p);
        EXPECT_EQ(a.distance, 0);
        EXPECT_EQ(a.known, DistanceKind::LowerBound);
        EXPECT_EQ(a.status, k_not_finite);
    }
    for (const Vec3d& p : {Vec3d{k_max, k_max, k_max}, Vec3d{1e300, 0, 0}, Vec3d{0, 0, -1e40}}) {
        const SignedDistance a = distance(b.view, p);
        EXPECT_GT(a.distance, 1e39);
        EXPECT_TRUE(std::isfinite(a.distance));
        EXPECT_EQ(a.known, DistanceKind::LowerBound);
    }
    EXPECT_EQ(distance(b.view, b.mesh.vertices.front(), k_nan).known, DistanceKind::Exact);
}

TEST(Distance, TakesATenthMoreBytesAtMost)
{
    for (const Baked* b : {&hand()}) {
        const double bytes = static_cast<double>(model::bytes_of(b->view.distance));
        EXPECT_LT(bytes, 0.1 * (8.0 * static_cast<double>(b->words.size()) - bytes));
    }
}

TEST(Distance, IsApproximateWithoutTheExactLayer)
{
    const Baked b(mesh::polygonized(mesh::hand_capsules(), 0.05), {.exact = false});
    std::size_t good = 0, count = 0;
    for (const Vec3d& p : b.points_about(0.04, 2000)) {
        const SignedDistance a = distance(b.view, p, k_baked_band);
        EXPECT_EQ(a.known, DistanceKind::Approximate);
        EXPECT_EQ(a.status, k_no_exact);
        ++count;
        good += std::abs(a.distance - b.truth(p)) < 0.005 * b.r_max ? 1 : 0;
    }
    EXPECT_GT(static_cast<double>(good), 0.99 * static_cast<double>(count));
    for (const Vec3d& p : b.points_around(1.5, 2000)) {
        const SignedDistance a = distance(b.view, p, k_baked_band);
        if (a.known != DistanceKind::LowerBound) continue;
        EXPECT_LE(std::abs(a.distance), std::abs(b.truth(p)));
        EXPECT_GE(std::abs(a.distance), 0.5 * std::abs(b.truth(p)));
    }
}

}  // namespace
}  // namespace sqmap::query
