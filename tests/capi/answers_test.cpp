// The C interface: its answers are the C++ library's, bit for bit.
#include "capi/fixture.h"
#include "sqmap/query/contacts.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/first_touch.h"
#include "sqmap/query/point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace sqmap {
namespace {

using test::Capi;
using test::expect_refused;
using test::GivenMesh;

TEST_F(Capi, PointsHaveTheBitsOfTheLibrary)
{
    const std::size_t n = points_.size();
    std::vector<std::uint8_t> contact(n), certain(n), status(n);
    std::vector<double> depth(n), normal(3 * n), closest(3 * n);
    std::vector<std::int32_t> part(n);
    const sqmap_points in = points();
    for (const std::uint32_t threads : {1u, 3u})
        for (int layer = SQMAP_LAYER_1; layer <= SQMAP_LAYER_EXACT; ++layer) {
            sqmap_query_options options{};
            options.size = sizeof options;
            options.layer = layer;
            options.threads = threads;
            sqmap_contacts out{sizeof out,     contact.data(), depth.data(),
                               normal.data(),  closest.data(), part.data(),
                               certain.data(), status.data(),  0};
            ASSERT_EQ(sqmap_query_points(model_, &in, &options, &out), SQMAP_OK) << sqmap_last_error()->message;
            query::QueryOptions same;
            same.layer = static_cast<query::Layer>(layer - 1);
            std::size_t contacts = 0;
            for (std::size_t i = 0; i < n; ++i) {
                const query::PointResult r = query::query_point(view(), points_[i], same);
                contacts += r.contact ? 1 : 0;
                ASSERT_EQ(contact[i], r.contact ? 1 : 0);
                ASSERT_EQ(certain[i], r.certain ? 1 : 0);
                ASSERT_EQ(status[i], r.status);
                ASSERT_EQ(part[i], r.part);
                if (i == 17)
                    ASSERT_TRUE(std::isnan(depth[i]));
                else
                    ASSERT_EQ(depth[i], r.depth);
                ASSERT_EQ(std::memcmp(&normal[3 * i], &r.normal, sizeof r.normal), 0);
                ASSERT_EQ(std::memcmp(&closest[3 * i], &r.witness, sizeof r.witness), 0);
            }
            EXPECT_EQ(out.contacts, contacts);
        }
}

TEST_F(Capi, DistancesHaveTheBitsOfTheLibrary)
{
    const std::size_t n = points_.size();
    std::vector<double> distance(n), gradient(3 * n);
    std::vector<std::uint8_t> known(n), status(n);
    const sqmap_points in = points();
    for (const double band : {0.0, 0.3, std::numeric_limits<double>::infinity()}) {
        sqmap_query_options options{};
        options.size = sizeof options;
        options.band = band;
        sqmap_distances out{sizeof out, distance.data(), gradient.data(), nullptr, nullptr, known.data(), status.data(), nullptr};
        ASSERT_EQ(sqmap_signed_distances(model_, &in, &options, &out), SQMAP_OK) << sqmap_last_error()->message;
        for (std::size_t i = 0; i < n; ++i) {
            const query::SignedDistance d = query::distance(view(), points_[i], band == 0 ? query::k_baked_band : band);
            ASSERT_EQ(known[i], static_cast<std::uint8_t>(d.known));
            ASSERT_EQ(status[i], d.status);
            ASSERT_EQ(std::memcmp(&gradient[3 * i], &d.gradient, sizeof d.gradient), 0);
            if (i == 17)
                ASSERT_TRUE(std::isnan(distance[i]));
            else
                ASSERT_EQ(distance[i], d.distance);
            ASSERT_TRUE(!std::isinf(band) || i == 17 || known[i] == SQMAP_KNOWN_EXACT);
        }
    }
}

TEST_F(Capi, ExactDistancesHaveTheBitsOfTheLibraryAndNameTriangles)
{
    const std::size_t n = points_.size();
    std::vector<double> distance(n);
    std::vector<std::uint8_t> known(n);
    std::vector<std::uint32_t> triangle(n);
    const sqmap_points in = points();
    sqmap_distances out{sizeof out, distance.data(), nullptr, nullptr, nullptr, known.data(), nullptr, triangle.data()};
    ASSERT_EQ(sqmap_exact_distances(model_, &in, nullptr, &out), SQMAP_OK) << sqmap_last_error()->message;
    for (std::size_t i = 0; i < n; ++i) {
        const query::SignedDistance d = query::exact_distance(view(), points_[i]);
        ASSERT_EQ(known[i], static_cast<std::uint8_t>(d.known));
        ASSERT_EQ(static_cast<std::int32_t>(triangle[i]), d.triangle);
        ASSERT_TRUE(i == 17 ? std::isnan(distance[i]) : distance[i] == d.distance);
    }
    std::vector<std::int64_t> source(view().triangle_part.size());
    ASSERT_EQ(sqmap_sources(model_, source.data(), nullptr), SQMAP_OK);
    for (std::size_t i = 0; i < source.size(); ++i) EXPECT_EQ(source[i], std::int64_t{view().input.source_triangle[i]});
}

TEST_F(Capi, ProbesAndPairsHaveTheBitsOfTheLibrary)
{
    points_[17].y = 0;
    const query::Probe probe(points_);
    const sqmap_points in = points();
    sqmap_probe handle{};
    ASSERT_EQ(sqmap_make_probe(&in, &handle), SQMAP_OK);
    const sqmap_pose shift{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.2, 0, 0}};
    const query::Body touched{&view(), &probe, {}}, collider{&view(), &probe, {{}, {0.2, 0, 0}}};
    const sqmap_bodies bodies{sizeof bodies, {model_, handle, nullptr}, {model_, handle, &shift}};

