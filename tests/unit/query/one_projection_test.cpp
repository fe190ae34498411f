#include "sqmap/bake/skin_lattice.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/point.h"
#include "sqmap/query/scene.h"
#include "sqmap/query/skin.h"
#include "sqmap/query/swept.h"
#include "support/bodies.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>

namespace sqmap::query {
namespace {

constexpr std::array k_layers{Layer::One, Layer::Two, Layer::Three, Layer::Gate};

/// A normal model, and the same one with all that a central model of another solid has beside it: a path that looks there
/// answers differently.
struct Misled {
    const mesh::Mesh mesh = test::small_hand();
    const test::Parsed normal{mesh, true, {.projection = model::Projection::Normal, .exact = false}};
    const test::Parsed other{mesh::sphere(0.4, 4)};
    model::ModelView alone = normal.view(), misled = normal.view();
    std::vector<model::Part> parts;

    Misled()
    {
        const model::ModelView& wrong = other.view();
        for (model::Part part : alone.parts) {
            const model::Part& from = wrong.parts.front();
            std::memcpy(part.chart_rows, from.chart_rows, sizeof part.chart_rows);
            std::memcpy(part.chart_centre, from.chart_centre, sizeof part.chart_centre);
            std::memcpy(part.chart_lo, from.chart_lo, sizeof part.chart_lo);
            std::memcpy(part.chart_hi, from.chart_hi, sizeof part.chart_hi);
            part.w_min = from.w_min;
            part.w_step = from.w_step;
            part.base = from.base;
            part.flags = from.flags;
            part.centre_winding = from.centre_winding;
            part.sample_count = from.sample_count;
            part.cell_count = from.cell_count;
            part.block_count = from.block_count;
            part.split_count = from.split_count;
            part.special_count = from.special_count;
            part.pool_count = from.pool_count;
            parts.push_back(part);
        }
        static_cast<model::CentralArrays<model::ArrayView>&>(misled) = wrong;
        static_cast<model::LocatorArrays<model::ArrayView>&>(misled) = wrong;
        misled.parts = parts;
    }
    static const Misled& get()
    {
        static const Misled k_misled;
        return k_misled;
    }
};

void expect_same(const PointResult& a, const PointResult& b)
{
    EXPECT_EQ(a.contact, b.contact);
    EXPECT_EQ(a.certain, b.certain);
    EXPECT_EQ(a.status, b.status);
    EXPECT_EQ(a.part, b.part);
    EXPECT_EQ(a.depth, b.depth);
    EXPECT_EQ(a.point, b.point);
    EXPECT_EQ(a.normal, b.normal);
}

void expect_same(std::span<const Contact> a, std::span<const Contact> b)
{
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(a[i].point, b[i].point);
        EXPECT_EQ(a[i].normal, b[i].normal);
        EXPECT_EQ(a[i].depth, b[i].depth);
        EXPECT_EQ(a[i].index, b[i].index);
        EXPECT_EQ(a[i].part, b[i].part);
        EXPECT_EQ(a[i].certain, b[i].certain);
        EXPECT_EQ(a[i].status, b[i].status);
    }
}

std::vector<Vec3d> points_about(const model::ModelView& view, std::size_t count)
{
    test::Random random(71);
    const Vec3d centre = model::to_mesh_units(view.header, model::vec3(view.header.sphere));
    const double reach = static_cast<double>(view.header.sphere[3]) * view.header.unit;
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < count; ++i) points.push_back(centre + reach * random.in_box({-1, -1, -1}, {1, 1, 1}));
    return points;
}

TEST(OneProjection, AnsweringPointsFromAnotherStructureShows)
{
    const Misled& m = Misled::get();
    std::size_t contacts = 0;
    for (const Layer layer : k_layers)
        for (const bool offset : {false, true})
            for (const bool smoothing : {false, true})
                for (const Vec3d& p : points_about(m.alone, 1500)) {
                    const QueryOptions options{.layer = layer, .offset = offset, .smoothing = smoothing};
                    const PointResult point = query_point(m.alone, p, options);
                    expect_same(point, query_point(m.misled, p, options));
                    contacts += point.contact ? 1u : 0u;
                }
    EXPECT_GT(contacts, 500u);
    for (std::uint32_t part = 0; part < m.alone.parts.size(); ++part)
        for (const Vec3d& p : points_about(m.alone, 200))
            EXPECT_EQ(distance_along_projection(m.alone, part, p, Layer::Three),
                      distance_along_projection(m.misled, part, p, Layer::Three));
}

