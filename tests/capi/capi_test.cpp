// The C interface: its answers are the C++ library's, bit for bit; bad input has a code, an element and a cure.
#include "sqmap.h"

#include "capi/allocations.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/query/contacts.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/first_touch.h"
#include "sqmap/query/point.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <thread>

namespace sqmap {
namespace {

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();

/// A torus by both interfaces.
class Capi : public testing::Test {
protected:
    Capi()
    {
        EXPECT_EQ(sqmap_open_bytes(bytes_.data(), bytes_.size(), &model_), SQMAP_OK);
        std::mt19937_64 random(1);
        std::uniform_real_distribution<double> uniform(-1.6, 1.6);
        for (int i = 0; i < 10'000; ++i) points_.push_back({uniform(random), uniform(random), uniform(random)});
        points_[17].y = k_nan;
    }
    ~Capi() override { EXPECT_EQ(sqmap_close_model(model_), SQMAP_OK); }

    [[nodiscard]] const model::ModelView& view() const { return parsed_.view(); }
    [[nodiscard]] sqmap_points points() const { return {sizeof(sqmap_points), &points_[0].x, points_.size(), nullptr}; }

    mesh::Mesh torus_ = mesh::torus();
    test::Parsed parsed_{torus_};
    std::vector<std::byte> bytes_ = test::baked_bytes(torus_, true);
    sqmap_model model_{};
    std::vector<Vec3d> points_;
};

/// The last error is complete, and says this of where.
void expect_refused(sqmap_code code, sqmap_code expected, const std::string& element)
{
    ASSERT_EQ(code, expected) << sqmap_last_error()->message;
    const sqmap_error& e = *sqmap_last_error();
    EXPECT_EQ(e.code, expected);
    EXPECT_EQ(e.element, element);
    EXPECT_GT(std::strlen(e.name), 2u);
    EXPECT_GT(std::strlen(e.message), 2u);
    EXPECT_GT(std::strlen(e.cure), 2u);
}

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

/// A mesh as callers may have it: as it is, in another order of its faces and corners, each face with corners of its own, with
/// its vertices in another order.
std::vector<mesh::Mesh> forms_of(const mesh::Mesh& mesh, std::mt19937_64& random)
{
    mesh::Mesh reordered = mesh, loose, shuffled = mesh;
    std::ranges::shuffle(reordered.triangles, random);
    for (mesh::Triangle& t : reordered.triangles) std::rotate(t.begin(), t.begin() + random() % 3, t.end());
    for (const mesh::Triangle& t : mesh.triangles) {
        const auto first = static_cast<std::uint32_t>(loose.vertices.size());
        for (const auto corner : t) loose.vertices.push_back(mesh.vertices[corner]);
        loose.triangles.push_back({first, first + 1, first + 2});
    }
    std::vector<std::size_t> order(mesh.vertices.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::shuffle(order, random);
    for (std::size_t i = 0; i < order.size(); ++i) shuffled.vertices[order[i]] = mesh.vertices[i];
    for (mesh::Triangle& t : shuffled.triangles)
        for (auto& corner : t) corner = static_cast<std::uint32_t>(order[corner]);
    return {mesh, reordered, loose, shuffled};
}

/// Contacts of a model's own triangles with themselves, moved by a little: the vertices and edges that they name, by their
/// numbers in the mesh that was given, hold the witness points. Returns how many were named.
std::size_t contacts_named(sqmap_model model, const mesh::Mesh& given)
{
    sqmap_facts facts{};
    facts.size = sizeof facts;
    EXPECT_EQ(sqmap_model_facts(model, &facts), SQMAP_OK);
    std::vector<std::int64_t> source(facts.vertices), corners;
    std::vector<Vec3d> baked(facts.vertices);
    std::vector<std::uint32_t> triangles(3 * std::size_t{facts.triangles});
    EXPECT_EQ(sqmap_sources(model, nullptr, source.data()), SQMAP_OK);
    EXPECT_EQ(sqmap_triangles(model, &baked[0].x, triangles.data(), nullptr), SQMAP_OK);
    corners.assign(triangles.begin(), triangles.end());
    const sqmap_mesh mesh{sizeof mesh, &baked[0].x, baked.size(), corners.data(), facts.triangles};
    sqmap_probe probe{};
    EXPECT_EQ(sqmap_make_solid_probe(&mesh, &probe), SQMAP_OK) << sqmap_last_error()->message;
    const Vec3d step = facts.r_max * Vec3d{0.011, 0.017, 0.007};
    const sqmap_pose moved{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {step.x, step.y, step.z}};
    const sqmap_bodies bodies{sizeof bodies, {model, probe, nullptr}, {model, probe, &moved}};
    sqmap_workspace workspace{};
    EXPECT_EQ(sqmap_make_workspace(4096, &workspace), SQMAP_OK);
    sqmap_surface_list list{};
    list.size = sizeof list;
    EXPECT_EQ(sqmap_query_contacts(&bodies, nullptr, workspace, &list), SQMAP_OK);
    std::size_t named = 0;
    const auto check = [&](int feature, std::uint32_t index, const double* witness, Vec3d by) {
        if (feature == SQMAP_FACE) return;
        const auto at = [&](std::size_t corner) {
            return given.vertices[static_cast<std::size_t>(source[triangles[corner]])] + by;
        };
        const Vec3d p{witness[0], witness[1], witness[2]};
        const std::size_t k = index % 3, next = index - k + (k + 1) % 3;
        const Vec3d from = feature == SQMAP_EDGE ? at(index) : given.vertices[static_cast<std::size_t>(source[index])] + by;
        const Vec3d to = feature == SQMAP_EDGE ? at(next) : from;
        EXPECT_NEAR(norm(p - from) + norm(p - to), norm(to - from), 1e-5 * facts.r_max);
        ++named;
    };
    for (std::size_t i = 0; i < list.count; ++i) {
        const sqmap_surface_contact& c = list.contacts[i];
        check(c.feature_a, c.index_a, c.on_a, {});
        check(c.feature_b, c.index_b, c.on_b, step);
    }
    EXPECT_EQ(sqmap_close_workspace(workspace), SQMAP_OK);
    EXPECT_EQ(sqmap_close_probe(probe), SQMAP_OK);
    return named;
}

TEST(CapiSources, FaceCentresAndContactsNameWhatWasGiven)
{
    std::mt19937_64 random(3);
    shape::Superquadricd bent{};
    bent.a = {1, 0.6, 0.4};
    const mesh::Mesh meshes[] = {mesh::sphere(1, 1),
                                 mesh::sphere(1e-3, 2),
                                 mesh::ellipsoid({3, 1, 0.5}, 2),
                                 mesh::rounded_box({1, 2, 0.5}, 0.2, 2),
                                 mesh::rounded_box({1, 1, 1}, 0.1, 1),
                                 mesh::torus({.major_segments = 12, .minor_segments = 8}),
                                 mesh::torus({.minor_radius = 0.7, .major_segments = 16, .minor_segments = 10}),
                                 mesh::dumbbell({.segments = 10}),
                                 mesh::dumbbell({.bar_radius = 0.8, .segments = 14}),
                                 mesh::superquadric_surface(bent, 5)};
    std::size_t named = 0, touched = 0;
    for (const mesh::Mesh& mesh : meshes)
        for (const mesh::Mesh& given : forms_of(mesh, random)) {
            std::vector<std::int64_t> corners;
            std::vector<Vec3d> centres;
            for (const mesh::Triangle& t : given.triangles) {
                corners.insert(corners.end(), t.begin(), t.end());
                centres.push_back((given.vertices[t[0]] + given.vertices[t[1]] + given.vertices[t[2]]) / 3.0);
            }
            const std::size_t n = centres.size();
            const sqmap_mesh in{sizeof in, &given.vertices[0].x, given.vertices.size(), corners.data(), n};
            sqmap_bake_options options{};
            options.size = sizeof options;
            options.threads = 1;
            options.target_error = 5;  // of the maps, which answer nothing here
            sqmap_model model{};
            ASSERT_EQ(sqmap_bake(&in, &options, &model), SQMAP_OK) << sqmap_last_error()->message;
            sqmap_facts facts{};
            facts.size = sizeof facts;
            ASSERT_EQ(sqmap_model_facts(model, &facts), SQMAP_OK);
            std::vector<std::int64_t> triangle_source(facts.triangles), vertex_source(facts.vertices);
            ASSERT_EQ(sqmap_sources(model, triangle_source.data(), vertex_source.data()), SQMAP_OK);
            std::vector<std::uint32_t> exact(n), closest(n);
            const sqmap_points points{sizeof points, &centres[0].x, n, nullptr};
            sqmap_distances distances{};
            distances.size = sizeof distances;
            distances.triangle = exact.data();
            ASSERT_EQ(sqmap_exact_distances(model, &points, nullptr, &distances), SQMAP_OK);
            sqmap_closest nearest{};
            nearest.size = sizeof nearest;
            nearest.triangle = closest.data();
            ASSERT_EQ(sqmap_closest_points(model, &points, nullptr, &nearest), SQMAP_OK);
            for (std::size_t i = 0; i < n; ++i, ++named) {
                ASSERT_EQ(triangle_source[exact[i]], static_cast<std::int64_t>(i));
                ASSERT_EQ(triangle_source[closest[i]], static_cast<std::int64_t>(i));
            }
            std::vector<Vec3d> baked(facts.vertices);
            ASSERT_EQ(sqmap_triangles(model, &baked[0].x, nullptr, nullptr), SQMAP_OK);
            for (std::size_t v = 0; v < baked.size(); ++v) {
                const Vec3d own = given.vertices[static_cast<std::size_t>(vertex_source[v])];
                ASSERT_EQ(std::memcmp(&baked[v], &own, sizeof own), 0);
            }
            touched += contacts_named(model, given);
            EXPECT_EQ(sqmap_close_model(model), SQMAP_OK);
        }
    EXPECT_GT(named, 5000u);
    EXPECT_GT(touched, 1000u);
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
    EXPECT_EQ(sqmap_close_probe(handle), SQMAP_OK);
    EXPECT_EQ(sqmap_close_workspace(workspace), SQMAP_OK);
    expect_refused(sqmap_query_probe(&bodies, nullptr, &list), SQMAP_E_HANDLE, "bodies.a.probe");
}

TEST_F(Capi, CompleteContactsAndFirstTouchHaveTheBitsOfTheLibrary)
{
    const mesh::Mesh& mesh = parsed_.mesh();
    std::vector<std::int64_t> corners;
    for (const mesh::Triangle& t : mesh.triangles) corners.insert(corners.end(), t.begin(), t.end());
    sqmap_mesh in{sizeof in, &mesh.vertices[0].x, mesh.vertices.size(), corners.data(), mesh.triangles.size()};
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

    in.triangle_count -= 1;
    sqmap_probe open{};
    EXPECT_EQ(sqmap_make_solid_probe(&in, &open), SQMAP_E_MESH);
    EXPECT_EQ(std::string(sqmap_last_error()->element).rfind("mesh.triangles[", 0), 0u);
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

TEST_F(Capi, StructsOfOtherHeadersAreTaken)
{
    const sqmap_points in = points();
    std::vector<double> distance(points_.size());
    // A shorter struct: what it lacks has its default, and nothing is written behind it.
    struct Shorter {
        std::size_t size;
        double* distance;
        std::uint64_t behind;
    } shorter{2 * sizeof(std::size_t), distance.data(), 0x1234567890abcdef};
    EXPECT_EQ(sqmap_signed_distances(model_, &in, nullptr, reinterpret_cast<sqmap_distances*>(&shorter)), SQMAP_OK);
    EXPECT_EQ(shorter.behind, 0x1234567890abcdefu);
    // A longer one whose unknown member is zero is taken, another is not.
    struct Longer {
        sqmap_query_options known;
        std::uint64_t unknown;
    } longer{};
    longer.known.size = sizeof longer;
    sqmap_distances out{sizeof out, distance.data(), nullptr, nullptr, nullptr, nullptr, nullptr, nullptr};
    EXPECT_EQ(sqmap_signed_distances(model_, &in, &longer.known, &out), SQMAP_OK);
    longer.unknown = 1;
    expect_refused(sqmap_signed_distances(model_, &in, &longer.known, &out), SQMAP_E_ARGUMENT, "options");
    longer.known.size = 0;
    expect_refused(sqmap_signed_distances(model_, &in, &longer.known, &out), SQMAP_E_ARGUMENT, "options.size");
}

TEST_F(Capi, BadArgumentsAreNamed)
{
    const sqmap_points in = points();
    sqmap_contacts out{};
    out.size = sizeof out;
    expect_refused(sqmap_query_points(model_, nullptr, nullptr, &out), SQMAP_E_ARGUMENT, "points");
    expect_refused(sqmap_query_points(model_, &in, nullptr, nullptr), SQMAP_E_ARGUMENT, "contacts");
    sqmap_points none = in;
    none.xyz = nullptr;
    expect_refused(sqmap_query_points(model_, &none, nullptr, &out), SQMAP_E_ARGUMENT, "points.xyz");
    const sqmap_pose scaled{{2, 0, 0, 0, 2, 0, 0, 0, 2}, {0, 0, 0}}, lost{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, k_nan, 0}};
    sqmap_points posed = in;
    posed.pose = &scaled;
    expect_refused(sqmap_query_points(model_, &posed, nullptr, &out), SQMAP_E_ARGUMENT, "points.pose.rotation");
    posed.pose = &lost;
    expect_refused(sqmap_query_points(model_, &posed, nullptr, &out), SQMAP_E_ARGUMENT, "points.pose.translation[1]");
    expect_refused(sqmap_open(nullptr, &model_), SQMAP_E_ARGUMENT, "path");
    EXPECT_EQ(model_.id, 0u);
    expect_refused(sqmap_open("model.sqmap", nullptr), SQMAP_E_ARGUMENT, "model");
    expect_refused(sqmap_open("there/is/none.sqmap", &model_), SQMAP_E_FILE, "there/is/none.sqmap");
    expect_refused(sqmap_open_archived(nullptr, "", &model_), SQMAP_E_ARGUMENT, "archive");
    expect_refused(sqmap_open_archived("a.tar", nullptr, &model_), SQMAP_E_ARGUMENT, "key");
    expect_refused(sqmap_open_archived("there/is/none.tar", "", &model_), SQMAP_E_FILE, "there/is/none.tar");
    expect_refused(sqmap_save({42}, "model.sqmap"), SQMAP_E_HANDLE, "model");
}

TEST_F(Capi, RotationsAreMendedWithinTheTolerance)
{
    points_[17].y = 0;
    const double angle = 0.7, c = std::cos(angle), s = std::sin(angle);
    const sqmap_pose exact{{c, -s, 0, s, c, 0, 0, 0, 1}, {0.1, 0, 0}};
    const auto distances_with = [&](double off) {
        sqmap_pose pose = exact;
        pose.rotation[0] += off;
        pose.rotation[5] -= off;
        sqmap_points in = points();
        in.pose = &pose;
        std::vector<double> distance(points_.size());
        sqmap_closest out{sizeof out, nullptr, distance.data(), nullptr};
        EXPECT_EQ(sqmap_closest_points(model_, &in, nullptr, &out), SQMAP_OK) << sqmap_last_error()->message;
        return distance;
    };
    // Below 1e-6 a rotation is taken bit for bit as it is given.
    const double tiny = 3e-7;
    const Pose back = inverse(Pose{{{{c + tiny, -s, 0}, {s, c, -tiny}, {0, 0, 1}}}, {0.1, 0, 0}});
    std::vector<Vec3d> own;
    for (const Vec3d p : points_) own.push_back(apply(back, p));
    const sqmap_points in_own{sizeof in_own, &own[0].x, own.size(), nullptr};
    std::vector<double> expected(own.size());
    sqmap_closest answer{sizeof answer, nullptr, expected.data(), nullptr};
    ASSERT_EQ(sqmap_closest_points(model_, &in_own, nullptr, &answer), SQMAP_OK);
    EXPECT_EQ(distances_with(tiny), expected);
    // Above, it is made orthonormal.
    const double large = 5e-5;
    const std::vector<double> mended = distances_with(large), straight = distances_with(0);
    for (std::size_t i = 0; i < mended.size(); ++i) EXPECT_NEAR(mended[i], straight[i], 4 * large);
    sqmap_pose pose = exact;
    pose.rotation[0] += large;
    pose.rotation[5] -= large;
    sqmap_points in = points();
    in.pose = &pose;
    std::vector<Vec3d> closest(points_.size());
    sqmap_closest out{sizeof out, &closest[0].x, nullptr, nullptr};
    ASSERT_EQ(sqmap_closest_points(model_, &in, nullptr, &out), SQMAP_OK);
    for (std::size_t i = 0; i < mended.size(); ++i) EXPECT_NEAR(norm(closest[i] - points_[i]), mended[i], 1e-12);
    pose = exact;
    pose.rotation[0] += 2e-4;
    expect_refused(sqmap_closest_points(model_, &in, nullptr, &out), SQMAP_E_ARGUMENT, "points.pose.rotation");
    EXPECT_NE(std::string(sqmap_last_error()->message).find("the tolerance is 0.0001"), std::string::npos);
    pose = exact;
    pose.rotation[4] = k_nan;
    expect_refused(sqmap_closest_points(model_, &in, nullptr, &out), SQMAP_E_ARGUMENT, "points.pose.rotation[4]");
    EXPECT_STREQ(sqmap_last_error()->message, "is NaN");
}

TEST_F(Capi, BytesThatAreNoModelAreRefused)
{
    const std::vector<std::byte>& whole = bytes_;
    sqmap_model model{};
    for (const std::size_t size : {std::size_t{0}, std::size_t{7}, whole.size() / 2, whole.size() - 1}) {
        expect_refused(sqmap_open_bytes(whole.data(), size, &model), SQMAP_E_MODEL, "bytes");
        EXPECT_EQ(model.id, 0u);
    }
    expect_refused(sqmap_open_bytes(nullptr, 8, &model), SQMAP_E_ARGUMENT, "bytes");
}

TEST_F(Capi, HandlesAreNotGivenTwice)
{
    sqmap_model first{}, second{};
    ASSERT_EQ(sqmap_open_bytes(bytes_.data(), bytes_.size(), &first), SQMAP_OK);
    ASSERT_EQ(sqmap_close_model(first), SQMAP_OK);
    ASSERT_EQ(sqmap_open_bytes(bytes_.data(), bytes_.size(), &second), SQMAP_OK);
    EXPECT_NE(first.id, second.id);
    expect_refused(sqmap_close_model(first), SQMAP_E_HANDLE, "model");
    expect_refused(sqmap_close_probe({second.id}), SQMAP_E_HANDLE, "probe");  // a model is no probe
    EXPECT_EQ(sqmap_close_model(second), SQMAP_OK);
    EXPECT_EQ(sqmap_close_model({0}), SQMAP_OK);
}

TEST_F(Capi, ErrorsBelongToTheirThread)
{
    expect_refused(sqmap_close_model({99}), SQMAP_E_HANDLE, "model");
    std::thread([] { EXPECT_EQ(sqmap_last_error()->code, SQMAP_OK); }).join();
    EXPECT_EQ(sqmap_last_error()->code, SQMAP_E_HANDLE);
}

TEST_F(Capi, ProgressCancelsABake)
{
    const mesh::Mesh ball = mesh::sphere(1, 3);
    std::vector<std::int64_t> triangles;
    for (const mesh::Triangle& t : ball.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
    const sqmap_mesh in{sizeof in, &ball.vertices[0].x, ball.vertices.size(), triangles.data(), ball.triangles.size()};
    int left = 3;
    sqmap_bake_options options{};
    options.size = sizeof options;
    options.progress_context = &left;
    options.progress = [](void* context, const char*, double) { return --*static_cast<int*>(context) == 0 ? 1 : 0; };
    sqmap_model model{};
    expect_refused(sqmap_bake(&in, &options, &model), SQMAP_E_CANCELLED, "progress");
    EXPECT_EQ(left, 0);
    EXPECT_EQ(model.id, 0u);
}

TEST_F(Capi, TextsAreCutToTheirSpace)
{
    sqmap_text text{sizeof text, nullptr, 0, 0, 0};
    ASSERT_EQ(sqmap_info(model_, &text), SQMAP_OK);
    ASSERT_GT(text.needed, 100u);
    std::string whole(text.needed, '#'), part(10, '#');
    text.text = whole.data();
    text.capacity = whole.size();
    ASSERT_EQ(sqmap_info(model_, &text), SQMAP_OK);
    EXPECT_EQ(whole.find('\0'), whole.size() - 1);
    text.text = part.data();
    text.capacity = 5;
    ASSERT_EQ(sqmap_info(model_, &text), SQMAP_OK);
    EXPECT_EQ(part.substr(0, 4), whole.substr(0, 4));
    EXPECT_EQ(part.substr(4), std::string("\0#####", 6));
}

TEST_F(Capi, NotesStandInTheFileInTheWordsOfWhoAsks)
{
    mesh::Mesh open = torus_;
    open.triangles.erase(open.triangles.begin() + 7);  // a hole that a cure closes, on a torus of 60 units
    for (Vec3d& v : open.vertices) v = 30.0 * v;
    std::vector<std::int64_t> corners;
    for (const mesh::Triangle& t : open.triangles) corners.insert(corners.end(), t.begin(), t.end());
    const sqmap_mesh in{sizeof in, &open.vertices[0].x, open.vertices.size(), corners.data(), open.triangles.size()};
    sqmap_bake_options options{};
    options.size = sizeof options;
    options.words = SQMAP_WORDS_PYTHON;
    sqmap_model baked{}, opened{};
    ASSERT_EQ(sqmap_bake(&in, &options, &baked), SQMAP_OK) << sqmap_last_error()->message;
    const void* bytes = nullptr;
    std::size_t size = 0;
    ASSERT_EQ(sqmap_bytes(baked, &bytes, &size), SQMAP_OK);
    ASSERT_EQ(sqmap_open_bytes(bytes, size, &opened), SQMAP_OK);
    const auto notes_of = [](sqmap_model model, std::int32_t words) {
        std::string out(4000, '\0');
        sqmap_text text{sizeof text, out.data(), out.size(), 0, words};
        EXPECT_EQ(sqmap_notes(model, &text), SQMAP_OK) << sqmap_last_error()->message;
        return std::string(out.c_str());
    };
    const std::string python = notes_of(baked, 0), c = notes_of(opened, 0);
    EXPECT_NE(python.find("made up: "), std::string::npos) << python;
    EXPECT_NE(python.find("(such as unit=\"mm\")"), std::string::npos) << python;
    EXPECT_NE(c.find("(such as unit = 0.001)"), std::string::npos) << c;
    EXPECT_EQ(notes_of(opened, SQMAP_WORDS_PYTHON), python);
    EXPECT_EQ(notes_of(opened, SQMAP_WORDS_JAVASCRIPT), notes_of(baked, SQMAP_WORDS_JAVASCRIPT));
    sqmap_facts facts{};
    facts.size = sizeof facts;
    ASSERT_EQ(sqmap_model_facts(opened, &facts), SQMAP_OK);
    EXPECT_EQ(facts.cure, 1);
    sqmap_text text{sizeof text, nullptr, 0, 0, 3};
    expect_refused(sqmap_notes(opened, &text), SQMAP_E_ARGUMENT, "lines.words");
    EXPECT_EQ(sqmap_close_model(baked), SQMAP_OK);
    EXPECT_EQ(sqmap_close_model(opened), SQMAP_OK);
}

TEST_F(Capi, ACureStandsInTheWordsOfWhoAsks)
{
    std::vector<std::int64_t> corners;
    for (const mesh::Triangle& t : torus_.triangles) corners.insert(corners.end(), t.begin(), t.end());
    const sqmap_mesh in{sizeof in, &torus_.vertices[0].x, torus_.vertices.size(), corners.data(), torus_.triangles.size()};
    sqmap_bake_options options{};
    options.size = sizeof options;
    options.without_exact = options.without_input = 1;
    sqmap_model bare{};
    ASSERT_EQ(sqmap_bake(&in, &options, &bare), SQMAP_OK) << sqmap_last_error()->message;
    expect_refused(sqmap_triangles(bare, nullptr, nullptr, nullptr), SQMAP_E_MISSING, "model");
    EXPECT_STREQ(sqmap_last_error()->cure, "bake it with the exact layer: without_exact = 0");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_PYTHON), "bake it with the exact layer: exact=True");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_JAVASCRIPT), "bake it with the exact layer: exact: true");
    expect_refused(sqmap_sources(bare, nullptr, nullptr), SQMAP_E_MISSING, "model");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_C), "bake it again with without_input = 0");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_PYTHON), "bake it again with keep_input=True");
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_JAVASCRIPT), "bake it again with keepInput: true");
    for (const std::int32_t none : {-1, 3, 1 << 30}) EXPECT_STREQ(sqmap_last_cure(none), sqmap_last_error()->cure);
    EXPECT_EQ(sqmap_close_model(bare), SQMAP_OK);
    expect_refused(sqmap_close_model(bare), SQMAP_E_HANDLE, "model");  // a cure that names no setting is the same for all
    EXPECT_STREQ(sqmap_last_cure(SQMAP_WORDS_PYTHON), sqmap_last_error()->cure);
}