    std::vector<query::Contact> expected(points_.size());
    const query::ProbeResult result = query::query_probe(touched, collider, {}, expected);
    std::vector<sqmap_contact> contacts(points_.size());
    sqmap_contact_list list{};
    list.size = sizeof list;
    list.contacts = contacts.data();
    list.capacity = contacts.size();
    ASSERT_EQ(sqmap_query_probe(&bodies, nullptr, &list), SQMAP_OK);
    ASSERT_EQ(list.found, result.contacts);
    ASSERT_GT(list.found, 100u);
    EXPECT_EQ(std::memcmp(contacts.data(), expected.data(), list.found * sizeof(sqmap_contact)), 0);
    list.capacity = 5;
    ASSERT_EQ(sqmap_query_probe(&bodies, nullptr, &list), SQMAP_OK);
    EXPECT_EQ(list.found, result.contacts);
    EXPECT_NE(list.status & SQMAP_FULL, 0u);

    query::PairWorkspace space(points_.size());
    const query::PairResult pair = query::query_pair(touched, collider, {}, space);
    sqmap_workspace workspace{};
    ASSERT_EQ(sqmap_make_workspace(points_.size(), &workspace), SQMAP_OK);
    sqmap_pair_list pairs{};
    pairs.size = sizeof pairs;
    ASSERT_EQ(sqmap_query_pair(&bodies, nullptr, workspace, &pairs), SQMAP_OK);
    ASSERT_EQ(pairs.count, pair.contacts.size());
    for (std::size_t i = 0; i < pairs.count; ++i) {
        EXPECT_EQ(std::memcmp(pairs.contacts[i].on_b, &pair.contacts[i].witness.on_b, sizeof(Vec3d)), 0);
        EXPECT_EQ(pairs.contacts[i].depth, pair.contacts[i].depth);
        EXPECT_EQ(pairs.contacts[i].is_mutual != 0, pair.contacts[i].mutual);
    }
    EXPECT_EQ(pairs.edge_length, 0);
    sqmap_query_options wider{};
    wider.size = sizeof wider;
    wider.margin = 0.1;
    ASSERT_EQ(sqmap_query_pair(&bodies, &wider, workspace, &pairs), SQMAP_OK);
    EXPECT_GT(pairs.edge_length, 0.199);
    EXPECT_EQ(pairs.edge_length, query::query_pair(touched, collider, {.query = {.margin = 0.1}}, space).edge_length);
    EXPECT_EQ(sqmap_close_probe(handle), SQMAP_OK);
    EXPECT_EQ(sqmap_close_workspace(workspace), SQMAP_OK);
    expect_refused(sqmap_query_probe(&bodies, nullptr, &list), SQMAP_E_HANDLE, "bodies.a.probe");
}

