#include "bake/bake.h"

#include "model/central_map.h"
#include "sqmap/io/model_file.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/self_intersection.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/model/named_parts.h"
#include "sqmap/query/point.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <string>
#include <thread>
#include <utility>

namespace sqmap::bake {
namespace {

struct BakedShape {
    BakedShape(std::string of, const mesh::Mesh& mesh) : name(std::move(of)), baked(mesh) {}
    std::string name;
    test::Parsed baked;
};

/// Shapes of our own and a camel.
const std::deque<BakedShape>& shapes_and_shared()
{
    static const std::deque<BakedShape> all = [] {
        std::deque<BakedShape> out;
        for (const test::Shape& shape : test::small_shapes()) out.emplace_back(shape.name, shape.mesh);
        if (const auto mesh = test::shared_mesh("camel_4512.obj")) out.emplace_back("camel", *mesh);
        return out;
    }();
    if (all.back().name != "camel") test::skip_without("camel_4512.obj");
    return all;
}

/// The torus by default options, for all tests that compare it with another.
const BakeResult& baked_torus()
{
    static const BakeResult baked = bake(test::small_torus(), true, {});
    return baked;
}

std::vector<std::byte> bytes_of(const mesh::Mesh& mesh, const BakeOptions& options = {})
{
    return io::serialize(bake(mesh, true, options).model);
}

bool held(const model::ModelView& view, Vec3d p)
{
    return std::any_of(view.parts.begin(), view.parts.end(), [&](const model::Part& part) {
        return shape::implicit(model::superquadric_of(part), cast<float>(p)) <= 1.f;
    });
}

TEST(Bake, EveryPointOfTheSolidLiesInASuperquadric)
{
    test::Random random(1);
    for (const auto& [name, b] : shapes_and_shared()) {
        const model::ModelView view = b.view();
        const mesh::Solid& solid = b.solid();
        const double r = view.header.sphere[3];
        int inside = 0;
        for (int i = 0; i < 6000; ++i) {
            const Vec3d p = cast<double>(
                cast<float>(cast<double>(model::vec3(view.header.sphere)) + r * random.in_box({-1, -1, -1}, {1, 1, 1})));
            if (!solid.inside(p)) continue;
            ++inside;
            ASSERT_TRUE(held(view, p)) << name << " at " << p.x << ' ' << p.y << ' ' << p.z;
        }
        EXPECT_GT(inside, 50) << name;
    }
}

void expect_every_triangle_held(const model::ModelView& view, const mesh::Mesh& mesh)
{
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const model::Part& part = view.parts[model::part_of_triangle(view, t)];
        EXPECT_LE(part.largest_f, 1.f);
        const shape::Superquadricf sq = model::superquadric_of(part);
        const Vec3d a = mesh.vertices[mesh.triangles[t][0]], u = mesh.vertices[mesh.triangles[t][1]] - a,
                    v = mesh.vertices[mesh.triangles[t][2]] - a;
        for (int i = 0; i <= 4; ++i)
            for (int j = 0; i + j <= 4; ++j)
                ASSERT_LE(shape::implicit(sq, cast<float>(a + 0.25 * i * u + 0.25 * j * v)), 1.f) << "triangle " << t;
    }
}

TEST(Bake, EveryTriangleLiesInItsPartsSuperquadric)
{
    for (const auto& [name, b] : shapes_and_shared()) {
        SCOPED_TRACE(name);
        expect_every_triangle_held(b.view(), b.mesh());
    }
}

/// For every crossing of a ray from the chart's centre: the map must hold it in its band, and the pyramid in its block.
TEST(Bake, NoCrossingEscapesTheCertifiedBands)
{
    test::Random random(2);
    for (const auto& [name, b] : shapes_and_shared()) {
        const model::ModelView view = b.view();
        const mesh::Bvh bvh(b.mesh());
        std::vector<mesh::Bvh::Crossing> crossings;
        std::size_t checked = 0;
        for (std::size_t index = 0; index < view.parts.size(); ++index) {
            const model::Part& part = view.parts[index];
            const model::CentralMap map(view, part);
            const Vec3d centre = cast<double>(model::vec3(part.chart_centre));
            for (int i = 0; i < 1500; ++i) {
                const Vec3d d = random.direction();
                if (!bvh.ray_crossings(centre, d, crossings)) continue;
                for (const mesh::Bvh::Crossing& c : crossings) {
                    // Faces that are no boundary of the solid change no verdict and have no place in the bands.
                    if (model::is_buried(view.triangle_part[c.triangle])) continue;
                    const Vec3f x = map.to_chart_frame(cast<float>(centre + c.t * d));
                    if (!map.in_domain(x)) continue;
                    ++checked;
                    const model::ChartPoint q = model::to_chart(x);
                    const model::Leaf leaf = map.leaf_at(q.face, q.s, q.t);
                    ASSERT_GT(leaf.sheets + (leaf.kind == model::CellKind::Layered ? 1 : 0), 0)
                        << name << ": a surface in a uniform cell";
                    float lo, hi;
                    model::leaf_band(leaf, lo, hi);
                    // The point itself is rounded to float in model space: the smaller the part, the more it moves.
                    const float least = std::min(std::min(part.a[0], part.a[1]), part.a[2]);
                    const float hair = 2e-6f * q.w + 2.4e-7f / least * q.w * q.w;
                    ASSERT_GE(q.w, lo - hair) << name;
                    ASSERT_LE(q.w, hi + hair) << name;
                    if (model::part_of_triangle(view, c.triangle) != index) continue;  // blocks hold the own surface
                    const model::Block block =
                        map.block(q.face, map.column_of(q.s) / model::k_block, map.column_of(q.t) / model::k_block);
                    ASSERT_GE(q.w, map.decode(block.lo) - hair) << name;
                    ASSERT_LE(q.w, map.decode(block.hi) + hair) << name;
                }
            }
        }
        EXPECT_GT(checked, 1000u) << name;
    }
}

/// Both sides of a silhouette are seen from the chart's centre, and each has crossings that the other lacks.
TEST(Bake, ADividedCellKnowsTheSheetsOfBothSidesOfItsSilhouette)
{
    test::Random random(3);
    const test::Baked b = test::baked(test::small_torus());
    const model::ModelView view = b.view();
    const mesh::Bvh bvh(b.mesh);
    std::vector<mesh::Bvh::Crossing> crossings;
    std::size_t rays = 0;
    double with_side = 0, with_other = 0;
    for (const model::Part& part : view.parts) {
        const model::CentralMap map(view, part);
        const Vec3d centre = cast<double>(model::vec3(part.chart_centre));
        for (int i = 0; i < 60000; ++i) {
            const Vec3d d = random.direction();
            if (!bvh.ray_crossings(centre, d, crossings)) continue;
            for (const mesh::Bvh::Crossing& c : crossings) {
                const Vec3f x = map.to_chart_frame(cast<float>(centre + c.t * d));
                if (!map.in_domain(x)) continue;
                const model::ChartPoint q = model::to_chart(x);
                const model::Leaf leaf = map.leaf_at(q.face, q.s, q.t);
                if (!leaf.divided) continue;
                EXPECT_GE(model::side_of_line(leaf, q.s, q.t), 0.f);
                const auto error = [&](const model::Leaf& side) {
                    double least = c.t;
                    for (int j = 0; j < side.sheets; ++j)
                        least = std::min(least,
                                         std::abs(static_cast<double>(q.w / model::sheet_value(side, j, q.s, q.t).w) - 1) * c.t);
                    return least;
                };
                ++rays;
                with_side += error(leaf);
                const auto add = [&](const model::Leaf& side) {
                    if (side.record == leaf.record && side.planes != leaf.planes) with_other += error(side);
                };
                map.each_leaf(q.face, map.column_of(q.s), map.column_of(q.t), add, [](const auto&...) { return true; });
            }
        }
    }
    ASSERT_GT(rays, 100u);
    EXPECT_LT(with_side, 0.25 * with_other);
}

/// Queries look for the nearest point of each side of a divided cell by itself.
TEST(Bake, WhatIsKeptInADividedLeafLiesOnItsSide)
{
    test::Random random(4);
    for (int i = 0; i < 2000; ++i) {
        model::Leaf leaf;
        leaf.size = 0.25f;
        leaf.divided = true;
        const model::BorderPoint from = model::border_point(random.below(256)), to = model::border_point(random.below(256));
        leaf.from[0] = leaf.size * from.u;
        leaf.from[1] = leaf.size * from.v;
        leaf.to[0] = leaf.size * to.u;
        leaf.to[1] = leaf.size * to.v;
        auto s = static_cast<float>(random.between(-0.5, 0.5)), t = static_cast<float>(random.between(-0.5, 0.5));
        const float s_before = s, t_before = t;
        model::keep_in_leaf(leaf, s, t);
        EXPECT_GE(model::side_of_line(leaf, s, t), -1e-6f);
        EXPECT_TRUE(s >= 0.f && s <= leaf.size && t >= 0.f && t <= leaf.size);
        if (model::side_of_line(leaf, s_before, t_before) >= 0.f && s_before >= 0.f && s_before <= leaf.size && t_before >= 0.f &&
            t_before <= leaf.size) {
            EXPECT_EQ(s, s_before);
            EXPECT_EQ(t, t_before);
        }
    }
}

TEST(Bake, TwiceAndOnAnyNumberOfThreadsGivesTheSameBytes)
{
    const std::vector<std::byte> torus = io::serialize(baked_torus().model), hand = bytes_of(test::small_hand(), {.threads = 1});
    for (const unsigned threads : {1, 3}) EXPECT_EQ(torus, bytes_of(test::small_torus(), {.threads = threads})) << threads;
    EXPECT_EQ(hand, bytes_of(test::small_hand(), {.threads = 7}));
}

TEST(Bake, ProgressComesFromTheCallingThreadAndGoesThroughTheStages)
{
    BakeOptions options;
    options.threads = 3;
    const std::thread::id caller = std::this_thread::get_id();
    std::vector<std::string> stages;
    options.progress = [&](const char* stage, double done) {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        EXPECT_GE(done, 0);
        EXPECT_LE(done, 1);
        if (stages.empty() || stages.back() != stage) stages.emplace_back(stage);
    };
    (void)bake(test::small_torus(), true, options);
    ASSERT_GE(stages.size(), 4u);
    EXPECT_EQ(stages[0], "decompose");
    EXPECT_EQ(stages[1], "fit");
    EXPECT_EQ(stages[2], "map");
}

TEST(Bake, OrderOfFacesAndVerticesDoesNotMatter)
{
    const mesh::Mesh mesh = mesh::canonicalized(test::small_hand());
    test::Random random(4);
    std::vector<std::uint32_t> rank(mesh.vertices.size());
    std::iota(rank.begin(), rank.end(), 0u);
    for (std::size_t i = rank.size(); i > 1; --i) std::swap(rank[i - 1], rank[random.below(i)]);
    mesh::Mesh shuffled;
    shuffled.vertices.resize(mesh.vertices.size());
    for (std::size_t v = 0; v < rank.size(); ++v) shuffled.vertices[rank[v]] = mesh.vertices[v];
    for (const mesh::Triangle& t : mesh.triangles) {
        const std::size_t turn = random.below(3);
        shuffled.triangles.push_back({rank[t[turn]], rank[t[(turn + 1) % 3]], rank[t[(turn + 2) % 3]]});
    }
    for (std::size_t i = shuffled.triangles.size(); i > 1; --i)
        std::swap(shuffled.triangles[i - 1], shuffled.triangles[random.below(i)]);
    EXPECT_EQ(bytes_of(mesh), bytes_of(mesh::canonicalized(shuffled)));
}

TEST(Bake, APowerOfTwoInScaleGivesTheSameParts)
{
    const BakeResult& plain = baked_torus();
    for (const double scale : {0x1p-20, 0x1p10}) {
        const BakeResult scaled = bake(test::mapped(test::small_torus(), scale, {}), true, {});
        EXPECT_EQ(plain.report.partition.part_of_triangle, scaled.report.partition.part_of_triangle) << scale;
        EXPECT_EQ(plain.model.samples, scaled.model.samples) << scale;
        EXPECT_EQ(scaled.model.header.unit, scale * plain.model.header.unit);
    }
}

TEST(Bake, TurningTheMeshGivesTheSamePartsOn99PercentOfTheArea)
{
    const auto horse = test::shared_mesh("horse_5946.obj");
    if (!horse) GTEST_SKIP() << "the shared meshes are not here";
    const BakeOptions options{.exact = false};
    const BakeResult straight = bake(*horse, true, options);
    test::Random random(5);
    // A rotation about a random direction by an angle with no relation to the axes.
    const Vec3d u = random.direction();
    const double angle = random.between(0.3, 2.8), c = std::cos(angle), s = std::sin(angle);
    mesh::Mesh turned = *horse;
    for (Vec3d& v : turned.vertices) v = c * v + s * cross(u, v) + (1 - c) * dot(u, v) * u;
    const mesh::Mesh sorted = mesh::canonicalized(turned);
    const BakeResult result = bake(sorted, true, options);
    ASSERT_EQ(result.report.parts.size(), straight.report.parts.size());
    double same = 0, all = 0;
    for (std::size_t i = 0; i < straight.report.parts.size(); ++i) {
        // Parts come in order of area, so equal partitions have equal areas in order.
        same += std::min(straight.report.parts[i].area, result.report.parts[i].area);
        all += straight.report.parts[i].area;
    }
    EXPECT_GT(same, 0.99 * all);
}

// A relaxed hand: a palm, and fingers that bend at their joints are cut there.
TEST(Bake, AHandHasItsFingersAndPhalanges)
{
    const mesh::Mesh hand = mesh::polygonized(mesh::hand_capsules(), 0.0312);  // as sqmap shapes writes it
    EXPECT_EQ(mesh::find_self_intersections(hand).pair_count, 0u);
    const BakeResult baked = bake(hand, true, {.exact = false});
    EXPECT_GE(baked.report.parts.size(), 10u);
    EXPECT_LE(baked.report.parts.size(), 22u);
}

/// The named part of each triangle; parts are numbered by area, which the cuts of the fit change, so names are numbered anew.
std::vector<std::uint32_t> names_of(const BakeResult& baked)
{
    std::map<std::uint32_t, std::uint32_t> number;
    std::vector<std::uint32_t> names;
    for (const std::uint32_t part : baked.report.partition.part_of_triangle) {
        const std::uint32_t group = model::group_of_part(baked.model.view(), part);
        names.push_back(number.try_emplace(group, static_cast<std::uint32_t>(number.size())).first->second);
    }
    return names;
}

TEST(Bake, NamesDoNotDependOnHowTightBoundsHaveToBe)
{
    const mesh::Mesh hand = mesh::polygonized(mesh::hand_capsules(), 0.05);
    const BakeOptions loose{.max_looseness = 1e6, .max_q2_share = 1, .exact = false, .locator = false};
    BakeOptions tight = loose;
    tight.max_looseness = 1.3;
    const BakeResult few = bake(hand, true, loose), many = bake(hand, true, tight);
    EXPECT_GT(many.report.parts.size(), few.report.parts.size());
    EXPECT_EQ(names_of(many), names_of(few));
}

/// Cubes in each other, every second one a cavity: sheets that hide each other, and a target that finer cells do not reach.
mesh::Mesh nested_cubes(int count)
{
    mesh::Mesh mesh;
    for (int i = 0; i < count; ++i) {
        const double half = 1 - 0.2 * i;
        mesh::Mesh cube = test::cube_of({half, half, half});
        for (mesh::Triangle& t : cube.triangles)
            if (i % 2 == 1) std::swap(t[1], t[2]);
        mesh = test::together(mesh, cube);
    }
    return mesh;
}

TEST(Bake, RefinementEndsWhereFinerCellsDoNotHelpAndReportsWhatItKept)
{
    const mesh::Mesh mesh = nested_cubes(4);
    const BakeResult baked = bake(mesh, true, {.exact = false});
    ASSERT_GT(baked.model.measured.eq35_p99, 0.45) << "the target was met";
    const io::SectionBytes bytes = io::section_bytes(baked.model.view(), io::serialize(baked.model).size());
    std::size_t reported = 0;
    for (std::size_t i = 0; i < baked.report.parts.size(); ++i) {
        EXPECT_EQ(baked.report.parts[i].base, baked.model.parts[i].base);
        reported += baked.report.parts[i].map_bytes;
    }
    EXPECT_NEAR(static_cast<double>(reported), static_cast<double>(bytes.map), 0.02 * static_cast<double>(bytes.map));
    EXPECT_LT(bytes.total, 2.5e6) << "for 48 triangles";
}

TEST(Bake, OptionsOutOfRangeAreRefused)
{
    const mesh::Mesh mesh = test::small_sphere();
    for (const double target : {0.0, -1.0, std::nan("")}) {
        BakeOptions options;
        options.target_error = target;
        EXPECT_THROW((void)bake(mesh, true, options), mesh::InvalidInput) << target;
    }
    for (const std::uint32_t parts : {0u, 1001u, 0xffffffffu}) {
        BakeOptions options;
        options.max_parts = parts;
        EXPECT_THROW((void)bake(mesh, true, options), mesh::InvalidInput) << parts;
    }
}

TEST(Bake, WithoutTheExactLayerIsSmallerAndSaysSo)
{
    BakeOptions options;
    options.exact = false;
    const BakeResult &full = baked_torus(), lean = bake(test::small_torus(), true, options);
    const auto sections = [](const BakeResult& baked) {
        return io::section_bytes(baked.model.view(), io::serialize(baked.model).size());
    };
    const io::SectionBytes of_full = sections(full), of_lean = sections(lean);
    EXPECT_GT(of_full.exact, 0u);
    EXPECT_GT(of_full.mesh, 0u);
    EXPECT_EQ(of_lean.exact, 0u);
    EXPECT_EQ(of_lean.mesh, 0u);
    // All that goes is what went, and a little more where a base grid is cheaper without its lists; alignment aside. Distances
    // are kept in another form.
    const auto gone = static_cast<double>(of_full.total - of_lean.total),
               went = static_cast<double>(of_full.exact + of_full.mesh + of_full.input) + static_cast<double>(of_full.distance) -
                      static_cast<double>(of_lean.distance);
    EXPECT_GE(gone, went - 64);
    EXPECT_LE(gone, 1.02 * went + 64);
    EXPECT_FALSE(model::has_exact(lean.model.view()));
    const Vec3d p = model::to_mesh_units(lean.model.view().header, model::vec3(lean.model.parts[0].chart_centre));
    EXPECT_EQ(query::query_point(full.model.view(), p, {.layer = query::Layer::Exact}).status, query::k_ok);
    const query::PointResult c = query::query_point(lean.model.view(), p, {.layer = query::Layer::Exact});
    EXPECT_EQ(c.status, query::k_no_exact);
    EXPECT_TRUE(c.contact);
    EXPECT_EQ(c.depth, query::query_point(lean.model.view(), p).depth);
}

TEST(BakeOfManyTriangles, ItsPartsAreHeldItsTargetIsMetAndItsBytesAreTheSameOnAnyNumberOfThreads)
{
    const mesh::Mesh fine = mesh::canonicalized(mesh::loop_subdivided(test::small_hand(), 3));
    ASSERT_GE(fine.triangles.size(), 100000u);
    const test::Baked b = test::baked(fine, {.threads = 1});
    EXPECT_TRUE(b.result.report.target_met);
    EXPECT_GE(b.result.report.parts.size(), 10u);
    expect_every_triangle_held(b.view(), b.mesh);
    EXPECT_EQ(io::serialize(b.result.model), bytes_of(fine, {.threads = 3}));
}

}  // namespace
}  // namespace sqmap::bake
