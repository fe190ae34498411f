#include "sqmap/query/query.h"

#include "sqmap/mesh/solid.h"
#include "support/baked_shapes.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace sqmap::query {
namespace {

/// Pseudo-random points and the awkward ones: vertices, edge midpoints, face centres, a hair beside them, centres, axes.
std::vector<Vec3f> points_about(const test::Baked& b, std::uint64_t seed)
{
    test::Random random(seed);
    std::vector<Vec3f> points;
    const auto view = b.view();
    const double r = view.header.sphere[3];
    for (int i = 0; i < 1500; ++i) points.push_back(cast<float>(r * random.in_box({-1, -1, -1}, {1, 1, 1})));
    for (int i = 0; i < 1500; ++i) {
        const mesh::Triangle& t = b.mesh.triangles[random.below(b.mesh.triangles.size())];
        const Vec3d a = b.mesh.vertices[t[0]], c = b.mesh.vertices[t[1]], d = b.mesh.vertices[t[2]];
        const Vec3d base = i % 4 == 0 ? a : i % 4 == 1 ? 0.5 * (a + c) : (a + c + d) / 3.0;
        const double step = i % 3 == 0 ? 0.0 : i % 3 == 1 ? 1e-4 * r : 0.03 * r;
        points.push_back(cast<float>(base + step * random.direction()));
    }
    for (const model::Part& part : view.parts) {
        const Vec3f c = model::vec3(part.chart_centre);
        points.push_back(c);
        for (int k = 0; k < 3; ++k)
            for (int i = -10; i <= 10; ++i)
                points.push_back(c + (0.1f * static_cast<float>(i) * part.a[k]) * model::vec3(part.rotation + 3 * k));
    }
    return points;
}

TEST(Query, LayersKeepTheirPromisesOnEveryShape)
{
    for (const test::Shape& shape : test::small_shapes()) {
        const test::Baked b = test::baked(shape.mesh);
        const model::ModelView view = b.view();
        const mesh::Solid solid(b.mesh);
        const double r_max = view.header.r_max, rounding = 1e-5 * r_max;
        std::vector<double> depth_error;
        int certain_by_map = 0, total = 0;
        for (const Vec3f& p : points_about(b, 3)) {
            const Vec3d q = cast<double>(p);
            const double distance = solid.closest_boundary(q).distance;
            if (distance < rounding) continue;  // no verdict is promised on the surface
            ++total;
            const bool inside = solid.inside(q);
            const Contact one = query_point(view, p, Layer::One), two = query_point(view, p, Layer::Two),
                          three = query_point(view, p, Layer::Three), exact = query_point(view, p, Layer::Exact);
            const auto where = [&] {
                return testing::Message() << shape.name << " at " << p.x << ' ' << p.y << ' ' << p.z << ", " << distance / r_max
                                          << " of R_max off";
            };
            ASSERT_EQ(exact.contact, inside) << where();
            EXPECT_TRUE(exact.certain) << where();
            EXPECT_TRUE(one.contact || !inside) << where();
            for (const Contact& c : {one, two, three})
                if (c.certain) {
                    ++certain_by_map;
                    ASSERT_EQ(c.contact, inside) << where();
                }
            EXPECT_EQ(two.certain, three.certain) << where();
            for (const Contact& c : {one, two, three, exact}) {
                EXPECT_EQ(c.status, k_ok);
                if (!c.contact) {
                    EXPECT_EQ(c.part, -1);
                    EXPECT_EQ(c.depth, 0.f);
                    EXPECT_EQ(c.normal, Vec3f{});
                    continue;
                }
                ASSERT_GE(c.part, 0);
                ASSERT_LT(static_cast<std::size_t>(c.part), view.parts.size());
                EXPECT_NEAR(norm(c.normal), 1.f, 1e-4f) << where();
                EXPECT_NEAR(norm(c.point - p), c.depth, 1e-5 * r_max) << where();
            }
            if (inside) {
                depth_error.push_back(std::abs(static_cast<double>(exact.depth) - distance) / r_max);
                EXPECT_LT(solid.bvh().closest_point(cast<double>(exact.point)).distance, 1e-5 * r_max) << where();
                if (distance > 1e-3 * r_max) {
                    EXPECT_GT(dot(exact.normal, normalized(exact.point - p)), 0.99f) << where();
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
    const test::Baked b = test::baked(test::small_torus());
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact, Layer::Auto, Layer::Gate}) {
        for (const Vec3f p : {Vec3f{nan, 0, 0}, Vec3f{0, inf, 0}, Vec3f{0, 0, -inf}, Vec3f{nan, nan, nan}}) {
            const Contact c = query_point(b.view(), p, layer);
            EXPECT_FALSE(c.contact);
            EXPECT_EQ(c.status, k_not_finite);
            EXPECT_FALSE(c.certain);
        }
        for (const Vec3f p : {Vec3f{1e30f, 0, 0}, Vec3f{3e38f, 3e38f, -3e38f}, Vec3f{5, 5, 5}, Vec3f{0, -1e10f, 0}}) {
            const Contact c = query_point(b.view(), p, layer);
            EXPECT_FALSE(c.contact);
            EXPECT_TRUE(c.certain);
            EXPECT_EQ(c.point, p);
        }
    }
}

TEST(Query, LayerOneKnowsTheDepthOfACentre)
{
    // A sphere's superquadric is about the sphere: its centre is one radius deep, whatever rounding makes of it.
    const test::Baked b = test::baked(mesh::sphere(1, 3));
    const model::Part& part = b.view().parts[0];
    for (const float step : {0.f, 1e-9f, 1e-7f, 1e-5f}) {
        const Contact c = query_point(b.view(), model::vec3(part.translation) + Vec3f{step, 0, 0}, Layer::One);
        ASSERT_TRUE(c.contact);
        EXPECT_NEAR(c.depth, part.a[0], 0.1f * part.a[0]) << step;
    }
}

TEST(Query, ABatchAnswersAsItsPointsDo)
{
    const test::Baked b = test::baked(test::small_hand());
    const std::vector<Vec3f> points = points_about(b, 5);
    std::vector<Contact> contacts(points.size());
    for (const Layer layer : {Layer::One, Layer::Two, Layer::Three, Layer::Exact, Layer::Auto, Layer::Gate}) {
        const std::size_t count = query_points(b.view(), points, layer, contacts);
        std::size_t expected = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const Contact c = query_point(b.view(), points[i], layer);
            ASSERT_EQ(c.contact, contacts[i].contact);
            ASSERT_EQ(c.depth, contacts[i].depth);
            ASSERT_EQ(c.point, contacts[i].point);
            ASSERT_EQ(c.certain, contacts[i].certain);
            expected += c.contact ? 1u : 0u;
        }
        EXPECT_EQ(count, expected);
    }
    EXPECT_EQ(query_points(b.view(), std::span(points).first(3), Layer::Exact, std::span<Contact>{}), 0u);
}

/// How many points layers 2 and 3 answer differently; the gate is the one or the other.
int check_gate(const model::ModelView& view)
{
    test::Random random(17);
    int differ = 0;
    for (int i = 0; i < 4000; ++i) {
        const float r = view.header.sphere[3];
        const Vec3f p = model::vec3(view.header.sphere) + cast<float>(random.in_box({-r, -r, -r}, {r, r, r}));
        const Contact two = query_point(view, p, Layer::Two), three = query_point(view, p, Layer::Three);
        const Contact never = query_point(view, p, {.layer = Layer::Gate, .layer3_gate = 0});
        const Contact always = query_point(view, p, {.layer = Layer::Gate, .layer3_gate = 1000000});
        EXPECT_EQ(never.contact, two.contact);
        EXPECT_EQ(always.contact, three.contact);
        EXPECT_EQ(always.depth, three.depth);
        differ += two.contact != three.contact || two.depth != three.depth ? 1 : 0;
    }
    return differ;
}

TEST(Query, TheGateChoosesBetweenLayersTwoAndThree)
{
    const test::Baked central = test::baked(test::small_hand());
    model::ModelView bare = central.view();
    bare.locator = {};
    bare.bricks = {};
    (void)check_gate(central.view());  // its planes answer nearly everywhere, on both layers
    EXPECT_GT(check_gate(bare), 0);
    EXPECT_GT(check_gate(test::baked(test::small_hand(), {.projection = model::Projection::Normal}).view()), 0);
}

TEST(Query, AutoIsTheCheapestLayerWithinTheTolerance)
{
    test::Baked b = test::baked(test::small_torus());
    model::Measured& m = b.result.model.measured;
    m.layer1_depth_p99 = 5;
    m.layer2_depth_p99 = 0.5;
    m.depth_p99 = 0.2;
    const model::ModelView view = b.view();
    const double percent = 0.01 * static_cast<double>(view.header.r_max) * view.header.unit;
    const auto layer_within = [&](double tolerance) {
        return chosen_layer(view, {.layer = Layer::Auto, .tolerance = tolerance * percent});
    };
    EXPECT_EQ(layer_within(6), Layer::One);
    EXPECT_EQ(layer_within(0.6), Layer::Two);
    EXPECT_EQ(layer_within(0.3), Layer::Three);
    EXPECT_EQ(layer_within(0.1), Layer::Exact);
    EXPECT_EQ(layer_within(0), Layer::Exact);
    // Without the exact layer Three answers, and says so where it is not within the tolerance.
    const test::Baked lean = test::baked(test::small_torus(), {.exact = false});
    const QueryOptions strict{.layer = Layer::Auto};
    EXPECT_EQ(chosen_layer(lean.view(), strict), Layer::Three);
    EXPECT_EQ(query_point(lean.view(), {9, 9, 9}, strict).status, k_no_exact);
    EXPECT_EQ(query_point(lean.view(), {9, 9, 9}, {.layer = Layer::Auto, .tolerance = 1e9}).status, k_ok);
}

TEST(Query, SmoothingChangesDepthAndNormalButNoVerdict)
{
    for (const model::Projection projection : {model::Projection::Central, model::Projection::Normal}) {
        const test::Baked b = test::baked(test::small_hand(), {.projection = projection});
        const model::ModelView view = b.view();
        test::Random random(23);
        int contacts = 0, changed = 0;
        double moved = 0;
        for (int i = 0; i < 12000; ++i) {
            const float r = view.header.sphere[3];
            const Vec3f p = model::vec3(view.header.sphere) + cast<float>(random.in_box({-r, -r, -r}, {r, r, r}));
            const Contact plain = query_point(view, p, Layer::Three);
            const Contact smooth = query_point(view, p, {.layer = Layer::Three, .smoothing = true});
            ASSERT_EQ(smooth.contact, plain.contact);
            EXPECT_FALSE(smooth.certain);
            if (!plain.contact || (plain.status & k_no_surface) != 0) continue;
            ++contacts;
            EXPECT_GE(smooth.depth, 0.f);
            EXPECT_NEAR(norm(smooth.normal), 1.f, 1e-4f);
            changed += smooth.depth != plain.depth ? 1 : 0;
            moved += std::abs(static_cast<double>(smooth.depth) - static_cast<double>(plain.depth));
        }
        ASSERT_GT(contacts, 100);
        EXPECT_GT(changed, contacts / 4);
        EXPECT_LT(moved / contacts, 0.01 * view.header.r_max);
    }
}

TEST(Query, UnitsAndPlaceOfTheMeshDoNotMatter)
{
    const mesh::Mesh shape = mesh::ellipsoid({1.6, 1.0, 0.5}, 3);
    struct Place {
        double scale;
        Vec3d shift;
    };
    test::Random random(6);
    for (const Place& place : {Place{1e6, {1e8, -1e8, 1e8}}, Place{1e-9, {}}, Place{1, {0, 0, 1000}}}) {
        const mesh::Mesh moved = test::mapped(shape, place.scale, place.shift);
        const test::Baked b = test::baked(mesh::canonicalized(moved));
        const model::ModelView view = b.view();
        const mesh::Solid solid(moved);  // in the mesh's own units
        const double r_max = view.header.r_max * view.header.unit;
        const Vec3d origin{view.header.origin[0], view.header.origin[1], view.header.origin[2]};
        for (int i = 0; i < 1500; ++i) {
            const Vec3d p = place.shift + place.scale * random.in_box({-1.7, -1.1, -0.6}, {1.7, 1.1, 0.6});
            const mesh::ClosestPoint nearest = solid.closest_boundary(p);
            if (nearest.distance < 1e-5 * r_max) continue;
            const Contact c = query_point(view, cast<float>((p - origin) / view.header.unit), Layer::Exact);
            ASSERT_EQ(c.contact, solid.inside(p)) << place.scale;
            if (c.contact) {
                EXPECT_NEAR(static_cast<double>(c.depth) * view.header.unit, nearest.distance, 2e-5 * r_max) << place.scale;
            }
        }
    }
}

TEST(Query, ExactDepthsAreThoseOfTheVisibleSurfaceWhereTrianglesCutEachOther)
{
    const mesh::Mesh bars = test::crossing_bars();
    const test::Parsed m(bars);
    const double unit = m.view().header.unit;
    test::Random random(6);
    int contacts = 0;
    for (int i = 0; i < 2000; ++i) {
        const Vec3d p = random.in_box({-2, -2, -0.5}, {2, 2, 0.5});
        const Contact c = query_point(m.view(), cast<float>(m.to_model(p)), Layer::Exact);
        if (!c.contact) continue;
        ++contacts;
        ASSERT_NEAR(unit * static_cast<double>(c.depth), test::depth_in_crossing_bars(p), 2e-5)
            << p.x << ' ' << p.y << ' ' << p.z;
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
        const Vec3f p = cast<float>(vertex + 0.1 * m.r_max() * random.between(0, 1) * random.direction());
        const mesh::ClosestPoint nearest = m.solid().closest_boundary(cast<double>(p));
        if (m.solid().inside(cast<double>(p))) continue;
        ++outside;
        // From a place beside it, a twentieth of the object's size away.
        const mesh::ClosestPoint from = m.solid().closest_boundary(nearest.point + 0.05 * m.r_max() * random.direction());
        const mesh::Triangle& t = mesh.triangles[from.triangle];
        const Vec3d a = mesh.vertices[t[0]], across = cross(mesh.vertices[t[1]] - a, mesh.vertices[t[2]] - a);
        Contact start;
        start.point = cast<float>(from.point);
        start.normal = cast<float>(normalized(across));
        const Contact c = nearest_surface(m.view(), p, start);
        ASSERT_TRUE(c.contact);
        worst = std::max(worst, std::abs(static_cast<double>(c.depth) - nearest.distance));
    }
    EXPECT_GT(outside, 500);
    EXPECT_LT(worst, 1e-6 * m.r_max());
    EXPECT_FALSE(nearest_surface(m.view(), {std::numeric_limits<float>::quiet_NaN(), 0, 0}, {}).contact);
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
        const Vec3f p = cast<float>(near);
        const Vec3d q = cast<double>(p);
        const mesh::ClosestPoint closest = m.solid().closest_boundary(q);
        if (closest.distance <= 1e-5 * r_max) continue;
        const bool truth = m.solid().bvh().winding_number(q) > 0;
        wrong += query_point(m.view(), p, Layer::Exact).contact != truth ? 1 : 0;
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
    const double unit = m.view().header.unit;
    for (const Layer layer : {Layer::Three, Layer::Exact})
        for (const Vec3d p : {Vec3d{0.6, 0.01, 0.02}, Vec3d{0.3, 0.2, 0.1}, Vec3d{-0.45, 0.2, -0.1}}) {
            const Contact c = query_point(m.view(), cast<float>(m.to_model(p)), layer);
            ASSERT_TRUE(c.contact);
            EXPECT_NEAR(unit * static_cast<double>(c.depth), 1 - norm(p), 0.015) << p.x;  // as a ball of flat faces
            EXPECT_GT(dot(cast<double>(c.normal), normalized(p)), 0.9) << p.x;
        }
}

}  // namespace
}  // namespace sqmap::query
