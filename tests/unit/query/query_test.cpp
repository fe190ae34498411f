#include "sqmap/query/point.h"

#include "sqmap/mesh/solid.h"
#include "support/bodies.h"
#include "support/paper_model.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::query {
namespace {

/// Pseudo-random points and the awkward ones: vertices, edge midpoints, face centres, a hair beside them, centres, axes.
std::vector<Vec3d> points_about(const test::Parsed& b, std::uint64_t seed)
{
    test::Random random(seed);
    std::vector<Vec3d> points;
    const auto view = b.view();
    const double r = view.header.sphere[3];
    for (int i = 0; i < 1500; ++i) points.push_back(r * random.in_box({-1, -1, -1}, {1, 1, 1}));
    for (int i = 0; i < 1500; ++i) {
        const mesh::Triangle& t = b.mesh().triangles[random.below(b.mesh().triangles.size())];
        const Vec3d a = b.mesh().vertices[t[0]], c = b.mesh().vertices[t[1]], d = b.mesh().vertices[t[2]];
        const Vec3d base = i % 4 == 0 ? a : i % 4 == 1 ? 0.5 * (a + c) : (a + c + d) / 3.0;
        const double step = i % 3 == 0 ? 0.0 : i % 3 == 1 ? 1e-4 * r : 0.03 * r;
        points.push_back(base + step * random.direction());
    }
    for (const model::Part& part : view.parts) {
        const Vec3f c = model::vec3(part.chart_centre);
        points.push_back(cast<double>(c));
        for (int k = 0; k < 3; ++k)
            for (int i = -10; i <= 10; ++i)
                points.push_back(
                    cast<double>(c + (0.1f * static_cast<float>(i) * part.a[k]) * model::vec3(part.rotation + 3 * k)));
    }
    // As a query rounds them.
    for (Vec3d& p : points) p = cast<double>(cast<float>(p));
    return points;
}

TEST(Query, PolytopesOnlyFreePointsOfLayerOneThatTheSolidDoesNotHold)
{
    for (const test::Shape& shape : test::small_shapes()) {
        const test::Parsed b(shape.mesh);
        const model::ModelView view = b.in_model_space();
        const mesh::Solid& solid = b.solid();
        model::ModelView bare = view;
        bare.polytope_ends = {};
        bare.polytope_sides = {};
        int contacts = 0, freed = 0;
        for (const Vec3d& p : points_about(b, 5)) {
            const PointResult both = query_point(view, p, {.layer = Layer::One}),
                              one = query_point(bare, p, {.layer = Layer::One});
            ASSERT_LE(both.contact, one.contact) << shape.name;
            contacts += one.contact ? 1 : 0;
            freed += one.contact && !both.contact ? 1 : 0;
            if (one.contact && !both.contact) {
                EXPECT_TRUE(both.certain);
                EXPECT_FALSE(solid.inside(p)) << shape.name;
            }
            if (both.contact && both.part == one.part) {
                EXPECT_EQ(both.depth, one.depth) << shape.name;
                EXPECT_EQ(both.witness, one.witness) << shape.name;
            }
            // The rule, in plain words: a part holds a point if its superquadric and every side do.
            bool is_held = false;
            for (std::size_t i = 0; i < view.parts.size(); ++i) {
                model::ModelView part = bare;
                part.parts = view.parts.subspan(i, 1);
                is_held = is_held || (holds(model::polytope_of(view, i), cast<float>(p)) &&
                                      query_point(part, p, {.layer = Layer::One}).contact);
            }
            ASSERT_EQ(both.contact, is_held) << shape.name;
            for (const Layer layer : {Layer::Two, Layer::Three, Layer::Exact}) {
                const PointResult with = query_point(view, p, {.layer = layer}), without = query_point(bare, p, {.layer = layer});
                ASSERT_EQ(with.contact, without.contact);
                ASSERT_EQ(with.depth, without.depth);
                ASSERT_EQ(with.normal, without.normal);
            }
        }
        EXPECT_GT(contacts, 500) << shape.name;
        EXPECT_GT(freed, 0) << shape.name;
    }
}

TEST(Query, LayersKeepTheirPromisesOnEveryShape)
{
    for (const test::Shape& shape : test::small_shapes()) {
        const test::Parsed b(shape.mesh);
        const model::ModelView view = b.in_model_space();
        const mesh::Solid& solid = b.solid();
        const double r_max = view.header.r_max, rounding = 1e-5 * r_max;
        std::vector<double> depth_error;
        int certain_by_map = 0, total = 0;
        for (const Vec3d& p : points_about(b, 3)) {
            const double distance = solid.closest_boundary(p).distance;
            if (distance < rounding) continue;  // no verdict is promised on the surface
            ++total;
            const bool inside = solid.inside(p);
            const auto by = [&](Layer layer) { return query_point(view, p, {.layer = layer}); };
            const PointResult one = by(Layer::One), two = by(Layer::Two), three = by(Layer::Three), exact = by(Layer::Exact);
            const auto where = [&] {
                return testing::Message() << shape.name << " at " << p.x << ' ' << p.y << ' ' << p.z << ", " << distance / r_max
                                          << " of R_max off";
            };
            ASSERT_EQ(exact.contact, inside) << where();
            EXPECT_TRUE(exact.certain) << where();
            EXPECT_TRUE(one.contact || !inside) << where();
            for (const PointResult& c : {one, two, three})
                if (c.certain) {
                    ++certain_by_map;
                    ASSERT_EQ(c.contact, inside) << where();
                }
            EXPECT_EQ(two.certain, three.certain) << where();
            for (const PointResult& c : {one, two, three, exact}) {
                EXPECT_EQ(c.status, k_ok);
                if (!c.contact) {
                    EXPECT_EQ(c.part, -1);
                    EXPECT_EQ(c.depth, 0);
                    EXPECT_EQ(c.normal, Vec3d{});
                    continue;
                }
                ASSERT_GE(c.part, 0);
                ASSERT_LT(static_cast<std::size_t>(c.part), view.parts.size());
                EXPECT_NEAR(norm(c.normal), 1, 1e-4) << where();
                EXPECT_NEAR(norm(c.witness - p), c.depth, 1e-5 * r_max) << where();
            }
            if (inside) {
                depth_error.push_back(std::abs(exact.depth - distance) / r_max);
                EXPECT_LT(solid.bvh().closest_point(exact.witness).distance, 1e-5 * r_max) << where();
                if (distance > 1e-3 * r_max) {
                    EXPECT_GT(dot(exact.normal, normalized(exact.witness - p)), 0.99) << where();
                }
            }
        }
        ASSERT_GT(depth_error.size(), 200u) << shape.name;
        std::sort(depth_error.begin(), depth_error.end());
        EXPECT_LE(depth_error[depth_error.size() / 2], 1e-5) << shape.name;
        EXPECT_LE(depth_error[depth_error.size() * 95 / 100], 5e-4) << shape.name;
        EXPECT_GT(certain_by_map, total) << shape.name << ": the bounds should decide most points";
    }
}

TEST(Query, PointsThatAreNotFiniteOrFarAreFree)
{
    const test::Parsed b(test::small_torus());
    const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
    for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact, Layer::Auto, Layer::Gate}) {
        for (const Vec3d p : {Vec3d{nan, 0, 0}, Vec3d{0, inf, 0}, Vec3d{0, 0, -inf}, Vec3d{nan, nan, nan}}) {
            const PointResult c = query_point(b.view(), p, {.layer = layer});
            EXPECT_FALSE(c.contact);
            EXPECT_EQ(c.status, k_not_finite);
            EXPECT_FALSE(c.certain);
        }
        for (const Vec3d p : {Vec3d{1e30, 0, 0}, Vec3d{3e38, 3e38, -3e38}, Vec3d{5, 5, 5}, Vec3d{0, -1e10, 0}}) {
            const PointResult c = query_point(b.view(), p, {.layer = layer});
            EXPECT_FALSE(c.contact);
            EXPECT_TRUE(c.certain);
            EXPECT_EQ(c.witness, p);
        }
    }
}