TEST_F(Capi, AUnitMakesMetres)
{
    std::vector<std::int64_t> corners;
    for (const mesh::Triangle& t : torus_.triangles) corners.insert(corners.end(), t.begin(), t.end());
    const sqmap_mesh in{sizeof in, &torus_.vertices[0].x, torus_.vertices.size(), corners.data(), torus_.triangles.size()};
    sqmap_bake_options options{};
    options.size = sizeof options;
    options.unit = 0.001;
    sqmap_model model{};
    ASSERT_EQ(sqmap_bake(&in, &options, &model), SQMAP_OK) << sqmap_last_error()->message;
    sqmap_facts millimetres{}, metres{};
    millimetres.size = metres.size = sizeof metres;
    ASSERT_EQ(sqmap_model_facts(model_, &millimetres), SQMAP_OK);
    ASSERT_EQ(sqmap_model_facts(model, &metres), SQMAP_OK);
    EXPECT_NEAR(metres.r_max, 0.001 * millimetres.r_max, 1e-15);
    const Vec3d centre{0, 0, 0};
    const sqmap_points points{sizeof points, &centre.x, 1, nullptr};
    double distance = 0;
    sqmap_distances out{};
    out.size = sizeof out;
    out.distance = &distance;
    ASSERT_EQ(sqmap_exact_distances(model, &points, nullptr, &out), SQMAP_OK);
    double own = 0;
    out.distance = &own;
    ASSERT_EQ(sqmap_exact_distances(model_, &points, nullptr, &out), SQMAP_OK);
    EXPECT_NEAR(distance, 0.001 * own, 1e-15);
    EXPECT_EQ(sqmap_close_model(model), SQMAP_OK);
    for (const double unit : {-1.0, 1e-13, 1e13, k_nan}) {
        options.unit = unit;
        expect_refused(sqmap_bake(&in, &options, &model), SQMAP_E_ARGUMENT, "options.unit");
    }
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

TEST_F(Capi, TicksAllocateNothing)
{
    points_[17].y = 0;
    const std::size_t n = points_.size();
    const sqmap_points in = points();
    std::vector<double> distance(n);
    std::vector<sqmap_contact> space(n);
    sqmap_probe probe{};
    sqmap_workspace workspace{};
    sqmap_session session{};
    ASSERT_EQ(sqmap_make_probe(&in, &probe), SQMAP_OK);
    ASSERT_EQ(sqmap_make_workspace(n, &workspace), SQMAP_OK);
    ASSERT_EQ(sqmap_make_session(model_, nullptr, &session), SQMAP_OK);
    const sqmap_bodies bodies{sizeof bodies, {model_, probe, nullptr}, {model_, probe, nullptr}};
    sqmap_distances distances{sizeof distances, distance.data(), nullptr, nullptr, nullptr, nullptr, nullptr, nullptr};
    sqmap_contacts contacts{};
    contacts.size = sizeof contacts;
    contacts.depth = distance.data();
    sqmap_contact_list list{};
    list.size = sizeof list;
    list.contacts = space.data();
    list.capacity = n;
    sqmap_pair_list pairs{};
    pairs.size = sizeof pairs;
    sqmap_tick tick{};
    tick.size = sizeof tick;
    tick.pose = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {1, 0, 0.2}};
    sqmap_force force{};
    force.size = sizeof force;
    const std::size_t before = test::allocations();
    bool ok = sqmap_query_points(model_, &in, nullptr, &contacts) == SQMAP_OK;
    ok = ok && sqmap_signed_distances(model_, &in, nullptr, &distances) == SQMAP_OK;
    ok = ok && sqmap_query_probe(&bodies, nullptr, &list) == SQMAP_OK;
    ok = ok && sqmap_query_pair(&bodies, nullptr, workspace, &pairs) == SQMAP_OK;
    for (tick.sequence = 1; tick.sequence < 20; ++tick.sequence) {
        tick.time = tick.sample_time += 0.001;
        ok = ok && sqmap_tick_session(session, &tick, &force) == SQMAP_OK;
    }
    EXPECT_EQ(test::allocations(), before);
    EXPECT_TRUE(ok);
    EXPECT_GT(list.found, 0u);
    EXPECT_GT(force.depth, 0);
    sqmap_close_session(session);
    sqmap_close_workspace(workspace);
    sqmap_close_probe(probe);
    const std::size_t again = test::allocations();
    ASSERT_EQ(sqmap_make_probe(&in, &probe), SQMAP_OK);
    EXPECT_GT(test::allocations(), again);  // the count sees the library
    sqmap_close_probe(probe);
}

