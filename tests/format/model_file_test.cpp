// The .sqmap file: what is written comes back, and says what it is.
#include "queried_model.h"

#include "model/schema.h"
#include "paper_generated.h"
#include "sqmap/paper/model_file.h"
#include "sqmap/query/point.h"
#include "support/baked_shapes.h"

#include <flatbuffers/minireflect.h>
#include <gtest/gtest.h>

#include <cstring>
#include <string_view>

namespace sqmap::io {
namespace {

using model::ModelData;
using model::ModelView;
using model::ParseStatus;

template <class T>
bool same_array(std::span<const T> a, const std::vector<T>& b)
{
    return a.size() == b.size() && (b.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

TEST(ModelFile, WhatIsSerializedParsesToTheSameArrays)
{
    const ModelData& data = torus_model();
    Bytes bytes(serialize(data));
    ModelView v;
    ASSERT_EQ(model::parse(bytes.span(), v), ParseStatus::Ok);
    EXPECT_EQ(std::memcmp(&v.header, &data.header, sizeof v.header), 0);
    EXPECT_EQ(std::memcmp(&v.locator, &data.locator, sizeof v.locator), 0);
    const auto expect_same = [](const char* name, const auto& read, const auto& written) {
        EXPECT_TRUE(same_array(read, written)) << name;
    };
    model::each_surface_array(expect_same, v, data);
    model::each_cell_array(expect_same, v, data);
    ASSERT_FALSE(data.polytope_ends.empty());
    model::BoundArrays<model::ArrayView>::each(expect_same, v, data);
    EXPECT_EQ(std::memcmp(&v.distance.header, &data.distance.header, sizeof v.distance.header), 0);
    model::DistanceArrays<model::ArrayView>::each(expect_same, v.distance, data.distance);
    interrogate(v, 3);
    EXPECT_TRUE(model::has_locator(v));
}

/// The size of a vector's element, by the schema; 0: there is no such vector.
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
    model::each_surface_array(expect_field, v);
    model::each_cell_array(expect_field, v);
    model::BoundArrays<model::ArrayView>::each(expect_field, v);
    table = paper::fb::MapsTypeTable();
    const paper::ModelView paper;
    paper::ModelMaps<model::ArrayView>::each(expect_field, paper.maps);
    table = model::fb::DistanceTypeTable();
    model::DistanceArrays<model::ArrayView>::each(expect_field, v.distance);
}

// As models of before there were polytopes.
TEST(ModelFile, AModelWithoutPolytopesParses)
{
    ModelData data = torus_model();
    data.polytope_ends.clear();
    data.polytope_sides.clear();
    data.bound_figures.clear();
    Bytes bytes(serialize(data));
    ModelView v;
    ASSERT_EQ(model::parse(bytes.span(), v), ParseStatus::Ok);
    EXPECT_TRUE(model::polytope_of(v, 0).empty());
    interrogate(v, 3);
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
            ASSERT_EQ(a.witness, b.witness);
            ASSERT_EQ(a.normal, b.normal);
        }
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

/// The position of a 32-bit value in the bytes, if it stands there once.
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

// Format 11 had the paper's maps in a table of the one kind of file that there was.
TEST(ModelFile, AnOldPaperModelIsToBeBakedAgain)
{
    flatbuffers::FlatBufferBuilder builder;
    const auto maps = model::fb::CreateFormerMaps(builder);
    model::fb::ModelBuilder table(builder);
    table.add_former_maps(maps);
    table.add_version(model::k_format_version);
    model::fb::FinishModelBuffer(builder, table.Finish());
    const auto* first = reinterpret_cast<const std::byte*>(builder.GetBufferPointer());
    Bytes bytes({first, builder.GetSize()});
    ModelView view;
    EXPECT_EQ(model::parse(bytes.span(), view), ParseStatus::WrongVersion);
    EXPECT_EQ(paper::AnyModel().parse(bytes.span()), ParseStatus::WrongVersion);
    EXPECT_NE(std::string_view(model::cure_of(ParseStatus::WrongVersion)).find("bake the mesh again"), std::string_view::npos);
}

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

TEST(ModelFile, TheSectionsAddUpToTheFile)
{
    const std::vector<std::byte> bytes = serialize(torus_model());
    const SectionBytes s = section_bytes(torus_model().view(), bytes.size());
    const std::size_t sections = s.superquadrics + s.polytopes + s.map + s.locator + s.exact + s.mesh + s.distance + s.input;
    EXPECT_EQ(s.total, bytes.size());
    EXPECT_LT(sections, s.total);
    EXPECT_LT(s.total - sections, 2000u) << "more than the header, the strings and FlatBuffers' own tables";
}

}  // namespace
}  // namespace sqmap::io