TEST(Query, LayerOneKnowsTheDepthOfACentre)
{
    // A sphere's superquadric is about the sphere: its centre is one radius deep, whatever rounding makes of it.
    const test::Parsed b(mesh::sphere(1, 3));
    const model::Part& part = b.view().parts[0];
    for (const float step : {0.f, 1e-9f, 1e-7f, 1e-5f}) {
        const Vec3f centre = model::vec3(part.translation);
        const PointResult c = query_point(b.in_model_space(), cast<double>(centre + Vec3f{step, 0, 0}), {.layer = Layer::One});
        ASSERT_TRUE(c.contact);
        EXPECT_NEAR(c.depth, part.a[0], 0.1 * static_cast<double>(part.a[0])) << step;
    }
}

TEST(Query, ABatchAnswersAsItsPointsDo)
{
    const test::Parsed b(test::small_hand());
    const std::vector<Vec3d> points = points_about(b, 5);
    std::vector<PointResult> contacts(points.size());
    const model::ModelView view = b.view();
    for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact, Layer::Auto, Layer::Gate}) {
        const Body touched{.model = &view, .pose = test::shifted({1, -2, 3})};
        const std::size_t count = query_points(touched, points, {.layer = layer}, contacts);
        std::size_t expected = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const PointResult c = query_point(touched, points[i], {.layer = layer});
            ASSERT_EQ(c.contact, contacts[i].contact);
            ASSERT_EQ(c.depth, contacts[i].depth);
            ASSERT_EQ(c.witness, contacts[i].witness);
            ASSERT_EQ(c.certain, contacts[i].certain);
            expected += c.contact ? 1u : 0u;
        }
        EXPECT_EQ(count, expected);
    }
    EXPECT_EQ(query_points({.model = &view}, std::span(points).first(3), {}, std::span<PointResult>{}), 0u);
}