TEST_F(Capi, ATickThatFailsLeavesNoForce)
{
    sqmap_session session{};
    ASSERT_EQ(sqmap_make_session(model_, nullptr, &session), SQMAP_OK) << sqmap_last_error()->message;
    sqmap_force force{};
    force.size = sizeof force;
    const auto expect_none = [&] {
        for (int i = 0; i < 3; ++i) {
            EXPECT_EQ(force.force[i], 0);
            EXPECT_EQ(force.torque[i], 0);
        }
    };
    force.force[1] = 7;
    expect_refused(sqmap_tick_session(session, nullptr, &force), SQMAP_E_ARGUMENT, "tick");
    expect_none();
    sqmap_tick tick{};
    tick.size = sizeof tick;
    for (const double bad : {k_nan, std::numeric_limits<double>::infinity(), 0.0}) {
        for (double& r : tick.pose.rotation) r = bad;  // zero is no rotation either
        ++tick.sequence;
        tick.time = tick.sample_time += 0.001;
        force.force[1] = 7;
        EXPECT_EQ(sqmap_tick_session(session, &tick, &force), SQMAP_OK);
        expect_none();
    }
    EXPECT_EQ(sqmap_close_session(session), SQMAP_OK);
    force.force[1] = 7;
    expect_refused(sqmap_tick_session(session, &tick, &force), SQMAP_E_HANDLE, "session");
    expect_none();
}