TEST(OneProjection, AnsweringProbesFromAnotherStructureShows)
{
    const Misled& m = Misled::get();
    const std::vector<Vec3d> points = points_about(m.alone, 3000);
    const Probe probe(points);
    std::vector<Contact> contacts(points.size()), misled(points.size());
    test::Random random(72);
    std::size_t total = 0;
    for (int i = 0; i < 8; ++i) {
        const Pose pose = test::random_pose(random, 0.1);
        for (const Layer layer : k_layers)
            for (const bool offset : {false, true}) {
                const QueryOptions options{.layer = layer, .offset = offset};
                const ProbeResult a = query_probe({.model = &m.alone}, {.probe = &probe, .pose = pose}, options, contacts);
                const ProbeResult b = query_probe({.model = &m.misled}, {.probe = &probe, .pose = pose}, options, misled);
                expect_same(a.written(contacts), b.written(misled));
                EXPECT_EQ(a.status, b.status);
                EXPECT_EQ(a.unseen, b.unseen);
                total += a.contacts;
            }
    }
    EXPECT_GT(total, 1000u);
}

TEST(OneProjection, AnsweringPairsAndScenesFromAnotherStructureShows)
{
    const Misled& m = Misled::get();
    const Probe probe(m.mesh.vertices);
    PairWorkspace workspace(8192);
    test::Random random(73);
    std::size_t total = 0;
    for (int i = 0; i < 6; ++i) {
        const Pose pose = test::random_pose(random, 0.2);
        const auto pair = [&](const model::ModelView& view) {
            const PairResult r = query_pair({&view, &probe, {}}, {&view, &probe, pose}, {}, workspace);
            return std::vector<PairContact>(r.contacts.begin(), r.contacts.end());
        };
        const auto scene = [&](const model::ModelView& view) {
            Scene bodies;
            (void)bodies.add(&view, &probe);
            (void)bodies.add(&view, &probe, pose);
            std::vector<ScenePair> pairs(4);
            std::vector<PairContact> contacts(8192);
            contacts.resize(bodies.query_pairs({}, pairs, contacts).contacts);
            return contacts;
        };
        for (const auto& [alone, misled] :
             {std::pair(pair(m.alone), pair(m.misled)), std::pair(scene(m.alone), scene(m.misled))}) {
            ASSERT_EQ(alone.size(), misled.size());
            for (std::size_t k = 0; k < alone.size(); ++k) {
                EXPECT_EQ(alone[k].witness.on_a, misled[k].witness.on_a);
                EXPECT_EQ(alone[k].witness.on_b, misled[k].witness.on_b);
                EXPECT_EQ(alone[k].normal, misled[k].normal);
                EXPECT_EQ(alone[k].depth, misled[k].depth);
            }
            total += alone.size();
        }
    }
    EXPECT_GT(total, 100u);
}

TEST(OneProjection, AnsweringSweptProbesFromAnotherStructureShows)
{
    const Misled& m = Misled::get();
    const std::vector<Vec3d> points = points_about(m.alone, 2000);
    Probe probe(points);
    SweptWorkspace workspace(probe);
    std::vector<Contact> contacts(points.size()), misled(points.size());
    const Pose to = test::shifted({0.05, 0.02, 0});
    const auto sweep = [&](const model::ModelView& view, std::span<Contact> found) {
        return query_swept({{.model = &view}, &probe, {}, to, points, points}, {.step = 0.01}, workspace, found).probe;
    };
    const ProbeResult a = sweep(m.alone, contacts), b = sweep(m.misled, misled);
    EXPECT_GT(a.contacts, 50u);
    expect_same(a.written(contacts), b.written(misled));
}