/// How many points layers 2 and 3 answer differently; the gate is the one or the other.
int check_gate(const model::ModelView& view)
{
    test::Random random(17);
    int differ = 0;
    for (int i = 0; i < 4000; ++i) {
        const double r = view.header.sphere[3];
        const Vec3d p = cast<double>(model::vec3(view.header.sphere)) + random.in_box({-r, -r, -r}, {r, r, r});
        const PointResult two = query_point(view, p, {.layer = Layer::Two}),
                          three = query_point(view, p, {.layer = Layer::Three});
        const PointResult never = query_point(view, p, {.layer = Layer::Gate, .gate = 0});
        const PointResult always = query_point(view, p, {.layer = Layer::Gate, .gate = 1000000});
        EXPECT_EQ(never.contact, two.contact);
        EXPECT_EQ(always.contact, three.contact);
        EXPECT_EQ(always.depth, three.depth);
        differ += two.contact != three.contact || two.depth != three.depth ? 1 : 0;
    }
    return differ;
}

TEST(Query, TheGateChoosesBetweenLayersTwoAndThree)
{
    const test::Parsed central(test::small_hand());
    model::ModelView bare = central.in_model_space();
    bare.locator = {};
    bare.bricks = {};
    (void)check_gate(central.in_model_space());  // its planes answer nearly everywhere, on both layers
    EXPECT_GT(check_gate(bare), 0);
    EXPECT_GT(check_gate(test::PaperModel(test::small_hand()).in_model_space()), 0);
}

TEST(Query, AutoIsTheCheapestLayerWithinTheTolerance)
{
    test::Baked b = test::baked(test::small_torus());
    model::Measured& m = b.result.model.measured;
    m.layer1_depth_p99 = 5;
    m.layer2_depth_p99 = 0.5;
    m.depth_p99 = 0.2;
    const model::ModelView view = b.in_model_space();
    const double percent = 0.01 * static_cast<double>(view.header.r_max) * view.header.unit;
    const auto layer_within = [&](double tolerance) {
        return chosen_layer(view, {.layer = Layer::Auto, .tolerance = tolerance * percent});
    };
    EXPECT_EQ(layer_within(6), Layer::One);
    EXPECT_EQ(layer_within(0.6), Layer::Two);
    EXPECT_EQ(layer_within(0.3), Layer::Three);
    EXPECT_EQ(layer_within(0.1), Layer::Exact);
    EXPECT_EQ(layer_within(0), Layer::Exact);
    // One wrong verdict, and no tolerance makes up for it.
    m.missed = 1;
    const model::ModelView doubtful = b.in_model_space();
    EXPECT_EQ(chosen_layer(doubtful, {.layer = Layer::Auto, .tolerance = 6 * percent}), Layer::Exact);
    EXPECT_EQ(chosen_layer(doubtful, {}), Layer::Three) << "named, it answers";
    // Without the exact layer Three answers, and says so where it is not within the tolerance.
    const test::Baked lean = test::baked(test::small_torus(), {.exact = false});
    const QueryOptions strict{.layer = Layer::Auto};
    EXPECT_EQ(chosen_layer(lean.view(), strict), Layer::Three);
    EXPECT_EQ(query_point(lean.view(), {9, 9, 9}, strict).status, k_no_exact);
    EXPECT_EQ(query_point(lean.view(), {9, 9, 9}, {.layer = Layer::Auto, .tolerance = 1e9}).status, k_ok);
}