/// Sessions on the torus, whose tube is 2.5 cm thick here, touched from above.
class CapiModes : public Capi {
protected:
    static sqmap_session_options options_of(std::int32_t mode)
    {
        sqmap_session_options options{};
        options.size = sizeof options;
        options.metres_per_unit = 0.05;
        options.stiffness = 300;
        options.friction = -1;
        options.layer = SQMAP_LAYER_EXACT;
        options.side_path = 0.005;
        options.mode = mode;
        return options;
    }
    void make(const sqmap_session_options& options)
    {
        ASSERT_EQ(sqmap_make_session(model_, &options, &session_), SQMAP_OK) << sqmap_last_error()->message;
        tick_ = {};
        tick_.size = sizeof tick_;
        tick_.pose = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.05, 0, k_above}};
    }
    /// The last tick's result when the device has gone down to a height, m.
    sqmap_force pressed_to(double height)
    {
        sqmap_force force{};
        force.size = sizeof force;
        for (int i = 0; i < k_ticks; ++i) {
            ++tick_.sequence;
            tick_.time = tick_.sample_time += 0.001;
            tick_.pose.translation[2] += (height - tick_.pose.translation[2]) / (k_ticks - i);
            EXPECT_EQ(sqmap_tick_session(session_, &tick_, &force), SQMAP_OK);
        }
        return force;
    }

    static constexpr double k_above = 0.015, k_surface = 0.0125, k_in = 0.0095, k_through = -0.008;
    static constexpr int k_ticks = 400;
    sqmap_session session_{};
    sqmap_tick tick_{};
};

