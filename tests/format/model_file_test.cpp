// The .sqmap file: what is written comes back, and no other bytes are taken for a model.
#include "sqmap/io/model_file.h"

#include "model/bound_tree.h"
#include "model/candidate_lists.h"
#include "model/central_cells.h"
#include "model/locator_cells.h"
#include "model/schema.h"
#include "sqmap/query/distance.h"
#include "sqmap/query/point.h"
#include "sqmap/query/probe.h"
#include "support/baked_shapes.h"

#include <flatbuffers/minireflect.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <new>

namespace sqmap::io {
namespace {

namespace fs = std::filesystem;
using model::ModelData;
using model::ModelView;
using model::ParseStatus;

/// Bytes at an 8-byte boundary with nothing behind them, so that a sanitizer sees every overrun.
class Bytes {
public:
    explicit Bytes(std::span<const std::byte> from)
        : size_(from.size()), data_(new (std::align_val_t{8}) std::byte[std::max<std::size_t>(size_, 1)])
    {
        std::copy(from.begin(), from.end(), data_);
    }
    ~Bytes() { ::operator delete[](data_, std::align_val_t{8}); }
    Bytes(const Bytes&) = delete;
    Bytes& operator=(const Bytes&) = delete;
    [[nodiscard]] std::span<std::byte> span() { return {data_, size_}; }

private:
    std::size_t size_;
    std::byte* data_;
};

/// Has every kind of cell and list: a torus of a few parts, a hand, a cube.
const ModelData& torus_model()
{
    static const ModelData k_model = [] {
        ModelData data =
            test::baked(mesh::torus({.major_radius = 1, .minor_radius = 0.3, .major_segments = 44, .minor_segments = 20}))
                .result.model;
        data.made_by = "test";
        data.source = "torus.obj";
        data.options = "none";
        return data;
    }();
    return k_model;
}

/// A probe the size of the object, posed over it and beside it, in every layer that frames have. Answers must be numbers of
/// contacts, indices of points and existing parts.
void interrogate_frames(const ModelView& view, test::Random& random)
{
    std::vector<Vec3d> points(77);
    const double size = view.header.unit * static_cast<double>(view.header.sphere[3]);
    for (Vec3d& p : points) p = size * random.in_box({-1, -1, -1}, {1, 1, 1});
    const query::Probe probe(points);
    const Vec3d middle = model::to_mesh_units(view.header, model::vec3(view.header.sphere));
    query::Contact contacts[80];
    for (const double away : {0.0, 0.8})
        for (const query::Layer layer : {query::Layer::One, query::Layer::Two, query::Layer::Three, query::Layer::Exact}) {
            const sqmap::Pose pose{{}, middle + away * size * random.direction()};
            const query::ProbeResult result =
                query::query_probe({.model = &view}, {.probe = &probe, .pose = pose}, {.layer = layer}, contacts);
            ASSERT_LE(result.contacts, points.size());
            for (std::size_t i = 0; i < result.contacts; ++i) {
                EXPECT_LT(contacts[i].index, points.size());
                EXPECT_LT(contacts[i].part, static_cast<std::int32_t>(view.parts.size()));
            }
        }
}

/// Distances singly, in a batch and of a posed probe, within the band and all over the tree. Answers must be of existing parts.
void interrogate_distances(const ModelView& view, test::Random& random)
{
    const double size = view.header.unit * static_cast<double>(view.header.sphere[3]);
    const Vec3d middle = model::to_mesh_units(view.header, model::vec3(view.header.sphere));
    std::vector<Vec3d> points(40);
    for (std::size_t i = 0; i < points.size(); ++i)
        points[i] = middle + (i % 4 == 0 ? 4 : 1.2) * size * random.in_box({-1, -1, -1}, {1, 1, 1});
    std::vector<query::SignedDistance> answers(points.size());
    for (const double band : {query::k_baked_band, 2 * size}) {
        query::distances(view, points, answers, band);
        answers.push_back(query::distance(view, points[0], band));
        for (const query::SignedDistance& a : answers) EXPECT_LT(a.part, static_cast<std::int32_t>(view.parts.size()));
        answers.pop_back();
    }
    const query::Probe probe(points);
    (void)query::is_nearer({&view}, {nullptr, &probe}, 0.1 * size);
}

/// Asks a model everything, about points on, in, around and far from its object. Answers must be numbers.
void interrogate(const ModelView& view, std::uint64_t seed)
{
    test::Random random(seed);
    const float r = view.header.sphere[3];
    for (int i = 0; i < 60; ++i) {
        Vec3f p = cast<float>(random.in_box({-1.2, -1.2, -1.2}, {1.2, 1.2, 1.2}));
        p = r * p + model::vec3(view.header.sphere);
        if (i % 4 == 0) p = model::vec3(view.parts[random.below(view.parts.size())].chart_centre);
        if (i % 8 == 1) p = 1e30f * p;
        for (const query::Layer layer :
             {query::Layer::One, query::Layer::Two, query::Layer::Three, query::Layer::Exact, query::Layer::Auto}) {
            const query::PointResult c = query::query_point(model::normalized(view), cast<double>(p), {.layer = layer});
            EXPECT_LT(c.part, static_cast<std::int32_t>(view.parts.size()));
        }
        const auto part = static_cast<std::uint32_t>(random.below(view.parts.size()));
        (void)query::distance_along_projection(model::normalized(view), part, cast<double>(p), query::Layer::Three);
    }
    interrogate_frames(view, random);
    interrogate_distances(view, random);
}

/// Parses a copy of the bytes; what verifies must also be safe to ask.
ParseStatus parse_and_query(std::span<const std::byte> bytes, std::uint64_t seed = 1)
{
    Bytes copy(bytes);
    ModelView view;
    const ParseStatus status = model::parse(copy.span(), view);
    if (status == ParseStatus::Ok)
        interrogate(view, seed);
    else
        EXPECT_TRUE(view.parts.empty()) << "a refused model left a view behind";
    return status;
}

/// Parses what a writer with a valid hash would have made of changed data.
ParseStatus parse_changed(const std::function<void(ModelData&)>& change)
{
    ModelData data = torus_model();
    change(data);
    return parse_and_query(serialize(data));
}

template <class T>
bool same_array(std::span<const T> a, const std::vector<T>& b)
{
    return a.size() == b.size() && (b.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

TEST(ModelFile, WhatIsSerializedParsesToTheSameArrays)
{
    const test::Baked normal = test::baked(test::small_torus(), {.projection = model::Projection::Normal});
    for (const ModelData* data : {&torus_model(), &normal.result.model}) {
        Bytes bytes(serialize(*data));
        ModelView v;
        ASSERT_EQ(model::parse(bytes.span(), v), ParseStatus::Ok);
        EXPECT_EQ(std::memcmp(&v.header, &data->header, sizeof v.header), 0);
        EXPECT_EQ(std::memcmp(&v.locator, &data->locator, sizeof v.locator), 0);
        const auto expect_same = [](const char* name, const auto& read, const auto& written) {
            EXPECT_TRUE(same_array(read, written)) << name;
        };
        model::each_array_before_normal(expect_same, v, *data);
        model::NormalArrays<model::ArrayView>::each(expect_same, v.normal, data->normal);
        model::each_array_behind_normal(expect_same, v, *data);
        EXPECT_EQ(std::memcmp(&v.distance.header, &data->distance.header, sizeof v.distance.header), 0);
        model::DistanceArrays<model::ArrayView>::each(expect_same, v.distance, data->distance);
        interrogate(v, 3);
    }
    EXPECT_TRUE(model::has_locator(torus_model().view()));
    EXPECT_FALSE(normal.result.model.normal.parts.empty());
}

/// Of a vector's element, by the schema; 0: there is no such vector.
std::size_t element_size(const flatbuffers::TypeTable& table, const char* name)
{
    const std::size_t field = model::field_of(table, name);
    if (field == table.num_elems || table.type_codes[field].is_repeating == 0) return 0;
    const flatbuffers::TypeCode type = table.type_codes[field];
    if (type.base_type != flatbuffers::ET_SEQUENCE)
        return flatbuffers::InlineSize(static_cast<flatbuffers::ElementaryType>(type.base_type), nullptr);
    const flatbuffers::TypeTable& of = *table.type_refs[type.sequence_ref]();
    return static_cast<std::size_t>(of.values[of.num_elems]);
}

TEST(ModelFile, EveryArrayIsAFieldOfTheSchemaOfTheSameSize)
{
    const ModelView v;
    const flatbuffers::TypeTable* table = model::fb::ModelTypeTable();
    const auto expect_field = [&](const char* name, const auto& array) {
        EXPECT_EQ(element_size(*table, name), sizeof(array[0])) << name;
    };
    model::each_array_before_normal(expect_field, v);
    model::each_array_behind_normal(expect_field, v);
    table = model::fb::NormalMapsTypeTable();
    model::NormalArrays<model::ArrayView>::each(expect_field, v.normal);
    table = model::fb::DistanceTypeTable();
    model::DistanceArrays<model::ArrayView>::each(expect_field, v.distance);
}

TEST(ModelFile, TheSameDataGivesTheSameBytes)
{
    const ModelData copy = torus_model();
    EXPECT_EQ(serialize(torus_model()), serialize(copy));
}

TEST(ModelFile, ASerializedModelAnswersAsTheOneInMemory)
{
    const ModelData& data = torus_model();
    Bytes bytes(serialize(data));
    ModelView parsed;
    ASSERT_EQ(model::parse(bytes.span(), parsed), ParseStatus::Ok);
    const ModelView direct = data.view();
    test::Random random(5);
    for (int i = 0; i < 2000; ++i) {
        const Vec3d p = random.in_box({-1.5, -1.5, -1.5}, {1.5, 1.5, 1.5});
        for (const query::Layer layer : {query::Layer::Two, query::Layer::Three, query::Layer::Exact}) {
            const query::PointResult a = query::query_point(parsed, p, {.layer = layer}),
                                     b = query::query_point(direct, p, {.layer = layer});
            ASSERT_EQ(a.contact, b.contact);
            ASSERT_EQ(a.depth, b.depth);
            ASSERT_EQ(a.point, b.point);
            ASSERT_EQ(a.normal, b.normal);
        }
    }
}

TEST(ModelFile, EveryTruncationIsRefused)
{
    const std::vector<std::byte> bytes = serialize(torus_model());
    std::vector<std::size_t> lengths;
    for (std::size_t n = 0; n < 128; ++n) lengths.push_back(n);
    for (std::size_t n = 1; n <= 64; ++n) lengths.push_back(bytes.size() - n);
    for (std::size_t i = 1; i < 200; ++i) lengths.push_back(bytes.size() * i / 200);
    for (const std::size_t n : lengths)
        EXPECT_NE(parse_and_query(std::span(bytes).first(n)), ParseStatus::Ok) << n << " of " << bytes.size() << " bytes";
}

TEST(ModelFile, BytesBehindTheEndAreRefused)
{
    for (const std::size_t extra : {1u, 7u, 8u, 64u, 4096u}) {
        std::vector<std::byte> bytes = serialize(torus_model());
        bytes.resize(bytes.size() + extra, std::byte{0x5a});
        EXPECT_NE(parse_and_query(bytes), ParseStatus::Ok) << extra << " bytes too many";
    }
}

TEST(ModelFile, AnotherIdentifierIsNotAModel)
{
    std::vector<std::byte> bytes = serialize(torus_model());
    bytes[4] = std::byte{'X'};
    EXPECT_EQ(parse_and_query(bytes), ParseStatus::NotAModel);
    const std::vector<std::byte> zeros(4096), ones(4096, std::byte{0xff});
    EXPECT_EQ(parse_and_query(zeros), ParseStatus::NotAModel);
    EXPECT_EQ(parse_and_query(ones), ParseStatus::NotAModel);
}

/// Where a 32-bit value stands in the bytes, if it stands there once.
std::size_t find_vtable_slot(std::span<const std::byte> bytes)
{
    // FlatBuffers: the root table's vtable is at (table - soffset); field 0 (version) has slot 4.
    const auto read = [&](std::size_t at, auto value) {
        std::memcpy(&value, bytes.data() + at, sizeof value);
        return value;
    };
    const std::size_t table = read(0, std::uint32_t{});
    const std::size_t vtable = static_cast<std::size_t>(static_cast<std::int64_t>(table) - read(table, std::int32_t{}));
    return table + read(vtable + 4, std::uint16_t{});
}

TEST(ModelFile, AnotherVersionIsNamedAsSuch)
{
    for (const std::uint32_t version : {0u, model::k_format_version + 1, 0xffffffffu}) {
        std::vector<std::byte> bytes = serialize(torus_model());
        const std::size_t slot = find_vtable_slot(bytes);
        std::uint32_t stored = 0;
        std::memcpy(&stored, bytes.data() + slot, 4);
        ASSERT_EQ(stored, model::k_format_version);
        std::memcpy(bytes.data() + slot, &version, 4);
        EXPECT_EQ(parse_and_query(bytes), ParseStatus::WrongVersion);
    }
}

TEST(ModelFile, NoFlippedBitCrashesAndNoneInAnArrayPasses)
{
    const std::vector<std::byte> good = serialize(torus_model());
    Bytes arena(good);
    const std::span<std::byte> bytes = arena.span();
    ModelView v;
    ASSERT_EQ(model::parse(bytes, v), ParseStatus::Ok);
    const std::byte* arrays_begin = reinterpret_cast<const std::byte*>(v.triangle_part.data());
    const std::byte* arrays_end = reinterpret_cast<const std::byte*>(v.parts.data() + v.parts.size());
    ASSERT_LT(arrays_begin, arrays_end) << "the writer's order of arrays changed: adapt this test";
    const std::size_t stride = std::max<std::size_t>(1, good.size() / 4000);
    test::Random random(11);
    std::size_t tried = 0;
    const auto flip = [&](std::size_t at, unsigned bit) {
        bytes[at] ^= std::byte(1u << bit);
        ModelView view;
        const ParseStatus status = model::parse(bytes, view);
        const bool in_array = bytes.data() + at >= arrays_begin && bytes.data() + at < arrays_end;
        if (status == ParseStatus::Ok) {
            interrogate(view, at);
            // The lengths and the padding between arrays are no array; a length that changes changes what is hashed.
            const bool padding = good[at] == std::byte{0};
            EXPECT_FALSE(in_array && !padding) << "byte " << at << " bit " << bit;
        }
        bytes[at] ^= std::byte(1u << bit);
        ++tried;
    };
    for (std::size_t at = 0; at < std::min<std::size_t>(256, good.size()); ++at)
        for (unsigned bit = 0; bit < 8; ++bit) flip(at, bit);
    for (std::size_t at = random.below(stride); at < good.size(); at += stride) flip(at, random.below(8));
    EXPECT_GT(tried, 3000u);
}

TEST(ModelFile, RandomDamageWithAValidHashNeverCrashes)
{
    // The hash tells accidents, not malice: a writer of hostile models computes it, too.
    test::Random random(17);
    const auto damage = [&](auto& values) {
        using T = std::decay_t<decltype(values[0])>;
        if (values.empty()) return;
        const std::size_t at = random.below(values.size());
        auto* raw = reinterpret_cast<unsigned char*>(&values[at]);
        raw[random.below(sizeof(T))] = static_cast<unsigned char>(random.bits());
    };
    int passed = 0;
    for (int i = 0; i < 1500; ++i) {
        ModelData data = torus_model();
        const std::uint32_t times = 1 + random.below(3);
        for (std::uint32_t k = 0; k < times; ++k) switch (random.below(16)) {
                case 0:
                    damage(data.samples);
                    break;
                case 1:
                    damage(data.cells);
                    break;
                case 2:
                    damage(data.blocks);
                    break;
                case 3:
                    damage(data.splits);
                    damage(data.specials);
                    break;
                case 4:
                    damage(data.pool);
                    break;
                case 5:
                    damage(data.vertices);
                    break;
                case 6:
                    damage(data.triangles16);
                    break;
                case 7:
                    damage(data.bricks);
                    break;
                case 8:
                    damage(data.locator_cells);
                    break;
                case 9:
                    damage(data.part_lists);
                    break;
                case 10:
                    damage(data.seeds);
                    damage(data.planes);
                    break;
                case 11: {
                    std::span<model::Locator> locator(&data.locator, 1);
                    damage(locator);
                    break;
                }
                case 12:
                    damage(data.near);
                    break;
                case 13:
                    damage(data.distance.nodes);
                    damage(data.distance.groups);
                    damage(data.distance.entries16);
                    break;
                case 14: {
                    damage(data.distance.bounds);
                    std::span<model::DistanceHeader> header(&data.distance.header, 1);
                    damage(header);
                    break;
                }
                default:
                    damage(data.parts);
                    break;
            }
        if (parse_and_query(serialize(data), static_cast<std::uint64_t>(i)) == ParseStatus::Ok) ++passed;
    }
    EXPECT_GT(passed, 100) << "damage that the values' ranges allow should reach the queries";
}

struct Lie {
    const char* name;
    std::function<void(ModelData&)> change;
};
void PrintTo(const Lie& lie, std::ostream* out) { *out << lie.name; }

class InconsistentModel : public testing::TestWithParam<Lie> {};

TEST_P(InconsistentModel, IsRefusedThoughItsHashIsRight)
{
    const ParseStatus status = parse_changed(GetParam().change);
    EXPECT_TRUE(status == ParseStatus::BadStructure || status == ParseStatus::BadValue) << model::to_string(status);
}

constexpr float k_nan = std::numeric_limits<float>::quiet_NaN();
constexpr float k_inf = std::numeric_limits<float>::infinity();

std::uint16_t cell_of(model::CellKind kind, std::uint32_t payload) { return model::CentralCell::of(kind, payload).word; }

/// A cell of part 0 that is split; with its children.
std::uint16_t& split_child(ModelData& m, std::size_t child)
{
    for (const model::Part& p : m.parts)
        for (std::uint32_t i = 0; i < p.cell_count; ++i) {
            const model::CentralCell cell{m.cells[p.first_cell + i]};
            if (cell.kind() == model::CellKind::Split)
                return m.splits[model::k_split_size * (p.first_split + cell.payload()) + model::k_split_cells + child];
        }
    throw std::logic_error("the model has no split cell");
}

/// Where the first brick's record of near triangles is.
std::uint32_t& stored_near(ModelData& m)
{
    const auto it =
        std::find_if(m.near_bricks.begin(), m.near_bricks.end(), [](std::uint32_t b) { return b != model::k_no_candidates; });
    if (it == m.near_bricks.end()) throw std::logic_error("the model has no near triangles");
    return *it;
}

/// The first list of a record that has lists, and the last value of one whose last triangles are not sixteen.
std::uint16_t* first_list(ModelData& m)
{
    const model::CandidateRecord r = model::candidate_record(m.near.data() + stored_near(m), false);
    return m.near.data() + (r.lists - m.near.data());
}
std::uint16_t& last_word(ModelData& m)
{
    for (const std::uint32_t first : m.near_bricks) {
        if (first == model::k_no_candidates) continue;
        const model::CandidateRecord r = model::candidate_record(m.near.data() + first, false);
        const std::size_t words = model::mask_words(r.triangles), steps = model::mask_words(words);
        if (r.triangles % 16 == 0) continue;
        for (std::uint32_t k = 0; k < r.cells(); ++k)
            if (r.starts[k] < r.starts[k + 1] && (r.lists[r.starts[k] + steps - 1] >> (words - 1) % 16 & 1) != 0)
                return m.near[static_cast<std::size_t>(r.lists - m.near.data()) + r.starts[k + 1] - 1u];
    }
    throw std::logic_error("no list has the last triangles of its brick");
}

/// The first cell that is not free.
std::uint32_t& occupied_cell(ModelData& m)
{
    const auto it = std::find_if(m.locator_cells.begin(), m.locator_cells.end(), [](std::uint32_t p) {
        return !model::LocatorCell{p}.is_free() && !model::LocatorCell{p}.is_divided();
    });
    if (it == m.locator_cells.end()) throw std::logic_error("the model has no occupied cell");
    return *it;
}

/// The first cell that planes answer for, with a list that has room for another part.
std::uint32_t& flat_cell(ModelData& m)
{
    const auto it = std::find_if(m.locator_cells.begin(), m.locator_cells.end(), [&](std::uint32_t p) {
        return model::LocatorCell{p}.is_flat() && m.part_lists[model::LocatorCell{p}.list()] >> 24 == model::k_no_part;
    });
    if (it == m.locator_cells.end()) throw std::logic_error("the model has no flat cell");
    return *it;
}

/// The first cell that is searched from several seeds.
std::uint32_t& cell_of_a_chain(ModelData& m)
{
    const auto it = std::find_if(m.locator_cells.begin(), m.locator_cells.end(), [&](std::uint32_t p) {
        return model::LocatorCell{p}.has_seeds() && !model::is_last_seed(m.seeds[model::LocatorCell{p}.first()]);
    });
    if (it != m.locator_cells.end()) return *it;
    // Planes answer everywhere: one cell asks two seeds instead.
    m.seeds.push_back({0, 0});
    const auto first = static_cast<std::uint32_t>(m.seeds.size());
    m.seeds.push_back({0, 0x8000});
    for (std::uint32_t k = 0; k < model::k_max_seeds; ++k) m.seeds.push_back({0, 0x8000 | model::k_last_seed});
    std::uint32_t& cell = flat_cell(m);
    cell = (cell & 0x7ffu) | first << 14;
    return cell;
}

/// The first brick that is stored cell by cell.
std::uint32_t& stored_brick(ModelData& m)
{
    const auto it = std::find_if(m.bricks.begin(), m.bricks.end(), [](std::uint32_t b) {
        return (b & (model::LocatorBrick::k_free | model::LocatorBrick::k_deep)) == 0;
    });
    if (it == m.bricks.end()) throw std::logic_error("the model has no stored brick");
    return *it;
}

/// The first cell of the tree of bounds that is divided.
std::size_t divided_bound(const ModelData& m)
{
    const auto& bounds = m.distance.bounds;
    const auto it = std::find_if(bounds.begin(), bounds.end(), [](std::uint16_t b) { return (b & model::k_bound_leaf) == 0; });
    if (it == bounds.end()) throw std::logic_error("the tree has no divided cell");
    return static_cast<std::size_t>(it - bounds.begin());
}

const Lie k_lies[] = {
    {"no_parts", [](ModelData& m) { m.parts.clear(); }},
    {"origin_nan", [](ModelData& m) { m.header.origin[1] = std::numeric_limits<double>::quiet_NaN(); }},
    {"unit_zero", [](ModelData& m) { m.header.unit = 0; }},
    {"unit_negative", [](ModelData& m) { m.header.unit = -1; }},
    {"unit_inf", [](ModelData& m) { m.header.unit = std::numeric_limits<double>::infinity(); }},
    {"r_max_zero", [](ModelData& m) { m.header.r_max = 0; }},
    {"r_max_nan", [](ModelData& m) { m.header.r_max = std::numeric_limits<double>::quiet_NaN(); }},
    {"sphere_nan", [](ModelData& m) { m.header.sphere[3] = k_nan; }},
    {"sphere_radius_negative", [](ModelData& m) { m.header.sphere[3] = -1; }},
    {"projection_unknown", [](ModelData& m) { m.header.projection = 2; }},
    {"quantisation_nan", [](ModelData& m) { m.header.quantisation = std::numeric_limits<double>::quiet_NaN(); }},
    {"a_zero", [](ModelData& m) { m.parts[0].a[0] = 0; }},
    {"a_negative", [](ModelData& m) { m.parts[0].a[2] = -m.parts[0].a[2]; }},
    {"a_nan", [](ModelData& m) { m.parts[0].a[1] = k_nan; }},
    {"eps_below_range", [](ModelData& m) { m.parts[0].eps[0] = 0.05f; }},
    {"eps_above_range", [](ModelData& m) { m.parts[0].eps[1] = 2.1f; }},
    {"eps_nan", [](ModelData& m) { m.parts[0].eps[0] = k_nan; }},
    {"eps_negative", [](ModelData& m) { m.parts[0].eps[1] = -1; }},
    {"rotation_inf", [](ModelData& m) { m.parts[0].rotation[4] = k_inf; }},
    {"rotation_not_a_rotation", [](ModelData& m) { m.parts[0].rotation[4] *= 1.5f, m.parts[0].rotation[0] += 0.5f; }},
    {"translation_nan", [](ModelData& m) { m.parts[0].translation[0] = k_nan; }},
    {"taper_beyond_range", [](ModelData& m) { m.parts[0].taper[0] = 1.5f; }},
    {"taper_nan", [](ModelData& m) { m.parts[0].taper[1] = k_nan; }},
    {"bend_inf", [](ModelData& m) { m.parts[0].bend = k_inf; }},
    {"bend_negative", [](ModelData& m) { m.parts[0].bend = -1; }},
    {"certificate_nan", [](ModelData& m) { m.parts[0].largest_f = k_nan; }},
    {"part_sphere_nan", [](ModelData& m) { m.parts[0].sphere[0] = k_nan; }},
    {"part_sphere_negative", [](ModelData& m) { m.parts[0].sphere[3] = -0.5f; }},
    {"chart_rows_not_orthogonal", [](ModelData& m) { m.parts[0].chart_rows[1] += 0.5f; }},
    {"chart_rows_nan", [](ModelData& m) { m.parts[0].chart_rows[8] = k_nan; }},
    {"chart_centre_inf", [](ModelData& m) { m.parts[0].chart_centre[0] = -k_inf; }},
    {"chart_box_empty", [](ModelData& m) { m.parts[0].chart_lo[0] = m.parts[0].chart_hi[0]; }},
    {"w_step_zero", [](ModelData& m) { m.parts[0].w_step = 0; }},
    {"w_step_negative", [](ModelData& m) { m.parts[0].w_step = -m.parts[0].w_step; }},
    {"w_min_negative", [](ModelData& m) { m.parts[0].w_min = -0.1f; }},
    {"w_range_overflows", [](ModelData& m) { m.parts[0].w_step = 1e36f; }},
    {"area_nan", [](ModelData& m) { m.parts[0].area = k_nan; }},
    {"centre_winding_huge", [](ModelData& m) { m.parts[0].centre_winding = std::numeric_limits<std::int32_t>::min(); }},
    {"base_zero", [](ModelData& m) { m.parts[0].base = 0; }},
    {"base_not_of_blocks", [](ModelData& m) { m.parts[0].base += 1; }},
    {"base_doubled", [](ModelData& m) { m.parts[0].base *= 2; }},
    {"base_huge", [](ModelData& m) { m.parts[0].base = 0xfffffffcu; }},
    {"sample_count_short", [](ModelData& m) { --m.parts[0].sample_count; }},
    {"samples_beyond_end", [](ModelData& m) { m.parts.back().first_sample += 1; }},
    {"samples_wrap_around", [](ModelData& m) { m.parts[0].first_sample = 0xffffffffu; }},
    {"samples_missing", [](ModelData& m) { m.samples.pop_back(); }},
    {"cell_count_long", [](ModelData& m) { ++m.parts[0].cell_count; }},
    {"cells_beyond_end", [](ModelData& m) { m.parts.back().first_cell += 1; }},
    {"cells_missing", [](ModelData& m) { m.cells.clear(); }},
    {"block_count_short", [](ModelData& m) { --m.parts[0].block_count; }},
    {"blocks_beyond_end", [](ModelData& m) { m.parts.back().first_block += 1; }},
    {"splits_beyond_end", [](ModelData& m) { m.parts.back().first_split += 1; }},
    {"splits_missing", [](ModelData& m) { m.splits.clear(); }},
    {"splits_cut", [](ModelData& m) { m.splits.pop_back(); }},
    {"specials_beyond_end", [](ModelData& m) { m.parts.back().first_special += 1; }},
    {"specials_wrap_around", [](ModelData& m) { m.parts[0].first_special = 0xfffffff0u; }},
    {"specials_missing", [](ModelData& m) { m.specials.clear(); }},
    {"pool_beyond_end", [](ModelData& m) { m.parts.back().first_pool += 1; }},
    {"pool_missing", [](ModelData& m) { m.pool.clear(); }},
    {"special_points_behind_pool", [](ModelData& m) { m.specials[0] = m.parts[0].pool_count; }},
    {"special_points_far_away", [](ModelData& m) { m.specials[0] = 0xffffffffu; }},
    {"uniform_payload", [](ModelData& m) { m.cells[0] = cell_of(model::CellKind::Uniform, 2); }},
    {"single_payload", [](ModelData& m) { m.cells[0] = cell_of(model::CellKind::Single, 2 * model::CentralCell::k_foreign); }},
    {"split_payload", [](ModelData& m) { m.cells[0] = cell_of(model::CellKind::Split, m.parts[0].split_count); }},
    {"layered_payload", [](ModelData& m) { m.cells[0] = cell_of(model::CellKind::Layered, 0x3fff); }},
    {"split_child_payload", [](ModelData& m) { split_child(m, 3) = cell_of(model::CellKind::Layered, 0x3fff); }},
    {"split_of_itself",
     [](ModelData& m) {
         // Every cell of the part is this one split, and so are its children: endless if nobody counted.
         model::Part& p = m.parts[0];
         for (std::uint32_t i = 0; i < p.cell_count; ++i)
             if (const model::CentralCell cell{m.cells[p.first_cell + i]}; cell.kind() == model::CellKind::Split) {
                 const std::size_t record = model::k_split_size * (p.first_split + std::size_t(cell.payload()));
                 for (std::uint32_t k = 0; k < 4; ++k) m.splits[record + model::k_split_cells + k] = cell.word;
                 return;
             }
         throw std::logic_error("the model has no split cell");
     }},
    {"layered_record_behind_pool",
     [](ModelData& m) {
         model::Part& p = m.parts[0];
         const std::uint32_t last = p.pool_count - 1;
         m.specials[p.first_special] = last;
         m.pool[p.first_pool + last] = 15;
         m.cells[p.first_cell] = cell_of(model::CellKind::Layered, 0);
     }},
    {"vertex_nan", [](ModelData& m) { m.vertices[7] = k_nan; }},
    {"vertex_inf", [](ModelData& m) { m.vertices.back() = k_inf; }},
    {"vertices_not_by_three", [](ModelData& m) { m.vertices.push_back(0); }},
    {"vertices_missing", [](ModelData& m) { m.vertices.clear(); }},
    {"triangle_index", [](ModelData& m) { m.triangles16[5] = static_cast<std::uint16_t>(m.vertices.size() / 3); }},
    {"triangles_not_by_three", [](ModelData& m) { m.triangles16.pop_back(); }},
    {"triangles_of_both_widths", [](ModelData& m) { m.triangles32.assign(3, 0); }},
    {"triangle_part_missing_one", [](ModelData& m) { m.triangle_part.pop_back(); }},
    {"triangle_of_no_part", [](ModelData& m) { m.triangle_part[0] = static_cast<std::uint16_t>(m.parts.size()); }},
    {"locator_origin_nan", [](ModelData& m) { m.locator.origin[2] = k_nan; }},
    {"locator_origin_inf", [](ModelData& m) { m.locator.origin[0] = -k_inf; }},
    {"locator_cell_nan", [](ModelData& m) { m.locator.cell = k_nan; }},
    {"locator_cell_inf", [](ModelData& m) { m.locator.cell = k_inf; }},
    {"locator_cell_zero", [](ModelData& m) { m.locator.cell = 0; }},
    {"locator_cell_negative", [](ModelData& m) { m.locator.cell = -m.locator.cell; }},
    {"locator_bricks_zero", [](ModelData& m) { m.locator.bricks[1] = 0; }},
    {"locator_bricks_one_more", [](ModelData& m) { ++m.locator.bricks[2]; }},
    {"locator_bricks_wrap_around", [](ModelData& m) { m.locator.bricks[0] += 0x80000000u; }},
    {"locator_bricks_huge",
     [](ModelData& m) {
         // As many as are stored, in a row that is longer than a column of cells may be.
         m.locator.bricks[0] = 300;
         m.locator.bricks[1] = m.locator.bricks[2] = 1;
         m.bricks.assign(300, m.bricks.front());
     }},
    {"locator_header_without_bricks",
     [](ModelData& m) {
         m.bricks.clear();
         m.locator_cells.clear();
         m.part_lists.clear();
         m.planes.clear();
         m.seeds.clear();
     }},
    {"cells_without_bricks",
     [](ModelData& m) {
         m.bricks.clear();
         m.locator = {};
     }},
    {"seeds_without_bricks",
     [](ModelData& m) {
         m.bricks.clear();
         m.locator_cells.clear();
         m.part_lists.clear();
         m.locator = {};
     }},
    {"bricks_missing_one", [](ModelData& m) { m.bricks.pop_back(); }},
    {"brick_beyond_cells", [](ModelData& m) { stored_brick(m) = static_cast<std::uint32_t>(m.locator_cells.size() - 63); }},
    {"brick_far_away", [](ModelData& m) { stored_brick(m) = 0x3fffffffu; }},
    {"deep_brick_beyond_cells",
     [](ModelData& m) { stored_brick(m) = model::LocatorBrick::k_deep | static_cast<std::uint32_t>(m.locator_cells.size()); }},
    {"deep_brick_far_away", [](ModelData& m) { stored_brick(m) = 0x7fffffffu; }},
    {"deep_brick_of_a_free_cell",
     [](ModelData& m) {
         // What a deep brick holds is read as occupied, so that a free cell's gap would be an index of seeds.
         m.locator_cells.push_back(0xfffffffcu);
         stored_brick(m) = model::LocatorBrick::k_deep | static_cast<std::uint32_t>(m.locator_cells.size() - 1);
     }},
    {"eighths_beyond_cells",
     [](ModelData& m) {
         std::uint32_t& cell = occupied_cell(m);
         cell = model::LocatorCell::divided(static_cast<std::uint32_t>(m.locator_cells.size() - 7)).word;
     }},
    {"eighths_of_their_own_eighth",
     [](ModelData& m) {
         std::uint32_t& cell = occupied_cell(m);
         cell = model::LocatorCell::divided(static_cast<std::uint32_t>(&cell - m.locator_cells.data())).word;
     }},
    {"bounds_missing_one", [](ModelData& m) { m.distance.bounds.pop_back(); }},
    {"bounds_missing_eight", [](ModelData& m) { m.distance.bounds.resize(m.distance.bounds.size() - 8); }},
    {"bounds_beyond_end", [](ModelData& m) { m.distance.bounds[0] = 0x7fff; }},
    {"bounds_that_go_around", [](ModelData& m) { m.distance.bounds[divided_bound(m)] = 0; }},
    {"bounds_of_themselves",
     [](ModelData& m) {
         const std::size_t at = divided_bound(m);
         m.distance.bounds[at] = static_cast<std::uint16_t>(at / 8);
     }},
    {"bounds_root_nan", [](ModelData& m) { m.distance.header.root[1] = k_nan; }},
    {"bounds_half_zero", [](ModelData& m) { m.distance.header.half = 0; }},
    {"bounds_half_inf", [](ModelData& m) { m.distance.header.half = k_inf; }},
    {"band_negative", [](ModelData& m) { m.distance.header.band = -1; }},
    {"band_nan", [](ModelData& m) { m.distance.header.band = k_nan; }},
    {"hierarchy_entries_more", [](ModelData& m) { m.distance.header.entries += model::k_hierarchy_leaf; }},
    {"hierarchy_entries_none", [](ModelData& m) { m.distance.header.entries = 0; }},
    {"hierarchy_entries_huge", [](ModelData& m) { m.distance.header.entries = 0xffffffffu; }},
    {"hierarchy_entries_missing", [](ModelData& m) { m.distance.entries16.clear(); }},
    {"hierarchy_entries_missing_some", [](ModelData& m) { m.distance.entries16.pop_back(); }},
    {"hierarchy_entries_twice",
     [](ModelData& m) { m.distance.entries32.assign(m.distance.entries16.begin(), m.distance.entries16.end()); }},
    {"hierarchy_entry_of_no_triangle", [](ModelData& m) { m.distance.entries16.back() = 0xffff; }},
    {"hierarchy_groups_missing_one", [](ModelData& m) { m.distance.groups.pop_back(); }},
    {"hierarchy_group_origin_nan", [](ModelData& m) { m.distance.groups[0].origin[2] = k_nan; }},
    {"hierarchy_group_step_zero", [](ModelData& m) { m.distance.groups[0].step = 0; }},
    {"hierarchy_nodes_missing", [](ModelData& m) { m.distance.nodes.clear(); }},
    {"hierarchy_nodes_one_more", [](ModelData& m) { m.distance.nodes.push_back(m.distance.nodes.back()); }},
    {"hierarchy_node_origin_inf", [](ModelData& m) { m.distance.nodes[0].origin[0] = k_inf; }},
    {"hierarchy_node_step_nan", [](ModelData& m) { m.distance.nodes[0].step = k_nan; }},
    {"hierarchy_without_a_mesh",
     [](ModelData& m) {
         m.vertices.clear();
         m.triangles16.clear();
         m.triangle_part.clear();
         m.near_bricks.clear();
         m.near.clear();
         m.rises.clear();
     }},
    {"near_missing", [](ModelData& m) { m.near.clear(); }},
    {"near_bricks_missing", [](ModelData& m) { m.near_bricks.clear(); }},
    {"near_bricks_missing_one", [](ModelData& m) { m.near_bricks.pop_back(); }},
    {"near_brick_of_no_record", [](ModelData& m) { stored_near(m) = model::k_no_candidates; }},
    {"near_brick_beyond_end", [](ModelData& m) { stored_near(m) = static_cast<std::uint32_t>(m.near.size() - 2); }},
    {"near_record_of_other_cells", [](ModelData& m) { m.near[stored_near(m)] ^= 1; }},
    {"near_list_that_ends_before_it_begins", [](ModelData& m) { m.near[stored_near(m) + model::CandidateRecord::k_head + 1] = 0xffff; }},
    {"near_list_beyond_end",
     [](ModelData& m) {
         for (std::size_t i = stored_near(m) + model::CandidateRecord::k_head; i < m.near.size(); ++i) m.near[i] = 0xffff;
     }},
    {"near_triangles_beyond_end", [](ModelData& m) { m.near[stored_near(m) + 4] = 0xffff; }},
    {"near_list_of_other_triangles", [](ModelData& m) { first_list(m)[0] ^= 1; }},
    {"near_list_without_triangles", [](ModelData& m) { first_list(m)[1] = 0; }},
    {"near_list_of_no_table", [](ModelData& m) { last_word(m) = 0xffff; }},
    {"near_triangle_that_is_none",
     [](ModelData& m) {
         const model::CandidateRecord r = model::candidate_record(m.near.data() + stored_near(m), false);
         m.near[static_cast<std::size_t>(r.table - m.near.data())] = 0xffff;
     }},
    {"locator_cells_missing", [](ModelData& m) { m.locator_cells.clear(); }},
    {"locator_cells_missing_one", [](ModelData& m) { m.locator_cells.pop_back(); }},
    {"cell_list_beyond_end",
     [](ModelData& m) {
         std::uint32_t& cell = occupied_cell(m);
         cell = (cell & ~(0x1ffu << 2)) | static_cast<std::uint32_t>(m.part_lists.size()) << 2;
     }},
    {"cell_seed_beyond_end",
     [](ModelData& m) {
         std::uint32_t& cell = cell_of_a_chain(m);
         cell = (cell & 0x3fffu) | static_cast<std::uint32_t>(m.seeds.size()) << 14;
     }},
    {"cell_planes_beyond_end",
     [](ModelData& m) {
         std::uint32_t& cell = flat_cell(m);
         cell = (cell & 0x3fffu) | static_cast<std::uint32_t>(m.planes.size() - model::LocatorCell{cell}.planes() + 1) << 14;
     }},
    {"planes_missing", [](ModelData& m) { m.planes.clear(); }},
    {"plane_of_no_part",
     [](ModelData& m) { m.planes[model::LocatorCell{flat_cell(m)}.first()] |= 3u << 29; }},
    {"plane_reach_of_nothing", [](ModelData& m) { m.locator.plane_reach = 0; }},
    {"plane_reach_nan", [](ModelData& m) { m.locator.plane_reach = NAN; }},
    {"rises_missing", [](ModelData& m) { m.rises.clear(); }},
    {"rises_missing_some", [](ModelData& m) { m.rises.resize(m.rises.size() - 4); }},
    {"cell_seed_far_away", [](ModelData& m) { occupied_cell(m) |= 0xffffc000u; }},
    {"part_lists_missing", [](ModelData& m) { m.part_lists.clear(); }},
    {"list_of_no_part",
     [](ModelData& m) { m.part_lists[0] = (m.part_lists[0] & 0xffff00ffu) | static_cast<std::uint32_t>(m.parts.size()) << 8; }},
    {"seeds_missing",
     [](ModelData& m) {
         (void)cell_of_a_chain(m);
         m.seeds.clear();
     }},
    {"seed_of_no_part",
     [](ModelData& m) {
         std::uint32_t& direction = m.seeds[model::LocatorCell{cell_of_a_chain(m)}.first()].direction;
         direction = (direction & ~0xffu) | static_cast<std::uint32_t>(m.parts.size());
     }},
    {"seed_chain_without_end",
     [](ModelData& m) {
         (void)cell_of_a_chain(m);
         m.seeds.back().extent &= ~model::k_last_seed;
     }},
    {"seed_chain_too_long",
     [](ModelData& m) {
         const std::uint32_t first = model::LocatorCell{cell_of_a_chain(m)}.first();
         for (std::uint32_t k = 0; k < model::k_max_seeds; ++k) {
             m.seeds[first + k].extent &= ~model::k_last_seed;
             m.seeds[first + k].direction &= ~0xffu;
         }
     }},
    {"seed_choice_beyond_chain", [](ModelData& m) { m.seeds[model::LocatorCell{cell_of_a_chain(m)}.first() - 1].direction |= 7u << 21; }},
    {"seed_chain_without_choices",
     [](ModelData& m) {
         // The chain starts the array, so that nothing stands before it.
         std::uint32_t& cell = cell_of_a_chain(m);
         m.seeds.erase(m.seeds.begin(), m.seeds.begin() + model::LocatorCell{cell}.first());
         const std::uint32_t kept = cell & 0x3fffu;
         for (std::uint32_t& p : m.locator_cells) p = model::LocatorCell{p}.is_free() ? p : kept;
     }},
    {"locator_of_more_parts_than_a_byte_names",
     [](ModelData& m) {
         while (m.parts.size() < 300) m.parts.push_back(m.parts[0]);
     }},
};

TEST(ModelFile, AGridOfAbsurdSizeIsSafeToAsk)
{
    for (const float cell : {1e-45f, 1e-38f, 1e-20f, 1e20f, 3e38f})
        for (const float origin : {0.f, -3e38f, 3e38f}) {
            const ParseStatus status = parse_changed([&](ModelData& m) {
                m.locator.cell = cell;
                m.locator.origin[1] = origin;
            });
            EXPECT_TRUE(status == ParseStatus::Ok || status == ParseStatus::BadValue) << model::to_string(status);
        }
}

/// Asks a model again and again, each time without another field of its root table: a writer may leave an array out instead of
/// storing an empty one, and its pointer is null.
void query_without_each_field(const ModelData& data)
{
    const std::vector<std::byte> good = serialize(data);
    const auto read = [&](std::size_t at, auto value) {
        std::memcpy(&value, good.data() + at, sizeof value);
        return value;
    };
    const std::size_t table = read(0, std::uint32_t{});
    const std::size_t vtable = static_cast<std::size_t>(static_cast<std::int64_t>(table) - read(table, std::int32_t{}));
    const std::size_t end = vtable + read(vtable, std::uint16_t{});
    ASSERT_GT(end, vtable + 40);
    for (std::size_t slot = vtable + 4; slot < end; slot += 2) {
        std::vector<std::byte> bytes = good;
        bytes[slot] = bytes[slot + 1] = std::byte{0};
        (void)parse_and_query(bytes);
    }
}

TEST(ModelFile, AFieldThatIsNotThereIsNeverFollowed)
{
    query_without_each_field(torus_model());
    test::Baked surface{{}, bake::bake(test::small_torus(), false, {.exact = false})};
    query_without_each_field(surface.result.model);
}

TEST(ModelFile, AFieldThatIsNotThereIsNeverFollowedFromAnEmptyGrid)
{
    ModelData empty_grid = torus_model();
    for (std::uint32_t& b : empty_grid.bricks) b = model::LocatorBrick::k_free;
    empty_grid.locator_cells.clear();
    query_without_each_field(empty_grid);
}

TEST(ModelFile, ALocatorOverPartsWithoutACentralMapIsRefused)
{
    test::Baked normal = test::baked(test::small_torus(), {.projection = model::Projection::Normal, .exact = false});
    ModelData& m = normal.result.model;
    const ModelData& central = torus_model();
    m.locator = central.locator;
    m.bricks = central.bricks;
    m.locator_cells = central.locator_cells;
    m.part_lists = central.part_lists;
    m.planes = central.planes;
    m.seeds = central.seeds;
    // Whatever that model's parts: the first alone.
    for (std::uint32_t& list : m.part_lists) list = 0xffffff00u;
    for (model::Seed& seed : m.seeds) seed.direction &= ~0xffu;
    for (std::uint32_t& plane : m.planes) plane &= ~(3u << 29);
    for (std::uint32_t& p : m.locator_cells)
        if (model::LocatorCell{p}.is_divided()) {
            p = 0;
        } else if (!model::LocatorCell{p}.is_free() && model::LocatorCell{p}.planes() == 0) {
            std::uint32_t last = model::LocatorCell{p}.first();
            while (!model::is_last_seed(m.seeds[last])) ++last;
            p = (p & 0x3fffu) | last << 14;
        }
    for (model::Part& part : m.parts) part.base = 0;
    const ParseStatus status = parse_and_query(serialize(m));
    EXPECT_TRUE(status == ParseStatus::BadStructure || status == ParseStatus::BadValue) << model::to_string(status);
}

INSTANTIATE_TEST_SUITE_P(Format, InconsistentModel, testing::ValuesIn(k_lies),
                         [](const auto& lie) { return std::string(lie.param.name); });

/// A folder of its own, removed with all in it.
class ModelFolder : public testing::Test {
protected:
    void SetUp() override
    {
        std::string pattern = (fs::temp_directory_path() / "sqmap-model-XXXXXX").string();
        ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
        folder_ = pattern;
    }
    void TearDown() override
    {
        fs::permissions(folder_, fs::perms::owner_all);
        fs::remove_all(folder_);
    }
    [[nodiscard]] std::size_t files() const
    {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}));
    }
    static std::vector<std::byte> read(const fs::path& path)
    {
        std::ifstream in(path, std::ios::binary);
        const std::string text((std::istreambuf_iterator<char>(in)), {});
        const auto* begin = reinterpret_cast<const std::byte*>(text.data());
        return {begin, begin + text.size()};
    }
    static void write(const fs::path& path, std::span<const std::byte> bytes)
    {
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
    fs::path folder_;
};

TEST(ModelHash, CoversFiguresAndProvenance)
{
    const std::uint64_t hash = model::content_hash(torus_model().view());
    model::ModelData other = torus_model();
    other.measured.q2_share += 1e-9;
    EXPECT_NE(model::content_hash(other.view()), hash);
    other = torus_model();
    other.measured.missed ^= 1;
    EXPECT_NE(model::content_hash(other.view()), hash);
    other = torus_model();
    other.source += ' ';
    EXPECT_NE(model::content_hash(other.view()), hash);
    other = torus_model();
    other.mesh_hash ^= 1;
    EXPECT_NE(model::content_hash(other.view()), hash);
    // A letter moved from one text to the next is a difference too.
    other = torus_model();
    other.made_by += other.source.front();
    other.source.erase(0, 1);
    EXPECT_NE(model::content_hash(other.view()), hash);
}

TEST_F(ModelFolder, AWrittenModelIsMappedBackWholeAndAlone)
{
    const fs::path path = folder_ / "a.sqmap";
    write_model(torus_model(), path);
    EXPECT_EQ(files(), 1u);
    EXPECT_EQ(read(path), serialize(torus_model()));
    MappedModel first(path);
    EXPECT_EQ(first.view().made_by, "test");
    EXPECT_EQ(first.view().source, "torus.obj");
    EXPECT_EQ(first.view().options, "none");
    EXPECT_NE(first.view().mesh_hash, 0u);
    EXPECT_EQ(first.view().mesh_hash, torus_model().mesh_hash);
    EXPECT_EQ(first.view().measured.points, torus_model().measured.points);
    EXPECT_EQ(first.view().measured.depth_p99, torus_model().measured.depth_p99);
    EXPECT_EQ(first.view().measured.eq35_mean, torus_model().measured.eq35_mean);
    EXPECT_EQ(model::content_hash(first.view()), model::content_hash(torus_model().view()));
    const MappedModel moved(std::move(first));
    interrogate(moved.view(), 2);
    EXPECT_EQ(moved.size(), fs::file_size(path));
    EXPECT_EQ(moved.bytes().size(), moved.size());
}

TEST_F(ModelFolder, AModelFromBeforeTheMeshHashIsRead)
{
    // A default is not stored: these are the bytes of a writer that does not know the field.
    model::ModelData old = torus_model();
    old.mesh_hash = 0;
    const fs::path path = folder_ / "old.sqmap";
    write_model(old, path);
    const MappedModel mapped(path);
    EXPECT_EQ(mapped.view().mesh_hash, 0u);
    interrogate(mapped.view(), 3);
}

TEST_F(ModelFolder, WritingReplacesAnOldFileWhole)
{
    const fs::path path = folder_ / "a.sqmap";
    write(path, std::vector<std::byte>(3'000'000, std::byte{7}));
    write_model(torus_model(), path);
    EXPECT_EQ(read(path), serialize(torus_model()));
    EXPECT_EQ(files(), 1u);
}

TEST_F(ModelFolder, AFailedWriteLeavesTheOldFileAndNothingElse)
{
    // The rename fails where the target is a folder that is not empty: after everything was written.
    const fs::path path = folder_ / "a.sqmap";
    fs::create_directory(path);
    write(path / "kept", std::vector<std::byte>(10, std::byte{1}));
    EXPECT_THROW(write_model(torus_model(), path), ModelFileError);
    EXPECT_EQ(files(), 1u);
    EXPECT_EQ(read(path / "kept").size(), 10u);
}

TEST_F(ModelFolder, AFolderThatIsNotThereIsSaidSo)
{
    EXPECT_THROW(write_model(torus_model(), folder_ / "no" / "such" / "a.sqmap"), ModelFileError);
    EXPECT_EQ(files(), 0u);
}

TEST_F(ModelFolder, AnUnwritableFolderKeepsItsOldFile)
{
    if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
    const fs::path path = folder_ / "a.sqmap";
    write(path, std::vector<std::byte>(5, std::byte{1}));
    fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
    EXPECT_THROW(write_model(torus_model(), path), ModelFileError);
    EXPECT_EQ(read(path).size(), 5u);
    EXPECT_EQ(files(), 1u);
}

TEST_F(ModelFolder, AFullDiskLeavesNothingBehind)
{
    // A limit on the size of files stands in for a full disk: write() fails in the middle.
    const fs::path path = folder_ / "a.sqmap";
    const auto write_under_limit = [&] {
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limit = {4096, 4096};
        ::setrlimit(RLIMIT_FSIZE, &limit);
        try {
            write_model(torus_model(), path);
        } catch (const ModelFileError&) {
            std::_Exit(3);
        }
        std::_Exit(0);
    };
    EXPECT_EXIT(write_under_limit(), testing::ExitedWithCode(3), "");
    EXPECT_EQ(files(), 0u);
}

TEST_F(ModelFolder, WhatIsNoModelIsNotMapped)
{
    EXPECT_THROW(MappedModel(folder_ / "absent.sqmap"), ModelFileError);
    EXPECT_THROW(MappedModel{folder_}, ModelFileError);
    write(folder_ / "empty.sqmap", {});
    EXPECT_THROW(MappedModel(folder_ / "empty.sqmap"), ModelFileError);
    write(folder_ / "short.sqmap", std::vector<std::byte>(5, std::byte{'S'}));
    EXPECT_THROW(MappedModel(folder_ / "short.sqmap"), ModelFileError);
    const std::string text = "OFF\n8 12 0\n0 0 0\n1 0 0\n";
    write(folder_ / "mesh.off", std::as_bytes(std::span(text)));
    EXPECT_THROW(MappedModel(folder_ / "mesh.off"), ModelFileError);
    std::vector<std::byte> bytes = serialize(torus_model());
    bytes.resize(bytes.size() / 2);
    write(folder_ / "half.sqmap", bytes);
    try {
        const MappedModel half(folder_ / "half.sqmap");
        ADD_FAILURE() << "half a model was mapped";
    } catch (const ModelFileError& e) {
        EXPECT_NE(std::string(e.what()).find("half.sqmap"), std::string::npos) << e.what();
    }
}

TEST(ModelFile, TheSectionsAddUpToTheFile)
{
    const std::vector<std::byte> bytes = serialize(torus_model());
    const SectionBytes s = section_bytes(torus_model().view(), bytes.size());
    const std::size_t sections = s.superquadrics + s.map + s.locator + s.exact + s.mesh + s.distance;
    EXPECT_EQ(s.total, bytes.size());
    EXPECT_LT(sections, s.total);
    EXPECT_LT(s.total - sections, 2000u) << "more than the header, the strings and FlatBuffers' own tables";
}

}  // namespace
}  // namespace sqmap::io