TEST(Query, SmoothingChangesDepthAndNormalButNoVerdict)
{
    const test::Parsed central(test::small_hand());
    const test::PaperModel paper(test::small_hand());
    for (const model::ModelView& view : {central.in_model_space(), paper.in_model_space()}) {
        test::Random random(23);
        int contacts = 0, changed = 0;
        double moved = 0;
        for (int i = 0; i < 12000; ++i) {
            const double r = view.header.sphere[3];
            const Vec3d p = cast<double>(model::vec3(view.header.sphere)) + random.in_box({-r, -r, -r}, {r, r, r});
            const PointResult plain = query_point(view, p), smooth = query_point(view, p, {.smoothed_map = true});
            ASSERT_EQ(smooth.contact, plain.contact);
            EXPECT_FALSE(smooth.certain);
            if (!plain.contact || (plain.status & k_no_surface) != 0) continue;
            ++contacts;
            EXPECT_GE(smooth.depth, 0);
            EXPECT_NEAR(norm(smooth.normal), 1, 1e-4);
            changed += smooth.depth != plain.depth ? 1 : 0;
            moved += std::abs(smooth.depth - plain.depth);
        }
        ASSERT_GT(contacts, 100);
        EXPECT_GT(changed, contacts / 4);
        EXPECT_LT(moved / contacts, 0.01 * view.header.r_max);
    }
}

TEST(Query, UnitsAndPlaceOfTheMeshDoNotMatter)
{
    const mesh::Mesh shape = mesh::ellipsoid({1.6, 1.0, 0.5}, 3);
    struct Position {
        double scale;
        Vec3d shift;
    };
    test::Random random(6);
    for (const Position& position : {Position{1e6, {1e8, -1e8, 1e8}}, Position{1e-9, {}}, Position{1, {0, 0, 1000}}}) {
        const mesh::Mesh moved = test::mapped(shape, position.scale, position.shift);
        const test::Parsed b(mesh::canonicalized(moved));
        const model::ModelView view = b.view();
        const mesh::Solid solid(moved);  // in the mesh's own units
        const double r_max = view.header.r_max * view.header.unit;
        for (int i = 0; i < 1500; ++i) {
            const Vec3d p = position.shift + position.scale * random.in_box({-1.7, -1.1, -0.6}, {1.7, 1.1, 0.6});
            const mesh::ClosestPoint nearest = solid.closest_boundary(p);
            if (nearest.distance < 1e-5 * r_max) continue;
            const PointResult c = query_point(view, p, {.layer = Layer::Exact});
            ASSERT_EQ(c.contact, solid.inside(p)) << position.scale;
            if (c.contact) {
                EXPECT_NEAR(c.depth, nearest.distance, 2e-5 * r_max) << position.scale;
                EXPECT_NEAR(norm(c.witness - p), c.depth, 1e-5 * r_max) << position.scale;
            }
        }
    }
}

TEST(Query, ExactDepthsAreThoseOfTheVisibleSurfaceWhereTrianglesCutEachOther)
{
    const mesh::Mesh bars = test::crossing_bars();
    const test::Parsed m(bars);
    test::Random random(6);
    int contacts = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d p = random.in_box({-2, -2, -0.5}, {2, 2, 0.5});
        const PointResult c = query_point(m.view(), p, {.layer = Layer::Exact});
        if (!c.contact) continue;
        ++contacts;
        ASSERT_NEAR(c.depth, test::depth_in_crossing_bars(p), 2e-5) << p.x << ' ' << p.y << ' ' << p.z;
    }
    EXPECT_GT(contacts, 700);
}