TEST_F(CapiModes, TheToolIsWhereTheModePutsIt)
{
    make(options_of(SQMAP_MODE_DIRECT));
    sqmap_force force = pressed_to(k_in);
    EXPECT_NEAR(force.tool.translation[2], k_in, 1e-12);
    EXPECT_GT(force.commanded[2], 0.5);
    EXPECT_LT(pressed_to(k_through).commanded[2], 0);  // out of the other side
    sqmap_close_session(session_);

    make(options_of(SQMAP_MODE_PROXY));
    for (const double height : {k_in, k_through}) {
        force = pressed_to(height);
        EXPECT_NEAR(force.tool.translation[2], k_surface, 2e-4);
        EXPECT_NEAR(force.commanded[2], 300 * (k_surface - height), 0.1);
        EXPECT_NEAR(force.depth, k_surface - height, 3e-4);
        EXPECT_GT(force.normal[2], 0.99);
    }
    sqmap_close_session(session_);

    make(options_of(SQMAP_MODE_COUPLED));
    force = pressed_to(k_in);
    EXPECT_GT(force.tool.translation[2], k_in + 1e-4);
    EXPECT_LT(force.tool.translation[2], k_surface);
    EXPECT_GT(force.commanded[2], 0.1);
    sqmap_close_session(session_);
}

