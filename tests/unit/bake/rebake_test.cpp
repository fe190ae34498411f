#include "sqmap/bake/rebake.h"

#include "model/central_cells.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/named_parts.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/probe.h"
#include "support/baked_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace sqmap::bake {
namespace {

/// The small hand, baked; its largest distance and its tips, the part that reaches farthest from the middle.
struct Hand {
    mesh::Mesh mesh = test::small_hand();
    BakeResult baked = bake(mesh, true, {});
    double r_max = mesh::largest_vertex_distance(mesh);
    std::uint32_t finger = 0;

    Hand()
    {
        Vec3d middle{};
        for (const Vec3d& v : mesh.vertices) middle += v / static_cast<double>(mesh.vertices.size());
        double farthest = 0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            if (const double d = norm(mesh.vertices[mesh.triangles[t][0]] - middle); d > farthest) {
                farthest = d;
                finger = baked.report.partition.part_of_triangle[t];
            }
    }
    static const Hand& get()
    {
        static const Hand k_hand;
        return k_hand;
    }
    /// Vertices of the part moved, those it shares with others not, and less near them.
    std::vector<Vec3d> with_moved(std::uint32_t part, Vec3d by) const
    {
        std::vector<std::uint8_t> own(mesh.vertices.size(), 0), others(own);
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (const std::uint32_t v : mesh.triangles[t])
                (baked.report.partition.part_of_triangle[t] == part ? own : others)[v] = 1;
        std::vector<Vec3d> out = mesh.vertices;
        for (std::size_t v = 0; v < own.size(); ++v) {
            if (own[v] == 0 || others[v] != 0) continue;
            double inwards = INFINITY;
            for (std::size_t o = 0; o < own.size(); ++o)
                if (own[o] != 0 && others[o] != 0) inwards = std::min(inwards, norm(mesh.vertices[o] - mesh.vertices[v]));
            out[v] += std::min(1.0, inwards / (0.2 * r_max)) * by;
        }
        return out;
    }
    mesh::Mesh in_model_space(std::span<const Vec3d> vertices) const
    {
        mesh::Mesh m = mesh;
        for (std::size_t v = 0; v < vertices.size(); ++v)
            m.vertices[v] = cast<double>(model::to_model_space(baked.model.header, vertices[v]));
        return m;
    }
};

/// The model that reading its file gives.
struct Read {
    std::vector<std::byte> bytes;
    model::ModelView view;
    explicit Read(const model::ModelData& data) : bytes(io::serialize(data))
    {
        EXPECT_EQ(model::parse(bytes, view), model::ParseStatus::Ok);
    }
};

template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b)
{
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same_arrays(const model::ModelData& a, const model::ModelData& b)
{
    const auto expect_same = [](const char* name, const auto& x, const auto& y) { EXPECT_TRUE(same(x, y)) << name; };
    model::each_surface_array(expect_same, a, b);
    model::each_cell_array(expect_same, a, b);
    model::BoundArrays<model::ArrayData>::each(expect_same, a, b);
    model::DistanceArrays<model::ArrayData>::each(expect_same, a.distance, b.distance);
}

/// Signed distances about the posed surface, and about where it was before.
void expect_right_distances(const model::ModelView& view, const mesh::Mesh& posed)
{
    const mesh::Solid solid(posed, mesh::find_self_intersections(posed).crossed);
    const double r_max = view.header.r_max, band = static_cast<double>(view.distance.header.band);
    test::Random random(9);
    std::size_t exact = 0;
    for (int i = 0; i < 3000; ++i) {
        const Vec3d on = posed.vertices[random.below(posed.vertices.size())];
        const Vec3d p = on + (i % 3 == 0 ? 0.3 : 0.04) * r_max * random.in_box({-1, -1, -1}, {1, 1, 1});
        const query::SignedDistance a =
            query::distance(view, model::to_mesh_units(view.header, cast<float>(p)), query::k_baked_band);
        const double truth = (solid.inside(p) ? -1 : 1) * solid.closest_boundary(p).distance,
                     found = a.distance / view.header.unit;
        if (std::abs(truth) > 1e-5 * r_max) {
            ASSERT_EQ(found < 0, truth < 0) << truth;
        }
        if (a.known == query::DistanceKind::Exact) {
            ++exact;
            ASSERT_NEAR(found, truth, 1e-5 * r_max);
        } else {
            ASSERT_GT(std::abs(truth), band);
            ASSERT_LE(std::abs(found), std::abs(truth));
            ASSERT_GE(std::abs(found), 0.5 * std::abs(truth));
        }
    }
    EXPECT_GT(exact, 1500u);
}

/// The exact layer is right everywhere, layer 3 beyond half a percent of R_max, points singly and as a frame; every certificate
/// holds, checked afresh; the file is one that a reader accepts.
void expect_right(const model::ModelData& data, const mesh::Mesh& posed)
{
    const mesh::Solid solid(posed, mesh::find_self_intersections(posed).crossed);
    const Read read(data);
    for (const query::Layer layer : {query::Layer::Exact, query::Layer::Three}) {
        EvaluateOptions options;
        options.points = 8000;
        options.layer = layer;
        if (layer == query::Layer::Exact) options.verdict_band = 1e-5;
        const Evaluation e = evaluate(read.view, solid, options);
        EXPECT_GT(e.inside, 1000u);
        EXPECT_EQ(e.missed + e.false_contacts, 0u) << "layer " << static_cast<int>(layer);
        EXPECT_EQ(e.certain_wrong, 0u);
        EXPECT_EQ(e.layer1_missed, 0u);
        EXPECT_LT(e.depth.p99, layer == query::Layer::Exact ? 1e-3 : 0.6);
        if (layer == query::Layer::Exact) {
            EXPECT_LT(e.depth.max, 1e-3);
        }
    }
    expect_right_distances(read.view, posed);
    const Containment containment = check_containment(read.view, posed);
    EXPECT_EQ(containment.certified, data.parts.size());
    EXPECT_EQ(containment.outside, 0u);
}

TEST(Rebake, NothingMovedIsTheSameModel)
{
    const Hand& hand = Hand::get();
    const RebakeResult again = rebake(hand.baked.model, hand.mesh.vertices, {.fineness = hand.baked.report.fineness});
    EXPECT_EQ(again.report.changed_triangles, 0u);
    EXPECT_TRUE(again.report.remade.empty());
    expect_same_arrays(again.model, hand.baked.model);
    EXPECT_EQ(again.model.mesh_hash, hand.baked.model.mesh_hash);
}

TEST(Rebake, AMovedFingerAnswersAsAFullBakeOfItsParts)
{
    const Hand& hand = Hand::get();
    const std::vector<Vec3d> vertices = hand.with_moved(hand.finger, 0.03 * hand.r_max * normalized(Vec3d{1, 2, 1}));
    const RebakeResult again = rebake(hand.baked.model, vertices, {.fineness = hand.baked.report.fineness});
    EXPECT_GT(again.report.changed_triangles, 50u);
    EXPECT_LT(again.report.remade.size(), hand.baked.model.parts.size());
    EXPECT_TRUE(std::find(again.report.remade.begin(), again.report.remade.end(), hand.finger) != again.report.remade.end());
    const mesh::Mesh posed = hand.in_model_space(vertices);
    expect_right(again.model, posed);
    for (std::size_t part = 0; part < again.model.parts.size(); ++part)
        EXPECT_EQ(model::group_of_part(again.model.view(), part), model::group_of_part(hand.baked.model.view(), part));

    // A full bake has a model space and superquadrics of its own; the exact layer depends on neither.
    mesh::Mesh moved = hand.mesh;
    moved.vertices = vertices;
    BakeOptions options;
    options.partition = &hand.baked.report.partition;
    const BakeResult full = bake(moved, true, options);
    const Read a(again.model), b(full.model);
    EvaluateOptions sampling;
    sampling.points = 5000;
    std::size_t contacts = 0;
    for (const Vec3d p : sample_points(posed, again.model.header.r_max, sampling)) {
        const Vec3d in_mesh = model::to_mesh_units(a.view.header, cast<float>(p));
        const query::PointResult x = query::query_point(a.view, in_mesh, {.layer = query::Layer::Exact}),
                                 y = query::query_point(b.view, in_mesh, {.layer = query::Layer::Exact});
        EXPECT_NEAR(x.depth, y.depth, 1e-5 * hand.r_max);
        EXPECT_TRUE(x.contact == y.contact || std::max(x.depth, y.depth) <= 1e-5 * hand.r_max);
        contacts += x.contact ? 1 : 0;
    }
    EXPECT_GT(contacts, 500u);
}

TEST(Rebake, EveryPartInTurnAndBackAgain)
{
    const Hand& hand = Hand::get();
    test::Random random(4);
    model::ModelData model = hand.baked.model;
    for (std::uint32_t part = 0; part < hand.baked.model.parts.size(); ++part) {
        const std::vector<Vec3d> vertices = hand.with_moved(part, 0.02 * hand.r_max * random.direction());
        model = rebake(model, vertices, {.fineness = hand.baked.report.fineness}).model;
        if (part % 3 == 0) expect_right(model, hand.in_model_space(vertices));
    }
    const RebakeResult back = rebake(model, hand.mesh.vertices, {.fineness = hand.baked.report.fineness});
    expect_right(back.model, hand.in_model_space(hand.mesh.vertices));
    EXPECT_TRUE(same(back.model.vertices, hand.baked.model.vertices));
}

bool same_map(const model::ModelData& x, const model::Part& a, const model::ModelData& y, const model::Part& b)
{
    bool same_bytes = true;
    const auto compare = [&](const char*, const auto& of_a, const auto& of_b) {
        same_bytes = same_bytes && of_a.size() == of_b.size() && std::memcmp(of_a.data(), of_b.data(), of_a.size_bytes()) == 0;
    };
    const auto arrays_a = model::arrays_of(x, a), arrays_b = model::arrays_of(y, b);
    model::CentralArrays<model::ArrayView>::each(compare, arrays_a, arrays_b);
    return same_bytes;
}

TEST(Rebake, MapsOfNeighboursAreAgainAsBakedWhenAllIsBack)
{
    const Hand& hand = Hand::get();
    const model::ModelData& baked = hand.baked.model;
    const RebakeOptions options{.fineness = hand.baked.report.fineness};
    std::size_t followed = 0;
    // Every other part: most of the parts are made again with a neighbour.
    for (std::uint32_t moved = 0; moved < baked.parts.size(); moved += 2) {
        const std::vector<Vec3d> vertices = hand.with_moved(moved, 0.02 * hand.r_max * normalized(Vec3d{1, 2, 1}));
        const RebakeResult there = rebake(baked, vertices, options);
        const RebakeResult back = rebake(there.model, hand.mesh.vertices, options);
        for (const std::uint32_t i : there.report.remade) {
            const model::Part &was = baked.parts[i], &is = there.model.parts[i], &again = back.model.parts[i];
            // In the same chart, with the same range of depths.
            if (std::memcmp(was.chart_rows, is.chart_rows, sizeof was.chart_rows) != 0 ||
                std::memcmp(was.chart_lo, is.chart_lo, sizeof was.chart_lo) != 0 ||
                std::memcmp(was.translation, is.translation, sizeof was.translation) != 0 || was.w_min != is.w_min ||
                was.w_step != is.w_step || std::memcmp(was.chart_centre, is.chart_centre, sizeof was.chart_centre) != 0)
                continue;
            // A triangle that moved may come near a chart and be in none of its cells.
            if (same_map(baked, was, there.model, is)) continue;
            ++followed;
            EXPECT_TRUE(same_map(baked, was, back.model, again)) << "part " << i << " with part " << moved;
        }
    }
    EXPECT_GE(followed, baked.parts.size());
}

TEST(Rebake, WhatLeavesTheGridGetsBricks)
{
    const Hand& hand = Hand::get();
    Vec3d middle{};
    for (const Vec3d& v : hand.mesh.vertices) middle += v / static_cast<double>(hand.mesh.vertices.size());
    for (const double by : {-0.5, 0.5}) {
        std::vector<Vec3d> vertices = hand.mesh.vertices;
        for (Vec3d& v : vertices) v += by * std::max(0.0, norm(v - middle) / hand.r_max - 0.3) * hand.r_max * Vec3d{1, 1, 1};
        const RebakeResult again = rebake(hand.baked.model, vertices, {.fineness = hand.baked.report.fineness});
        EXPECT_GT(again.model.bricks.size(), hand.baked.model.bricks.size());
        expect_right(again.model, hand.in_model_space(vertices));
    }
}

TEST(Rebake, ASurfaceThatComesToCrossItselfAndPartsAgain)
{
    // A bar pushed into another, out of both sides, and drawn back.
    const mesh::Mesh bars = test::together(test::mapped(test::cube_of({2, 0.5, 0.5}), 1, {0, 0, 0}),
                                           test::mapped(test::cube_of({0.3, 1, 0.3}), 1, {0.2, 2.5, 0.1}));
    const BakeResult baked = bake(bars, true, {});
    const auto lowered = [&](double by) {
        std::vector<Vec3d> vertices = bars.vertices;
        for (Vec3d& v : vertices)
            if (v.y > 1) v.y -= by;
        return vertices;
    };
    model::ModelData model = baked.model;
    for (const double by : {0.5, 1.3, 2.45, 0.0}) {
        const std::vector<Vec3d> vertices = lowered(by);
        model = rebake(model, vertices, {.fineness = baked.report.fineness}).model;
        mesh::Mesh posed = bars;
        for (std::size_t v = 0; v < vertices.size(); ++v)
            posed.vertices[v] = cast<double>(model::to_model_space(baked.model.header, vertices[v]));
        EXPECT_EQ(model.header.self_intersecting != 0, by > 1);
        const mesh::Solid solid(posed, mesh::find_self_intersections(posed).crossed);
        EvaluateOptions options;
        options.layer = query::Layer::Exact;
        options.verdict_band = 1e-5;
        options.points = 8000;
        const Read read(model);
        const Evaluation e = evaluate(read.view, solid, options);
        EXPECT_EQ(e.missed + e.false_contacts, 0u) << "lowered by " << by;
        EXPECT_LT(e.depth.max, 1e-3) << "lowered by " << by;
    }
}

TEST(Rebake, ThreadsDoNotMatter)
{
    const Hand& hand = Hand::get();
    const std::vector<Vec3d> vertices = hand.with_moved(hand.finger, {0, 0.02 * hand.r_max, 0});
    const model::ModelData one = rebake(hand.baked.model, vertices, {.threads = 1}).model;
    expect_same_arrays(one, rebake(hand.baked.model, vertices, {.threads = 3}).model);
}

TEST(Rebake, WhatItCannotStartFromIsRefused)
{
    const Hand& hand = Hand::get();
    std::vector<Vec3d> vertices = hand.mesh.vertices;
    EXPECT_THROW((void)rebake(hand.baked.model, std::span(vertices).first(3)), mesh::InvalidInput);
    vertices[7].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)rebake(hand.baked.model, vertices), mesh::InvalidInput);
    BakeOptions without;
    without.exact = false;
    EXPECT_THROW((void)rebake(bake(test::cube(), true, without).model, test::cube().vertices), mesh::InvalidInput);
}

}  // namespace
}  // namespace sqmap::bake