TEST(Query, TheNearestSurfaceFromOutsideIsFoundFromAPlaceNearIt)
{
    const test::Parsed m(mesh::ellipsoid({1.6, 1.0, 0.5}, 3));
    const mesh::Mesh& mesh = m.mesh();
    test::Random random(8);
    double worst = 0;
    int outside = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d vertex = mesh.vertices[random.below(mesh.vertices.size())];
        const Vec3d p = vertex + 0.1 * m.r_max() * random.between(0, 1) * random.direction();
        const mesh::ClosestPoint nearest = m.solid().closest_boundary(p);
        if (m.solid().inside(p)) continue;
        ++outside;
        // From a position beside it, a twentieth of the object's size away.
        const mesh::ClosestPoint from = m.solid().closest_boundary(nearest.point + 0.05 * m.r_max() * random.direction());
        const mesh::Triangle& t = mesh.triangles[from.triangle];
        const Vec3d a = mesh.vertices[t[0]], across = cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
        const SurfacePoint start{from.point, normalized(across), 0, -1};
        const auto found = nearest_surface({.model = &m.in_model_space()}, p, start);
        ASSERT_TRUE(found);
        worst = std::max(worst, std::abs(found->distance - nearest.distance));
    }
    EXPECT_GT(outside, 500);
    EXPECT_LT(worst, 1e-6 * m.r_max());
    EXPECT_FALSE(nearest_surface({.model = &m.view()}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}, {}));
}

TEST(Query, ExactVerdictsHoldAtTheCreasesOfShellsThatCross)
{
    // Copies a little apart, so that shells cross all over and at small angles, and creases cut slivers from triangles.
    const mesh::Mesh ball = mesh::ellipsoid({1, 0.7, 0.6}, 3);
    const mesh::Mesh shells = test::together(test::mapped(ball, 1, {0.031, 0.017, -0.023}),
                                             test::together(ball, test::mapped(ball, 1.02, {0.4, 0, 0.1})));
    const test::Parsed m(shells);
    const double r_max = m.view().header.r_max;
    test::Random random(7);
    int inside = 0, at_creases = 0, wrong = 0;
    for (int i = 0; i < 60000; ++i) {
        const mesh::Triangle& t = m.mesh().triangles[random.below(m.mesh().triangles.size())];
        const Vec3d near = m.mesh().vertices[t[0]] + 0.03 * r_max * random.between(0, 1) * random.direction();
        const Vec3d q = cast<double>(cast<float>(near));
        const mesh::ClosestPoint closest = m.solid().closest_boundary(q);
        if (closest.distance <= 1e-5 * r_max) continue;
        const bool truth = m.solid().bvh().winding_number(q) > 0;
        wrong += query_point(m.in_model_space(), q, {.layer = Layer::Exact}).contact != truth ? 1 : 0;
        inside += truth ? 1 : 0;
        at_creases += truth && m.solid().boundary()[closest.triangle] == mesh::Boundary::Partly ? 1 : 0;
    }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(inside, 10000);
    EXPECT_GT(at_creases, 1000);
}

TEST(Query, AShellWithinTheSolidIsNoSurface)
{
    const test::Parsed m(test::nested_balls());
    for (const Layer layer : {Layer::Three, Layer::Exact})
        for (const Vec3d p : {Vec3d{0.6, 0.01, 0.02}, Vec3d{0.3, 0.2, 0.1}, Vec3d{-0.45, 0.2, -0.1}}) {
            const PointResult c = query_point(m.view(), p, {.layer = layer});
            ASSERT_TRUE(c.contact);
            EXPECT_NEAR(c.depth, 1 - norm(p), 0.015) << p.x;  // as a ball of flat faces
            EXPECT_GT(dot(c.normal, normalized(p)), 0.9) << p.x;
        }
}

}  // namespace
}  // namespace sqmap::query
