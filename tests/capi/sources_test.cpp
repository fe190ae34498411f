// Numbers of triangles and vertices that the C interface names are those of the mesh that was given.
#include "capi/fixture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <random>
#include <vector>

namespace sqmap {
namespace {

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
    const mesh::Mesh meshes[] = {mesh::sphere(1e-3, 2),
                                 mesh::ellipsoid({3, 1, 0.5}, 2),
                                 mesh::rounded_box({1, 1, 1}, 0.1, 1),
                                 mesh::torus({.minor_radius = 0.7, .major_segments = 16, .minor_segments = 10}),
                                 mesh::dumbbell({.segments = 10}),
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
            options.target_error = 5;  // maps and superquadrics answer nothing here
            options.max_parts = 1;
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

}  // namespace
}  // namespace sqmap