TEST_F(Capi, CompleteContactsAndFirstTouchHaveTheBitsOfTheLibrary)
{
    const mesh::Mesh& mesh = parsed_.mesh();
    const GivenMesh given(mesh);
    sqmap_mesh in = given();
    sqmap_probe handle{};
    ASSERT_EQ(sqmap_make_solid_probe(&in, &handle), SQMAP_OK);
    const query::Probe probe(mesh.vertices, mesh.triangles);
    const sqmap_pose shift{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.9, 0.1, 0}};
    const query::Body a{&view(), &probe, {}}, b{&view(), &probe, {{}, {0.9, 0.1, 0}}};
    const sqmap_bodies bodies{sizeof bodies, {model_, handle, nullptr}, {model_, handle, &shift}};

    sqmap_workspace workspace{};
    ASSERT_EQ(sqmap_make_workspace(2000, &workspace), SQMAP_OK);
    query::ContactWorkspace space(2000);
    sqmap_surface_list list{};
    list.size = sizeof list;
    for (const std::uint32_t per_region : {0u, 4u}) {
        const query::ContactResult expected = query::query_contacts(a, b, {.per_region = per_region}, space);
        const sqmap_contact_options options{sizeof options, per_region, 0};
        ASSERT_EQ(sqmap_query_contacts(&bodies, &options, workspace, &list), SQMAP_OK);
        ASSERT_EQ(list.count, expected.contacts.size());
        ASSERT_GT(list.count, per_region == 0 ? 20u : 3u);
        EXPECT_EQ(list.found, expected.found);
        EXPECT_EQ(list.meetings, expected.meetings);
        EXPECT_EQ(list.regions, expected.regions);
        for (std::size_t i = 0; i < list.count; ++i) {
            EXPECT_EQ(std::memcmp(list.contacts[i].on_b, &expected.contacts[i].witness.on_b, sizeof(Vec3d)), 0);
            EXPECT_EQ(list.contacts[i].depth, expected.contacts[i].depth);
            EXPECT_EQ(list.contacts[i].index_b, expected.contacts[i].index_b);
            EXPECT_EQ(list.contacts[i].region, expected.contacts[i].region);
        }
    }

    const Pose from{{}, {9, 0, 0}}, to{{}, {-9, 0.1, 0}};
    const sqmap_pose start{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {9, 0, 0}}, end{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-9, 0.1, 0}};
    const sqmap_bodies moving{sizeof moving, {model_, handle, nullptr}, {model_, handle, &start}};
    sqmap_touch touch{};
    touch.size = sizeof touch;
    ASSERT_EQ(sqmap_first_touch(&moving, &end, &touch), SQMAP_OK);
    const query::BodyTouch expected = query::first_touch(a, {&view(), &probe, from}, to);
    EXPECT_EQ(touch.time, expected.time);
    EXPECT_EQ(touch.touches, 1);
    const Pose to_a{{}, {3, 0, 0}};
    const sqmap_pose end_a{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {3, 0, 0}};
    touch.end_pose_a = &end_a;
    ASSERT_EQ(sqmap_first_touch(&moving, &end, &touch), SQMAP_OK);
    EXPECT_EQ(touch.time, query::first_touch(a, to_a, {&view(), &probe, from}, to).time);
    EXPECT_LT(touch.time, expected.time);

    in.triangle_count -= 1;
    sqmap_probe open{};
    EXPECT_EQ(sqmap_make_solid_probe(&in, &open), SQMAP_E_MESH);
    EXPECT_EQ(std::string(sqmap_last_error()->element).rfind("mesh.triangles[", 0), 0u);
    in.triangle_count += 1;
    std::vector<double> huge(in.vertices, in.vertices + 3 * in.vertex_count);
    for (double& x : huge) x *= 1e40;
    in.vertices = huge.data();
    EXPECT_EQ(sqmap_make_solid_probe(&in, &open), SQMAP_E_MESH);
    EXPECT_STREQ(sqmap_last_error()->element, "mesh.vertices");
    EXPECT_EQ(sqmap_close_workspace(workspace), SQMAP_OK);
    EXPECT_EQ(sqmap_close_probe(handle), SQMAP_OK);
}