TEST_F(CapiModes, AnOlderHeaderHasTheDirectOne)
{
    sqmap_session_options options = options_of(SQMAP_MODE_PROXY);
    options.size = offsetof(sqmap_session_options, side_path);
    make(options);
    EXPECT_NEAR(pressed_to(k_in).tool.translation[2], k_in, 1e-12);
    sqmap_close_session(session_);
}

TEST_F(CapiModes, ToolsOfTrianglesAreFeltWithTheirEdges)
{
    // A blade across the tube: its lower edge touches, far from its ends.
    const double vertices[] = {-0.03, 0, 0, 0.03, 0, 0, 0, -0.01, 0.02, 0, 0.01, 0.02};
    const std::int64_t triangles[] = {0, 1, 2, 1, 0, 3, 0, 2, 3, 1, 3, 2};
    const sqmap_mesh blade{sizeof(sqmap_mesh), vertices, 4, triangles, 4};
    sqmap_session_options options = options_of(SQMAP_MODE_DIRECT);
    ASSERT_EQ(sqmap_make_solid_probe(&blade, &options.tool), SQMAP_OK);
    make(options);
    EXPECT_GT(pressed_to(k_in).commanded[2], 0.1);
    sqmap_close_session(session_);

    options.without_edges = 1;
    make(options);
    EXPECT_EQ(pressed_to(k_in).commanded[2], 0);
    sqmap_close_session(session_);

    options.radius = 0.001;
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_ARGUMENT, "options.radius");
    options.radius = 0;
    sqmap_close_probe(options.tool);
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_HANDLE, "options.tool");
    const sqmap_points points{sizeof(sqmap_points), vertices, 4, nullptr};
    ASSERT_EQ(sqmap_make_probe(&points, &options.tool), SQMAP_OK);
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_MISSING, "options.tool");
    sqmap_close_probe(options.tool);
}

TEST_F(CapiModes, OthersAreRefused)
{
    sqmap_session_options options = options_of(7);
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_ARGUMENT, "options.mode");
    options = options_of(SQMAP_MODE_PROXY);
    options.side_path = -1;
    expect_refused(sqmap_make_session(model_, &options, &session_), SQMAP_E_ARGUMENT, "options.side_path");
}

}  // namespace
}  // namespace sqmap
