// Rooms of the core that query bodies answer a paper model by its maps, through the table of its Reading.
#include "io/replace_file.h"
#include "query/probe_pointwise.h"
#include "sqmap/bake/evaluate.h"
#include "sqmap/bake/rebake.h"
#include "sqmap/bake/skin_lattice.h"
#include "sqmap/mesh/error.h"
#include "sqmap/mesh/solid.h"
#include "sqmap/query/contacts.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/point.h"
#include "sqmap/query/scene.h"
#include "sqmap/query/skin.h"
#include "sqmap/query/swept.h"
#include "support/bodies.h"
#include "support/paper_model.h"
#include "support/parsed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <initializer_list>
#include <string_view>
#include <utility>

namespace sqmap::paper {
namespace {

using query::Contact;
using query::Layer;
using query::PointResult;
using query::Probe;
using query::ProbeResult;
using query::query_point;
using query::query_probe;

constexpr std::array k_layers{Layer::One, Layer::Two, Layer::Three, Layer::Gate};

const test::PaperModel& hand()
{
    static const test::PaperModel k_hand(test::small_hand(), {.exact = false});
    return k_hand;
}
const test::PaperModel& torus()
{
    static const test::PaperModel k_torus(test::small_torus());
    return k_torus;
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

TEST(Status, NoBitHasTwoMeanings)
{
    unsigned all = 0;
    for (const unsigned bit : std::initializer_list<unsigned>{query::k_not_finite, query::k_no_exact, query::k_no_surface,
                                                              query::k_full, query::k_made_up, query::k_coarse, query::k_crowded,
                                                              query::k_no_triangles, k_not_given}) {
        EXPECT_EQ(all & bit, 0u) << bit;
        all |= bit;
    }
}

TEST(PaperRooms, ProbesPairsAndScenesFindWhatPointsFind)
{
    const model::ModelView& view = hand().view();
    const std::vector<Vec3d> points = points_about(view, 5000);
    Probe probe(points);
    std::vector<Contact> contacts(points.size());
    for (const Layer layer : k_layers)
        for (const bool offset : {false, true}) {
            const query::QueryOptions options{.layer = layer, .offset = offset};
            std::size_t inside = 0;
            for (const Vec3d& p : points) inside += query_point(view, p, options).contact ? 1u : 0u;
            EXPECT_NEAR(static_cast<double>(query_probe({.model = &view}, {.probe = &probe}, options, contacts).contacts),
                        static_cast<double>(inside), 3);
            EXPECT_GT(inside, 100u);
        }
    const std::size_t found = query_probe({.model = &view}, {.probe = &probe}, {}, contacts).contacts;
    query::PairWorkspace workspace(8192);
    EXPECT_EQ(query::query_pair({.model = &view}, {.probe = &probe}, {}, workspace).contacts.size(), found);
    query::Scene scene;
    (void)scene.add(&view, nullptr);
    (void)scene.add(nullptr, &probe);
    std::vector<query::ScenePair> pairs(4);
    std::vector<query::PairContact> of_scene(8192);
    EXPECT_EQ(scene.query_pairs({}, pairs, of_scene).contacts, found);
    query::SweptWorkspace swept(probe);
    const ProbeResult still =
        query::query_swept({{.model = &view}, &probe, {}, {}, points, points}, {.step = 0.01}, swept, contacts).probe;
    EXPECT_EQ(still.contacts, found);
}

TEST(PaperRooms, SkinsFindWhatPointsFind)
{
    const model::ModelView& view = hand().view();
    const mesh::Mesh mesh = test::small_hand();
    mesh::Influences influences;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        influences.joints.push_back({0, 1, 0, 0});
        influences.weights.push_back({0.5, 0.5, 0, 0});
    }
    const query::SkinLattice lattice = bake::skin_lattice(mesh, influences);
    query::PosedSkin skin(lattice);
    // The joints move apart by 3 cm, and the skin half as far.
    const std::array<Affine, 2> maps{Affine{}, Affine{{}, {0.03, 0, 0}}};
    ASSERT_TRUE(skin.pose(maps));
    std::vector<Vec3d> points = points_about(view, 2000);
    std::size_t inside = 0;
    for (Vec3d& p : points) {
        inside += query_point(view, p).contact ? 1u : 0u;
        p.x += 0.015;
    }
    query::SkinWorkspace workspace(lattice, points);
    std::vector<query::SkinContact> contacts(points.size());
    EXPECT_GT(inside, 50u);
    EXPECT_NEAR(static_cast<double>(query_skin({&view, &skin, points, {}}, {}, workspace, contacts).contacts),
                static_cast<double>(inside), 3);
}

TEST(PaperRooms, CopiesOfAViewAnswerAsItDoes)
{
    const model::ModelView& view = hand().view();
    model::ModelView copy = model::normalized(view);
    for (const Vec3d& p : points_about(view, 300)) {
        const PointResult a = query_point(view, p), b = query_point(copy, cast<double>(model::to_model_space(view.header, p)));
        EXPECT_EQ(a.contact, b.contact);
        EXPECT_NEAR(a.depth, b.depth * view.header.unit, 1e-5 * view.header.unit);
    }
}

TEST(PaperRooms, TheOffsetMovesTheSurfaceOut)
{
    EXPECT_GT(query::offset_reach(hand().view(), {.offset = true}), 0.f);
    EXPECT_EQ(query::offset_reach(hand().view(), {}), 0.f);
}

TEST(PaperRooms, SmoothingChangesDepthAndNormalButNoVerdict)
{
    const model::ModelView& view = hand().view();
    int contacts = 0, changed = 0;
    for (const Vec3d& p : points_about(view, 6000)) {
        const PointResult plain = query_point(view, p), smooth = query_point(view, p, {.smoothed_map = true});
        ASSERT_EQ(smooth.contact, plain.contact);
        EXPECT_FALSE(smooth.certain);
        if (!plain.contact || (plain.status & query::k_no_surface) != 0) continue;
        ++contacts;
        EXPECT_NEAR(norm(smooth.normal), 1, 1e-4);
        changed += smooth.depth != plain.depth ? 1 : 0;
    }
    ASSERT_GT(contacts, 100);
    EXPECT_GT(changed, contacts / 4);
}

TEST(PaperRooms, DistancesAreThoseOfTrianglesOrNone)
{
    EXPECT_FALSE(model::has_distance(hand().view()));
    for (const Vec3d& p : points_about(hand().view(), 200)) {
        const query::SignedDistance a = query::distance(hand().view(), p, query::k_baked_band);
        EXPECT_EQ(a.known, query::DistanceKind::LowerBound);
        EXPECT_NE(a.status & k_not_given, 0);
    }
    const test::Parsed central(test::small_torus());
    for (const Vec3d& p : points_about(torus().view(), 200))
        EXPECT_EQ(query::distance(torus().view(), p).distance, query::distance(central.view(), p).distance);
}

TEST(PaperRooms, AnOptionThatTheMapsDoNotGiveIsAStatusBit)
{
    const model::ModelView& view = hand().view();
    EXPECT_NE(query_point(view, {}, {.margin = 0.1}).status & k_not_given, 0);
    const Probe probe(points_about(view, 100));
    std::vector<Contact> contacts(100);
    EXPECT_NE(query_probe({.model = &view}, {.probe = &probe}, {.margin = 0.1}, contacts).status & k_not_given, 0);
    EXPECT_EQ(query_probe({.model = &view}, {.probe = &probe}, {}, contacts).status & k_not_given, 0);
}

TEST(PaperRooms, APaperModelHoldsNoCentralMaps)
{
    EXPECT_EQ(model::bytes_of<model::CentralArrays<model::ArrayView>>(torus().view()), 0u);
    EXPECT_EQ(model::bytes_of<model::LocatorArrays<model::ArrayView>>(hand().view()), 0u);
    EXPECT_TRUE(torus().view().planes.empty());
    EXPECT_TRUE(torus().view().seeds.empty());
    EXPECT_TRUE(torus().view().part_lists.empty());
    EXPECT_TRUE(model::has_exact(torus().view()));
}

// The cells of a paper model lead to the same triangles as those of a central one.
TEST(PaperRooms, TheExactLayerIsThatOfACentralModel)
{
    const test::Parsed central(test::small_torus());
    const std::vector<Vec3d> points = points_about(central.view(), 3000);
    const Probe probe(points);
    std::vector<Contact> a(points.size()), b(points.size());
    const ProbeResult of_paper = query_probe({.model = &torus().view()}, {.probe = &probe}, {.layer = Layer::Exact}, a);
    const ProbeResult of_central = query_probe({.model = &central.view()}, {.probe = &probe}, {.layer = Layer::Exact}, b);
    ASSERT_EQ(of_paper.contacts, of_central.contacts);
    EXPECT_GT(of_paper.contacts, 100u);
    const auto by_index = [](const Contact& x, const Contact& y) { return x.index < y.index; };
    std::sort(a.begin(), a.begin() + static_cast<std::ptrdiff_t>(of_paper.contacts), by_index);
    std::sort(b.begin(), b.begin() + static_cast<std::ptrdiff_t>(of_central.contacts), by_index);
    for (std::size_t i = 0; i < of_paper.contacts; ++i) {
        EXPECT_EQ(a[i].index, b[i].index);
        EXPECT_NEAR(a[i].depth, b[i].depth, 1e-6);
    }
}

TEST(PaperRooms, SubdivisionsSetHowMuchFinerLayerThreeIs)
{
    for (const int levels : {0, 2}) {
        const test::PaperModel b(test::small_torus(), {.exact = false}, {.subdivisions = levels});
        for (const MapRecord& map : b.data().maps.records) {
            EXPECT_EQ(map.grid.subdivisions, static_cast<std::uint32_t>(levels));
            const std::uint32_t samples = (((map.grid.eta_count - 1) >> levels) + 1) * (map.grid.omega_count >> levels);
            EXPECT_EQ(map.slices.hits.count, (samples + 31) / 32);
        }
    }
    for (const int levels : {6, -1})
        EXPECT_THROW((void)bake(test::small_torus(), true, {}, MapOptions{.subdivisions = levels}), mesh::InvalidInput);
}

TEST(PaperFile, EachParserRefusesTheOtherKindByName)
{
    model::ModelView central;
    EXPECT_EQ(model::parse(hand().bytes(), central), model::ParseStatus::PaperModel);
    ModelView own;
    EXPECT_EQ(parse(test::baked_bytes(test::small_torus(), true), own), model::ParseStatus::NotAModel);
}

TEST(PaperFile, FunctionsOfTheCoreRefuseItByName)
{
    const auto named = [](const std::exception& e) {
        return std::string_view(e.what()).find("a paper model") != std::string_view::npos;
    };
    const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / "refused_paper_model.sqmap";
    io::replace_file(path, hand().bytes());
    try {
        const io::MappedModel file(path);
        ADD_FAILURE() << "opened";
    } catch (const io::ModelFileError& e) {
        EXPECT_TRUE(named(e)) << e.what();
    }
    std::filesystem::remove(path);
    try {
        (void)bake::rebake(torus().data().common, test::small_torus().vertices);
        ADD_FAILURE() << "baked";
    } catch (const mesh::InvalidInput& e) {
        EXPECT_TRUE(named(e)) << e.what();
    }
    try {
        (void)bake::evaluate(torus().view(), mesh::Solid(bake::model_space(test::small_torus())), {});
        ADD_FAILURE() << "measured";
    } catch (const mesh::InvalidInput& e) {
        EXPECT_TRUE(named(e)) << e.what();
    }
}

TEST(PaperFile, SerializingParsesToTheSameArrays)
{
    for (const test::PaperModel* m : {&hand(), &torus()}) {
        ModelView v;
        ASSERT_EQ(parse(m->bytes(), v), model::ParseStatus::Ok);
        const auto expect_same = [](const char* name, const auto& read, const auto& written) {
            ASSERT_EQ(read.size(), written.size()) << name;
            EXPECT_TRUE(read.empty() || std::memcmp(read.data(), written.data(), read.size_bytes()) == 0) << name;
        };
        ModelMaps<model::ArrayView>::each(expect_same, v.maps, m->data().maps);
        model::each_surface_array(expect_same, v.common, m->data().common);
        model::each_cell_array(expect_same, v.common, m->data().common);
    }
}

TEST(PaperFile, DamageIsRefused)
{
    const auto refused = [](auto&& damage) {
        ModelData data = hand().data();
        damage(data);
        ModelView v;
        return parse(serialize(data), v) != model::ParseStatus::Ok;
    };
    EXPECT_FALSE(refused([](ModelData&) {}));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.records[0].slices.distance.first = 1u << 30; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.records[0].grid.distance_scale = -1; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.records[0].grid.change_scale = NAN; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.hits[1].before ^= 1; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.hits.back().before += 1000000; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.hits[3].bits ^= 256; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.records[0].slices.hits.count -= 1; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.records[0].slices.normal.count -= 1; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.records[0].slices.smoothed.count -= 1; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.distance[0] = d.maps.distance[0] < 65534 ? 65535 : 0; }));
    ASSERT_GT(hand().data().maps.records[0].slices.offset.count, 3u);
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.records[0].slices.offset.count -= 1; }));
    EXPECT_TRUE(refused([](ModelData& d) { std::swap(d.maps.offset[0], d.maps.offset[1]); }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.offset[d.maps.records[0].slices.offset.count - 3] |= 0x70000000; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.records.pop_back(); }));
    EXPECT_TRUE(refused([](ModelData& d) { d.maps.seeds.pop_back(); }));
    EXPECT_TRUE(refused([](ModelData& d) { d.common.header.projection = 0; }));
    EXPECT_TRUE(refused([](ModelData& d) { d.common.parts[0].base = 4; }));
    std::vector<std::byte> bytes = hand().bytes();
    bytes[bytes.size() / 2] ^= std::byte{1};
    ModelView v;
    EXPECT_NE(parse(bytes, v), model::ParseStatus::Ok);
}

}  // namespace
}  // namespace sqmap::paper