TEST(OneProjection, AnsweringSkinsFromAnotherStructureShows)
{
    const Misled& m = Misled::get();
    mesh::Influences influences;
    for (std::size_t i = 0; i < m.mesh.vertices.size(); ++i) {
        influences.joints.push_back({0, 1, 0, 0});
        influences.weights.push_back({0.5, 0.5, 0, 0});
    }
    const SkinLattice lattice = bake::skin_lattice(m.mesh, influences);
    PosedSkin skin(lattice);
    const std::array<Affine, 2> maps{Affine{}, Affine{{}, {0.03, 0, 0}}};
    ASSERT_TRUE(skin.pose(maps));
    const std::vector<Vec3d> points = points_about(m.alone, 2000);
    SkinWorkspace workspace(lattice, points);
    std::vector<SkinContact> contacts(points.size()), misled(points.size());
    const ProbeResult a = query_skin({&m.alone, &skin, points, {}}, {}, workspace, contacts);
    const ProbeResult b = query_skin({&m.misled, &skin, points, {}}, {}, workspace, misled);
    ASSERT_EQ(a.contacts, b.contacts);
    EXPECT_GT(a.contacts, 50u);
    for (std::size_t i = 0; i < a.contacts; ++i) {
        EXPECT_EQ(contacts[i].point, misled[i].point);
        EXPECT_EQ(contacts[i].depth, misled[i].depth);
    }
}

TEST(OneProjection, DistancesOfANormalModelAreItsTrianglesOrNone)
{
    const Misled& m = Misled::get();
    EXPECT_FALSE(model::has_distance(m.alone));
    for (const Vec3d& p : points_about(m.alone, 200)) {
        const SignedDistance a = distance(m.alone, p), b = distance(m.misled, p);
        EXPECT_EQ(a.distance, b.distance);
        EXPECT_EQ(a.known, DistanceKind::LowerBound);
        EXPECT_NE(a.status & k_not_given, 0);
    }
}

TEST(OneProjection, WhatAProjectionCannotGiveIsAStatusBit)
{
    const Misled& m = Misled::get();
    const PointResult point = query_point(m.alone, {}, {.margin = 0.1});
    EXPECT_NE(point.status & k_not_given, 0);
    const Probe probe(points_about(m.alone, 100));
    std::vector<Contact> contacts(100);
    EXPECT_NE(query_probe({.model = &m.alone}, {.probe = &probe}, {.margin = 0.1}, contacts).status & k_not_given, 0);
    EXPECT_EQ(query_probe({.model = &m.alone}, {.probe = &probe}, {}, contacts).status & k_not_given, 0);
    EXPECT_EQ(query_probe({.model = &m.other.view()}, {.probe = &probe}, {.margin = 0.1}, contacts).status & k_not_given, 0);
}

TEST(OneProjection, ANormalModelHoldsNoOtherMaps)
{
    const model::ModelView& alone = Misled::get().alone;
    EXPECT_EQ(model::bytes_of<model::CentralArrays<model::ArrayView>>(alone), 0u);
    EXPECT_EQ(model::bytes_of<model::LocatorArrays<model::ArrayView>>(alone), 0u);
    const test::Parsed exact(test::small_torus(), true, {.projection = model::Projection::Normal});
    EXPECT_EQ(model::bytes_of<model::CentralArrays<model::ArrayView>>(exact.view()), 0u);
    EXPECT_TRUE(exact.view().planes.empty());
    EXPECT_TRUE(exact.view().seeds.empty());
    EXPECT_TRUE(exact.view().part_lists.empty());
    EXPECT_TRUE(model::has_exact(exact.view()));
}

// The cells of a normal model lead to the same triangles as those of a central one.
TEST(OneProjection, TheExactLayerIsThatOfACentralModel)
{
    const test::Parsed normal(test::small_torus(), true, {.projection = model::Projection::Normal}), central(test::small_torus());
    const std::vector<Vec3d> points = points_about(central.view(), 3000);
    const Probe probe(points);
    std::vector<Contact> a(points.size()), b(points.size());
    const ProbeResult of_normal = query_probe({.model = &normal.view()}, {.probe = &probe}, {.layer = Layer::Exact}, a);
    const ProbeResult of_central = query_probe({.model = &central.view()}, {.probe = &probe}, {.layer = Layer::Exact}, b);
    ASSERT_EQ(of_normal.contacts, of_central.contacts);
    EXPECT_GT(of_normal.contacts, 100u);
    const auto by_index = [](const Contact& x, const Contact& y) { return x.index < y.index; };
    std::sort(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(of_normal.contacts), by_index);
    std::sort(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(of_central.contacts), by_index);
    for (std::size_t i = 0; i < of_normal.contacts; ++i) {
        EXPECT_EQ(a[i].index, b[i].index);
        EXPECT_NEAR(a[i].depth, b[i].depth, 1e-6);
    }
}

}  // namespace
}  // namespace sqmap::query
