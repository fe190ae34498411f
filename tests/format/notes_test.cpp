// Notes in the model file: what bake said comes back, and damage to it is seen.
#include "queried_model.h"

#include "sqmap/bake/notes.h"
#include "sqmap/mesh/shapes.h"
#include "sqmap/paper/bake.h"
#include "sqmap/paper/model_file.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace sqmap::io {
namespace {

using model::NoteRecord;
using model::ParseStatus;

/// A note of each kind, and of each kind of repair and warning.
std::vector<Note> all_notes()
{
    std::vector<Note> out{MovedNote{{0.125, 0.25, 0.5}, {1, 2, 3}, 7},
                          MovedBoundaryNote{{0.1, 0.2, 0.3}, 7},
                          MadeUpNote{0.0625},
                          OffTargetNote{0.5, 0.75},
                          DoubtNote{3, 4000, 0.5, true},
                          DoubtNote{0, 4000, 0.9, false}};
    for (int kind = 0; kind <= static_cast<int>(mesh::RepairKind::Enclosed); ++kind)
        out.emplace_back(mesh::RepairNote{static_cast<mesh::RepairKind>(kind), 1u << kind});
    for (int kind = 0; kind <= static_cast<int>(mesh::WarningKind::Tolerance); ++kind)
        out.emplace_back(mesh::Warning{static_cast<mesh::WarningKind>(kind), 12, kind % 2 == 0, 0.01, 0.002, 5000, 4000});
    return out;
}

std::vector<std::byte> with_notes(std::span<const NoteRecord> notes) { return serialize(torus_model(), notes); }

TEST(Notes, SurviveTheFile)
{
    const std::vector<Note> notes = all_notes();
    Bytes bytes(with_notes(records_of(notes)));
    model::ModelView view;
    ASSERT_EQ(model::parse(bytes.span(), view), ParseStatus::Ok);
    EXPECT_EQ(model::content_hash(view), model::content_hash(torus_model().view()));
    for (const mesh::SettingNames& names : {mesh::k_cpp_settings, mesh::SettingNames({}, " ")})
        EXPECT_EQ(words(notes_of(model::notes_of(bytes.span())), names), words(notes, names));
    EXPECT_EQ(paper::notes_of(bytes.span()).data(), model::notes_of(bytes.span()).data());
}

TEST(Notes, AreNoneInAFileWithout)
{
    Bytes bytes(serialize(torus_model()));
    EXPECT_TRUE(model::notes_of(bytes.span()).empty());
    EXPECT_TRUE(paper::notes_of(bytes.span()).empty());
    EXPECT_EQ(with_notes({}), serialize(torus_model()));
}

TEST(Notes, OfPaperModelsAreReadByThePaperLibrary)
{
    const paper::ModelData data = paper::bake(mesh::torus(), true, {}, paper::MapOptions{}).model;
    const std::vector<Note> notes = all_notes();
    Bytes bytes(paper::serialize(data, records_of(notes)));
    paper::AnyModel model;
    ASSERT_EQ(model.parse(bytes.span()), ParseStatus::Ok);
    ASSERT_NE(model.paper(), nullptr);
    EXPECT_EQ(words(notes_of(paper::notes_of(bytes.span()))), words(notes));
    EXPECT_TRUE(model::notes_of(bytes.span()).empty());
}

TEST(Notes, AreCheckedByTheirHash)
{
    std::vector<NoteRecord> records = records_of(all_notes());
    std::vector<std::byte> whole = with_notes(records);
    const std::span<const NoteRecord> stored = model::notes_of(whole);
    const auto at = static_cast<std::size_t>(reinterpret_cast<const std::byte*>(stored.data()) - whole.data());
    for (std::size_t i = 0; i < stored.size_bytes(); ++i) {
        std::vector<std::byte> damaged = whole;
        damaged[at + i] ^= std::byte{1};
        ASSERT_EQ(parse_and_query(damaged), ParseStatus::BadHash) << i;
    }
}

TEST(Notes, WithWrongValuesAreRefused)
{
    const NoteRecord good = record_of(mesh::RepairNote{mesh::RepairKind::Flipped, 3});
    ASSERT_EQ(parse_and_query(with_notes({&good, 1})), ParseStatus::Ok);
    const auto refused = [&](auto&& change) {
        NoteRecord bad = good;
        change(bad);
        return parse_and_query(with_notes({&bad, 1})) == ParseStatus::BadValue;
    };
    EXPECT_TRUE(refused([](NoteRecord& r) { r.kind = static_cast<model::NoteKind>(0); }));
    EXPECT_TRUE(refused([](NoteRecord& r) { r.kind = static_cast<model::NoteKind>(8); }));
    EXPECT_TRUE(refused([](NoteRecord& r) { r.flag = 2; }));
    EXPECT_TRUE(refused([](NoteRecord& r) { r.name[0] = '\0'; }));
    EXPECT_TRUE(refused([](NoteRecord& r) { r.name[2] = '\n'; }));
    EXPECT_TRUE(refused([](NoteRecord& r) { std::memset(r.name, 'a', sizeof r.name); }));
    EXPECT_TRUE(refused([](NoteRecord& r) { r.name[20] = 'a'; })) << "behind the end of the name";
    EXPECT_TRUE(refused([](NoteRecord& r) { r.kind = model::NoteKind::MadeUp; })) << "which has no name";
    EXPECT_TRUE(refused([](NoteRecord& r) { r.values[3] = std::numeric_limits<double>::quiet_NaN(); }));
}

// A repair that a later version knows.
TEST(Notes, OfAnUnknownNameAreLeftOut)
{
    std::vector<NoteRecord> records = records_of(std::vector<Note>{MadeUpNote{0.5}, MadeUpNote{0.25}});
    records[0].kind = model::NoteKind::Repaired;
    std::memcpy(records[0].name, "polished", 8);
    ASSERT_EQ(parse_and_query(with_notes(records)), ParseStatus::Ok);
    EXPECT_EQ(words(notes_of(records)), words(std::vector<Note>{MadeUpNote{0.25}}));
}

TEST(Notes, KeepNoNumberThatIsNotFinite)
{
    const NoteRecord record = record_of(MadeUpNote{std::numeric_limits<double>::infinity()});
    EXPECT_EQ(record.values[0], 0);
    EXPECT_EQ(parse_and_query(with_notes({&record, 1})), ParseStatus::Ok);
}

}  // namespace
}  // namespace sqmap::io