TEST_F(Capi, TrianglesAreThoseThatWereBaked)
{
    sqmap_facts facts{};
    facts.size = sizeof facts;
    ASSERT_EQ(sqmap_model_facts(model_, &facts), SQMAP_OK);
    const mesh::Mesh& mesh = parsed_.mesh();
    ASSERT_EQ(facts.vertices, mesh.vertices.size());
    ASSERT_EQ(facts.triangles, mesh.triangles.size());
    std::vector<double> vertices(3 * facts.vertices);
    std::vector<std::uint32_t> triangles(3 * facts.triangles);
    std::vector<std::int32_t> parts(facts.triangles);
    ASSERT_EQ(sqmap_triangles(model_, vertices.data(), triangles.data(), parts.data()), SQMAP_OK);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        const Vec3d expected = model::input_vertex(view(), i);
        EXPECT_EQ(std::memcmp(&vertices[3 * i], &expected, sizeof expected), 0);
    }
    EXPECT_EQ(std::memcmp(triangles.data(), mesh.triangles.data(), 4 * triangles.size()), 0);
    for (const std::int32_t part : parts) EXPECT_LT(part, static_cast<std::int32_t>(facts.parts));
}

TEST_F(Capi, ImplicitIsThatOfThePartsSuperquadric)
{
    const sqmap_pose pose{{0, -1, 0, 1, 0, 0, 0, 0, 1}, {0.5, 0.25, -1}};
    const std::size_t n = points_.size();
    std::vector<double> values(n), moved(n);
    const sqmap_points in = points();
    std::vector<Vec3d> elsewhere;
    for (const Vec3d& p : points_) elsewhere.push_back({-p.y + 0.5, p.x + 0.25, p.z - 1});
    const sqmap_points posed{sizeof posed, &elsewhere[0].x, n, &pose};
    for (std::uint32_t part = 0; part < view().parts.size(); ++part) {
        ASSERT_EQ(sqmap_implicit(model_, part, &in, values.data()), SQMAP_OK) << sqmap_last_error()->message;
        ASSERT_EQ(sqmap_implicit(model_, part, &posed, moved.data()), SQMAP_OK);
        const auto own = shape::cast<double>(model::superquadric_of(view().parts[part]));
        const Vec3d origin{view().header.origin[0], view().header.origin[1], view().header.origin[2]};
        for (std::size_t i = 0; i < n; ++i) {
            if (i == 17) {
                EXPECT_TRUE(std::isnan(values[i]));
                continue;
            }
            const double expected = shape::implicit(own, (points_[i] - origin) / view().header.unit);
            ASSERT_EQ(values[i], expected);
            ASSERT_NEAR(moved[i], expected, 1e-9 * (1 + expected));
        }
    }
    const auto parts = static_cast<std::uint32_t>(view().parts.size());
    expect_refused(sqmap_implicit(model_, parts, &in, values.data()), SQMAP_E_ARGUMENT, "part");
    expect_refused(sqmap_implicit(model_, 0, &in, nullptr), SQMAP_E_ARGUMENT, "values");
}

}  // namespace
}  // namespace sqmap
